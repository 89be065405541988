// Quadrature rules and lengths computed with them.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "back.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

TEST_CASE("Gauss rules are symmetric, positive and exact to degree 2n − 1") {
    for (int n = 1; n <= 20; ++n) {
        CAPTURE(n);
        const auto rule = gauss_legendre(n);
        REQUIRE(rule.size() == static_cast<std::size_t>(n));
        for (std::size_t i = 0; i < rule.size(); ++i) {
            CHECK(rule.w[i] > 0);
            CHECK(rule.t[i] > (i == 0 ? 0 : rule.t[i - 1]));
            CHECK(rule.t[i] < 1);
            CHECK(std::abs(rule.t[i] + rule.t[rule.size() - 1 - i] - 1) < 1e-15);
        }
        const auto moment = [&](int degree) {
            double sum = 0;
            for (std::size_t i = 0; i < rule.size(); ++i) sum += rule.w[i] * std::pow(rule.t[i], degree);
            return sum;
        };
        for (int degree = 0; degree < 2 * n; ++degree) CHECK(std::abs(moment(degree) * (degree + 1) - 1) < 1e-13);
        if (n < 10) CHECK(std::abs(moment(2 * n) * (2 * n + 1) - 1) > 1e-12);  // and not to a higher degree
    }
}

TEST_CASE("Riemannian lengths agree with closed forms") {
    const auto rule = gauss_legendre(report_points);
    property("in a constant metric a straight edge has length sqrt(eᵀ M e)",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const LogMetric<3> l{dice.symmetric<3>(3)};
                 const auto back = back_of(unit_box<3>(3, seed + 1), [&](const Vec<3>&) { return l; });
                 const auto edge =
                     QuadraticEdge<3>::straight(random_point(back.mesh, dice), random_point(back.mesh, dice));
                 const double expected = std::sqrt(SpectralMetric<3>(l).length_squared(edge.chord()));
                 const auto found = riemannian_length(back, edge, rule, ElementId(std::size_t{0}));
                 RC_ASSERT(std::abs(found.length - expected) < 1e-13 * expected);
                 RC_ASSERT(found.lost == 0);
             },
             {.count = 30});
    property("in an affine isotropic log-metric the length is that of ∫ e^{a + b t} dt", [&](std::uint64_t seed) {
        Dice dice(seed);
        const auto slope = dice.vector<2>(-2, 2);
        const double constant = dice.uniform(-1, 1);
        const auto back = back_of(unit_box<2>(4, seed + 1), [&](const Vec<2>& x) {
            return LogMetric<2>{(constant + dot(slope, x)) * Sym<2>::identity()};
        });
        const Vec<2> p{{dice.uniform(0.2, 0.8), dice.uniform(0.2, 0.8)}};
        const Vec<2> q{{dice.uniform(0.2, 0.8), dice.uniform(0.2, 0.8)}};
        const double a = 0.5 * (constant + dot(slope, p));
        const double b = 0.5 * dot(slope, q - p);
        RC_PRE(std::abs(b) > 1e-3);
        const double expected = distance(p, q) * std::exp(a) * std::expm1(b) / b;
        const auto edge = QuadraticEdge<2>::straight(p, q);
        RC_ASSERT(std::abs(riemannian_length(back, edge, rule, ElementId(std::size_t{3})).length - expected) <
                  1e-12 * expected);
        // The field of the three nodes is the same, and so is its length.
        const auto field = edge_field(back, edge, ElementId(std::size_t{3}));
        RC_ASSERT(std::abs(riemannian_length(field, edge, rule) - expected) < 1e-12 * expected);
    });
    property("a parabola in the Euclidean metric has its arc length", [&](std::uint64_t seed) {
        Dice dice(seed);
        const double c = dice.uniform(0.05, 0.5);
        const auto back = back_of(unit_box<2>(2, 1), [](const Vec<2>&) { return LogMetric<2>{}; });
        const QuadraticEdge<2> edge{{{0, 0}}, {{{0.5, c}}}, {{1, 0}}};  // y = 4c t(1−t)
        const double s = 4 * c;
        const double expected = 0.5 * std::sqrt(1 + s * s) + std::asinh(s) / (2 * s);
        const auto found = riemannian_length(back, edge, rule, ElementId(std::size_t{0}));
        RC_ASSERT(std::abs(found.length - expected) < 2e-5 * expected);
    });
}

TEST_CASE("samples outside the back mesh are counted") {
    const auto back = back_of(unit_box<2>(3, 1, 0), [](const Vec<2>&) { return LogMetric<2>{}; });
    const auto edge = QuadraticEdge<2>::straight(Vec<2>{{0.5, 0.5}}, Vec<2>{{0.5, 1.5}});
    const auto found = riemannian_length(back, edge, gauss_legendre(12), ElementId(std::size_t{0}));
    CHECK(found.outside == 6);  // half of the edge is outside the box
    CHECK(found.lost == 0);
    CHECK(found.length == doctest::Approx(1).epsilon(1e-14));
}
