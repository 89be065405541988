#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

import camber.core;
import camber.bezier;
import camber.validity;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

template <int D>
std::string in(const char* name) {
    return std::string(name) + " (" + std::to_string(D) + "D)";
}

template <int D>
double straight_det(const QuadraticSimplex<D, D>& s) {
    return bounded_jacobian(s).straight;
}

template <int D>
double sampled_minimum(const QuadraticSimplex<D, D>& s, int n) {
    double low = infinity;
    for (const auto& xi : elements::lattice<D>(n)) low = std::min(low, elements::jacobian_at<D>(s, xi));
    return low / std::abs(straight_det<D>(s));
}

template <int D>
void test_against_sampling() {
    property(in<D>("valid elements have no sample below the bound, and invalid ones a witness"),
             [] {
                 auto random = random_source();
                 const auto s = element<D>(random, uniform(random, 0, 0.35));
                 const double bound = uniform(random, 0, 0.5);
                 const auto validity = check_element<D>(s, bound);
                 const double sampled = sampled_minimum<D>(s, D == 2 ? 40 : 12);
                 if (validity.verdict == Verdict::valid) RC_ASSERT(sampled >= bound * (1 - 1e-12));
                 const auto j = bounded_jacobian(s);
                 const auto point = witness(j, bound);
                 RC_ASSERT(point.has_value() == (validity.verdict == Verdict::invalid));
                 if (point) RC_ASSERT(elements::jacobian_at<D>(s, *point) < bound * std::abs(j.straight) + 4 * j.error);
             },
             {400});
    property(in<D>("min_scaled_jacobian is below every sample and close to the minimum"),
             [] {
                 auto random = random_source();
                 const auto s = element<D>(random, uniform(random, 0, 0.5));
                 const int n = D == 2 ? 60 : 24;
                 const double sampled = sampled_minimum<D>(s, n);
                 const auto validity = check_element<D>(s, 0);
                 RC_ASSERT(validity.min_scaled_jacobian <= sampled + 1e-12);
                 // det J is a polynomial: between samples 1/n apart it can decrease by D²/(8 n²) of its second
                 // derivative, which is at most D (D − 1) · 4 times the largest coefficient.
                 double most = 0;
                 for (const double c : jacobian(s)) most = std::max(most, std::abs(c) / std::abs(straight_det<D>(s)));
                 const double dip = D * D * D * (D - 1) * most / (2.0 * n * n);
                 RC_ASSERT(validity.min_scaled_jacobian >=
                           sampled - dip - scaled_jacobian_tolerance * std::max(1.0, std::abs(sampled)));
             },
             {D == 2 ? 300 : 100});
}

template <int D>
void test_against_exact() {
    property(in<D>("verdicts agree with exact bisection of small integers"),
             [] {
                 auto random = random_source();
                 const auto n = integer_element<D>(random, 4, 1 + static_cast<std::int64_t>(random() % 3));
                 const Verdict exact = elements::exact_verdict<D>(elements::sixfold_coefficients<D>(n), 24);
                 const Verdict verdict = check_element<D>(elements::nodal<D>(n), 0).verdict;
                 if (verdict == Verdict::valid) RC_ASSERT(exact != Verdict::invalid);
                 if (verdict == Verdict::invalid) RC_ASSERT(exact != Verdict::valid);
                 // A verdict is undecided only if det J is within rounding of 0, or too close to it for the depth.
                 if (exact == Verdict::valid) RC_ASSERT(verdict == Verdict::valid);
                 RC_CLASSIFY(verdict == Verdict::valid, "valid");
                 RC_CLASSIFY(verdict == Verdict::invalid, "invalid");
                 RC_CLASSIFY(verdict == Verdict::undecided, "undecided");
             },
             {3000});
}

/// The same element under a unimodular shear by 2^20 and a shift by 2^30: det J is exactly the same, but the element is
/// thin, oblique (one part in a million of its length) and distant.
template <int D>
void test_anisotropy() {
    property(in<D>("thin, oblique and distant elements have the verdict of their plain images"),
             [] {
                 auto random = random_source();
                 auto n = integer_element<D>(random, 64, 1 + static_cast<std::int64_t>(random() % 40));
                 const auto before = check_element<D>(elements::nodal<D>(n), 1e-3);
                 for (auto& node : n) {
                     for (int c = 1; c < D; ++c) node[c] += (std::int64_t{1} << 20) * node[0];
                     for (auto& x : node) x += std::int64_t{1} << 30;
                 }
                 const auto after = check_element<D>(elements::nodal<D>(n), 1e-3);
                 RC_ASSERT(after.verdict == before.verdict);
                 RC_ASSERT(std::abs(after.min_scaled_jacobian - before.min_scaled_jacobian) <=
                           2 * scaled_jacobian_tolerance * std::max(1.0, std::abs(before.min_scaled_jacobian)));
             },
             {500});
}

template <int D>
void test_scaling() {
    property(in<D>("the verdict does not change with the unit of length"), [] {
        auto random = random_source();
        auto s = element<D>(random, uniform(random, 0, 0.4));
        const auto before = check_element<D>(s, 0.1);
        const double unit = std::ldexp(1.0, static_cast<int>(random() % 400) - 200);
        for (auto& p : s.control) p *= unit;
        const auto after = check_element<D>(s, 0.1);
        RC_ASSERT(after.verdict == before.verdict);
        RC_ASSERT(after.min_scaled_jacobian == before.min_scaled_jacobian);
    });
}

/// The minimum of a quadratic on a triangle in closed form: at a stationary point inside, on an edge, or at a vertex.
double closed_form_minimum(const std::array<double, 6>& c) {
    // c_200 c_110 c_101 c_020 c_011 c_002
    double low = std::min({c[0], c[3], c[5]});
    const auto on_edge = [&](double a, double b, double d) {  // a (1−t)² + 2b t(1−t) + d t²
        const double bend = a - 2 * b + d;
        const double t = (a - b) / bend;
        if (bend > 0 && t > 0 && t < 1) low = std::min(low, (a * d - b * b) / bend);
    };
    on_edge(c[0], c[1], c[3]);
    on_edge(c[3], c[4], c[5]);
    on_edge(c[5], c[2], c[0]);
    // f(v, w) with u = 1 − v − w: ∇f = 2 (g + H (v, w)).
    const double h11 = c[0] - 2 * c[1] + c[3];
    const double h22 = c[0] - 2 * c[2] + c[5];
    const double h12 = c[0] - c[1] - c[2] + c[4];
    const double g1 = c[1] - c[0];
    const double g2 = c[2] - c[0];
    const double d = h11 * h22 - h12 * h12;
    const double v = (-g1 * h22 + g2 * h12) / d;
    const double w = (-g2 * h11 + g1 * h12) / d;
    if (d > 0 && h11 > 0 && v > 0 && w > 0 && v + w < 1) low = std::min(low, c[0] + g1 * v + g2 * w);
    return low;
}

}  // namespace

TEST_CASE("verdicts and minimum Jacobians agree with samples") {
    test_against_sampling<2>();
    test_against_sampling<3>();
}

TEST_CASE("verdicts agree with exact bisection") {
    test_against_exact<2>();
    test_against_exact<3>();
}

TEST_CASE("verdicts of thin, oblique and distant elements equal those of their plain images") {
    test_anisotropy<2>();
    test_anisotropy<3>();
}

TEST_CASE("verdicts do not depend on the unit of length") {
    test_scaling<2>();
    test_scaling<3>();
}

TEST_CASE("the minimum Jacobian of a triangle equals the closed form") {
    property("min_scaled_jacobian equals the closed form in 2D",
             [] {
                 auto random = random_source();
                 const auto s = element<2>(random, uniform(random, 0, 0.6));
                 const double exact = closed_form_minimum(jacobian(s)) / std::abs(straight_det<2>(s));
                 const double found = check_element<2>(s, 0).min_scaled_jacobian;
                 RC_ASSERT(found <= exact + 1e-12 * (1 + std::abs(exact)));
                 RC_ASSERT(found >= exact - scaled_jacobian_tolerance * std::max(1.0, std::abs(exact)));
             },
             {500});
}

TEST_CASE("subdivision preserves the Jacobian polynomial") {
    property("subdivision preserves the values of the polynomial", [] {
        auto random = random_source();
        auto part = whole(bounded_jacobian(element<3>(random, 0.4)));
        const auto first = part;
        for (int i = 0; i < 4; ++i) part = half(part, static_cast<int>(random() % 6), static_cast<int>(random() % 2));
        const auto inside = point_inside<3>(random);
        Barycentric<3> outside{};
        for (int i = 0; i < 4; ++i)
            for (int c = 0; c < 4; ++c) outside[c] += inside[i] * part.corners[i][c];
        double a = 0;
        double b = 0;
        for (int p = 0; p < 20; ++p) {
            a += first.coefficients[p] * bernstein<3>(multi_indices<3, 3>[p], outside);
            b += part.coefficients[p] * bernstein<3>(multi_indices<3, 3>[p], inside);
        }
        RC_ASSERT(std::abs(a - b) < 1e-12);
    });
}

TEST_CASE("check_element classifies straight elements") {
    QuadraticSimplex<3, 3> s;
    for (int a = 1; a <= 3; ++a) s.control[a][a - 1] = 1;
    for (int e = 0; e < 6; ++e)
        s.control[4 + e] = midpoint(s.control[local_edges<3>[e][0]], s.control[local_edges<3>[e][1]]);
    SUBCASE("a positively oriented element is valid with minimum scaled Jacobian 1") {
        const auto v = check_element<3>(s, 0.999);
        CHECK(v.verdict == Verdict::valid);
        CHECK(v.min_scaled_jacobian == doctest::Approx(1));
        CHECK_FALSE(v.straight_inverted);
        CHECK(check_element<3>(s, 1.001).verdict == Verdict::invalid);
    }
    SUBCASE("an inverted element is invalid with minimum scaled Jacobian -1") {
        for (auto& p : s.control) p[0] = -p[0];
        const auto v = check_element<3>(s, 0);
        CHECK(v.verdict == Verdict::invalid);
        CHECK(v.min_scaled_jacobian == doctest::Approx(-1));
        CHECK(v.straight_inverted);
    }
    SUBCASE("a flat element is invalid with minimum scaled Jacobian minus infinity") {
        for (auto& p : s.control) p[2] = 0;
        const auto v = check_element<3>(s, 0);
        CHECK(v.verdict == Verdict::invalid);
        CHECK(v.min_scaled_jacobian == -infinity);
        CHECK(v.straight_inverted);
    }
    SUBCASE("an element with a NaN node is invalid") {
        NodalSimplex<3> n;
        for (int i = 0; i < 10; ++i) n.nodes[i] = s.control[i];
        n.nodes[7][1] = std::numeric_limits<double>::quiet_NaN();
        CHECK(check_element<3>(n, 0).verdict == Verdict::invalid);
        CHECK(check_element<3>(n, 0).min_scaled_jacobian == -infinity);
    }
    SUBCASE("a valid element whose Jacobian overflows gets the bound as its minimum") {
        for (auto& p : s.control) p *= 1e150;
        CHECK(check_element<3>(s, 0).verdict == Verdict::valid);
        CHECK(check_element<3>(s, 0.999).min_scaled_jacobian == 0.999);  // the bound of the verdict; no closer minimum
                                                                         // is computed
    }
}

TEST_CASE("a triangle with collinear vertices may be valid") {
    // Three vertices on a line. The edges of the middle one are bowed outwards: nearly a half disc.
    NodalSimplex<2> n;
    n.nodes = {Vec<2>{{-1, 0}}, Vec<2>{{1, 0}},     Vec<2>{{0, 0}},
               Vec<2>{{0, -1}}, Vec<2>{{0.6, 0.3}}, Vec<2>{{-0.6, 0.3}}};
    const auto v = check_element<2>(n, 0);
    CHECK(v.straight_inverted);
    CHECK(v.verdict == (sampled_minimum<2>(bezier_form(n), 40) > 0 ? Verdict::valid : Verdict::invalid));
}
