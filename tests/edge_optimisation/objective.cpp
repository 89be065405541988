// The edge objectives: gradients compared with differences, values with another formula, and invariance.
#include <array>
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

namespace {

/// The exponential by its series, scaled and squared.
template <int D>
Mat<D> exp_by_series(const Sym<D>& l) {
    Mat<D> q;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) q(i, j) = l(i, j) / 64;
    Mat<D> sum = Mat<D>::identity();
    Mat<D> term = Mat<D>::identity();
    for (int k = 1; k < 20; ++k) {
        term = term * q;
        for (Vec<D>& column : term.column) column *= 1.0 / k;
        for (int j = 0; j < D; ++j) sum.column[j] += term.column[j];
    }
    for (int k = 0; k < 6; ++k) sum = sum * sum;
    return sum;
}

template <int D>
void check_objective() {
    for (const auto kind : {EdgeObjectiveKind::energy, EdgeObjectiveKind::length})
        for (const auto field : {EdgeFieldKind::back, EdgeFieldKind::edge}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(static_cast<int>(field));
            property("the gradient equals the differences of the value",
                     [&](std::uint64_t seed) {
                         Dice dice(seed);
                         const auto back = rough_back(unit_box<D>(2, seed + 1), dice);
                         const auto rule = gauss_legendre(4);
                         const Vec<D> a = random_point(back.mesh, dice), b = random_point(back.mesh, dice);
                         RC_PRE(distance(a, b) > 0.2);
                         const auto objective =
                             edge_objective(back, rule, kind, field, {a, b, ElementId(std::size_t{0})});
                         const Vec<D> node = midpoint(a, b) + 0.2 * distance(a, b) * dice.vector<D>();
                         const auto sample = objective.evaluate(node);
                         RC_ASSERT(std::abs(sample.value - objective.value(node)) <= 1e-13 * sample.value);
                         for (int i = 0; i < D; ++i) {
                             Vec<D> step;
                             step[i] = 1e-6;
                             const double ahead = objective.value(node + step), behind = objective.value(node - step);
                             // If a sample crosses a face between the two points, the one-sided slopes differ.
                             const double kink = std::abs(ahead + behind - 2 * sample.value);
                             if (kink > 1e-9 * (1 + sample.value)) continue;
                             RC_ASSERT(std::abs((ahead - behind) / 2e-6 - sample.gradient[i]) <
                                       1e-5 * (1 + norm(sample.gradient)));
                         }
                         // The Hessian model is SPD.
                         const auto e = eigen_system(sample.hessian).values;
                         for (int i = 0; i < D; ++i) RC_ASSERT(e[i] > 0);
                     },
                     {.count = 50});
            property("the value equals the quadrature sum with another exponential",
                     [&](std::uint64_t seed) {
                         Dice dice(seed);
                         const auto affine = AffineField<D>::random(dice);
                         const auto back = back_of(unit_box<D>(2, seed + 1), affine);
                         const auto rule = gauss_legendre(5);
                         // The points are so far inside that the parabola stays inside.
                         const Vec<D> a = dice.vector<D>(0.35, 0.65), b = dice.vector<D>(0.35, 0.65);
                         const Vec<D> node = dice.vector<D>(0.35, 0.65);
                         const QuadraticEdge<D> edge{a, {node}, b};
                         double expected = 0;
                         for (std::size_t q = 0; q < rule.size(); ++q) {
                             const double t = rule.t[q];
                             const LogMetric<D> l = field == EdgeFieldKind::back
                                                        ? affine(edge.point(t))
                                                        : EdgeField<D>{affine(a), affine(node), affine(b)}.at(t);
                             const Vec<D> d = edge.derivative(t);
                             const double length_squared = dot(d, exp_by_series(l.l) * d);
                             expected += rule.w[q] * (kind == EdgeObjectiveKind::energy ? length_squared
                                                                                        : std::sqrt(length_squared));
                         }
                         const auto objective =
                             edge_objective(back, rule, kind, field, {a, b, ElementId(std::size_t{1})});
                         RC_ASSERT(std::abs(objective.value(node) - expected) < 1e-11 * expected);
                     },
                     {.count = 50});
        }
    property("the energy is at least the square of the length", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_back(unit_box<D>(2, seed + 1), dice);
        const auto rule = gauss_legendre(6);
        const Vec<D> a = random_point(back.mesh, dice), b = random_point(back.mesh, dice);
        const Vec<D> node = random_point(back.mesh, dice);
        const ElementId hint(std::size_t{0});
        const double energy =
            edge_objective(back, rule, EdgeObjectiveKind::energy, EdgeFieldKind::back, {a, b, hint}).value(node);
        const double length =
            edge_objective(back, rule, EdgeObjectiveKind::length, EdgeFieldKind::back, {a, b, hint}).value(node);
        RC_ASSERT(energy >= length * length * (1 - 1e-14));
    });
}

}  // namespace

TEST_CASE("edge objectives equal their sums and gradients equal differences, 2D") { check_objective<2>(); }
TEST_CASE("edge objectives equal their sums and gradients equal differences, 3D") { check_objective<3>(); }
