// Operations on metric fields: intersection, bounds, complexity.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "back.hpp"
#include "dice.hpp"
#include "property.hpp"
#include "random_metric.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_intersection(double decades) {
    const double aspect = std::pow(10.0, decades);
    property("the intersection contains both metrics and is minimal, idempotent and commutative",
             [=](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto a = random_metric<D>(dice, decades);
                 const auto b = random_metric<D>(dice, decades);
                 const auto both = intersection(a, b);
                 const SpectralMetric<D> of_a(a), of_b(b), of_both(both);
                 const double rounding = 1e-13 + 1e-15 * aspect;
                 // In random directions and along all axes, the intersection is at least as fine as each metric.
                 for (int k = 0; k < 4 * D; ++k) {
                     const Vec<D> v = k < D       ? of_a.vectors.column[k]
                                      : k < 2 * D ? of_b.vectors.column[k - D]
                                                  : dice.direction<D>();
                     const double required = std::max(of_a.length_squared(v), of_b.length_squared(v));
                     RC_ASSERT(of_both.length_squared(v) >= required * (1 - rounding));
                 }
                 RC_ASSERT(size_excess(both, a) <= rounding);
                 RC_ASSERT(size_excess(both, b) <= rounding);
                 // Minimal: along each axis of the reduction one of the two metrics is met exactly. In 2D this bounds
                 // the determinant.
                 RC_ASSERT(trace(both.l) <= trace(a.l) + D * 2 * std::max(0.0, size_excess(a, b)) + rounding);
                 RC_ASSERT(intersection(a, a) == a);
                 RC_ASSERT(norm(intersection(both, a).l - both.l) <= 10 * rounding);
                 RC_ASSERT(norm(intersection(b, a).l - both.l) <= 10 * rounding);
             });
    property("the intersection with a finer metric is the finer metric", [=](std::uint64_t seed) {
        Dice dice(seed);
        const auto a = random_metric<D>(dice, decades);
        const LogMetric<D> finer{a.l + dice.uniform(0.1, 3) * Sym<D>::identity()};
        RC_ASSERT(norm(intersection(a, finer).l - finer.l) <= 1e-13 * norm(finer.l));
        RC_ASSERT(norm(intersection(finer, a).l - finer.l) <= 1e-13 * norm(finer.l));
    });
    property("the intersection along shared axes has the smaller sizes", [=](std::uint64_t seed) {
        Dice dice(seed);
        const auto axes = dice.rotation<D>();
        Vec<D> one, other, least;
        for (int i = 0; i < D; ++i) {
            one[i] = std::pow(10.0, dice.uniform(-decades, 0));
            other[i] = std::pow(10.0, dice.uniform(-decades, 0));
            least[i] = std::min(one[i], other[i]);
        }
        const auto found = intersection(log_metric_of_sizes(one, axes), log_metric_of_sizes(other, axes));
        RC_ASSERT(norm(found.l - log_metric_of_sizes(least, axes).l) <= 1e-12 + 1e-14 * aspect);
    });
    property("the intersection commutes with congruence", [=](std::uint64_t seed) {
        Dice dice(seed);
        const auto a = random_metric<D>(dice, 2);
        const auto b = random_metric<D>(dice, 2);
        const auto r = dice.rotation<D>();
        const double shift = dice.uniform(-3, 3);
        const auto moved = [&](const LogMetric<D>& m) {
            return LogMetric<D>{congruence(r, m.l) + shift * Sym<D>::identity()};
        };
        RC_ASSERT(norm(intersection(moved(a), moved(b)).l - moved(intersection(a, b)).l) <= 1e-10);
    });
}

template <int D>
void check_bounds() {
    property("apply_bounds enforces the bounds, is idempotent and changes nothing else", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto m = random_metric<D>(dice, 4);
        MetricBounds bounds{.min_size = std::pow(10.0, dice.uniform(-4, -2)),
                            .max_size = std::pow(10.0, dice.uniform(-2, 0)),
                            .max_anisotropy = std::pow(10.0, dice.uniform(0, 2))};
        const auto out = apply_bounds(m, bounds);
        for (const double x : eigen_system(out.l).values.c) {
            RC_ASSERT(std::exp(-x / 2) >= bounds.min_size * (1 - 1e-12));
            RC_ASSERT(std::exp(-x / 2) <= bounds.max_size * (1 + 1e-12));
        }
        RC_ASSERT(anisotropy(out) <= bounds.max_anisotropy * (1 + 1e-12));
        RC_ASSERT(norm(apply_bounds(out, bounds).l - out.l) <= 1e-12 * norm(out.l));
        RC_ASSERT(apply_bounds(m, MetricBounds{}) == m);
        // Without a minimum size no size grows.
        bounds.min_size = 0;
        RC_ASSERT(size_excess(apply_bounds(m, bounds), m) <= 1e-10);
    });
}

/// ∫ exp(½ tr log M) by Gauss points in collapsed coordinates: n points an axis, exact to degree 2n − D.
template <int D>
double complexity_by_quadrature(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field, int n) {
    const auto rule = gauss_legendre(n);
    double sum = 0;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const auto p = corners(mesh, e);
        const double volume = std::abs(orientation(p));
        std::array<double, D + 1> f{};
        for (int i = 0; i <= D; ++i) f[i] = 0.5 * trace(field[mesh.elements.vertices[e][i]].l);
        const auto points = [&](auto&& self, int axis, double weight, double rest, double value) -> void {
            if (axis == D) {
                sum += volume * weight * std::exp(value + rest * f[D]);
                return;
            }
            for (std::size_t q = 0; q < rule.size(); ++q)
                self(self, axis + 1, weight * rule.w[q] * std::pow(1 - rule.t[q], D - 1 - axis), rest * (1 - rule.t[q]),
                     value + rest * rule.t[q] * f[axis]);
        };
        points(points, 0, 1, 1, 0);
    }
    return sum;
}

template <int D>
void check_complexity() {
    property("the complexity equals that of a Gauss rule and can be scaled to a target",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = unit_box<D>(2, seed + 1);
                 const double size = dice.below(2) == 0 ? 0.3 : 6;
                 Buffer<LogMetric<D>> logs(mesh.points.size());
                 for (auto& m : logs) m.l = dice.symmetric<D>(size);
                 const Column<LogMetric<D>> field(std::move(logs));
                 const double c = must(complexity(mesh, field, one_thread));
                 RC_ASSERT(std::abs(c / complexity_by_quadrature(mesh, field, 14) - 1) < 1e-11);
                 const auto scaled = must(scale_to_complexity(mesh, field, 1234.5, one_thread));
                 RC_ASSERT(std::abs(must(complexity(mesh, scaled, one_thread)) / 1234.5 - 1) < 1e-12);
                 RC_ASSERT(must(complexity(mesh, field, Execution{.threads = 3})) == c);
             },
             {.count = 30});
}

}  // namespace

TEST_CASE("intersection is minimal, idempotent, commutative and equivariant in 2D") {
    for (const double decades : {0.5, 3.0, 6.0}) check_intersection<2>(decades);
}
TEST_CASE("intersection is minimal, idempotent, commutative and equivariant in 3D") {
    for (const double decades : {0.5, 3.0, 6.0}) check_intersection<3>(decades);
}
TEST_CASE("apply_bounds limits sizes and anisotropy and is idempotent") {
    check_bounds<2>();
    check_bounds<3>();
}
TEST_CASE("complexity matches quadrature and can be scaled to a target") {
    check_complexity<2>();
    check_complexity<3>();
}

TEST_CASE("the intersection of two orthogonal plates is a needle") {
    const auto a = log_metric_of_sizes(Vec<3>{{1e-6, 1, 1}});
    const auto b = log_metric_of_sizes(Vec<3>{{1, 1e-6, 1}});
    CHECK(norm(intersection(a, b).l - log_metric_of_sizes(Vec<3>{{1e-6, 1e-6, 1}}).l) < 1e-12);
}

TEST_CASE("the complexity of the identity metric is the volume") {
    const auto mesh = unit_box<3>(3, 4, 0);
    CHECK(must(complexity(mesh, Column<LogMetric<3>>(Buffer<LogMetric<3>>(mesh.points.size(), LogMetric<3>{})),
                          one_thread)) == doctest::Approx(1).epsilon(1e-12));
}

namespace {

template <int D>
void check_size_range() {
    property("check_sizes accepts sizes in range and names the vertex of others", [](std::uint64_t seed) {
        Dice dice(seed);
        Buffer<LogMetric<D>> logs(5);
        const auto sized = [&](double exponent) {
            Vec<D> sizes;
            for (double& h : sizes.c) h = std::pow(10.0, dice.uniform(-60, 60));
            sizes[0] = std::pow(10.0, exponent);
            return log_metric_of_sizes(sizes, dice.rotation<D>());
        };
        for (auto& log_metric : logs) log_metric = sized(dice.below(2) == 0 ? 60 : -60);
        RC_ASSERT(check_sizes(Column<LogMetric<D>>(logs), one_thread).has_value());
        const std::size_t at = static_cast<std::size_t>(dice.below(5));
        logs[at] = sized(dice.below(2) == 0 ? dice.uniform(60.01, 300) : dice.uniform(-300, -60.01));
        const auto checked = check_sizes(Column<LogMetric<D>>(logs), one_thread);
        RC_ASSERT(!checked.has_value());
        RC_ASSERT(checked.error().kind == ErrorKind::input);
        RC_ASSERT(checked.error().entity->number == at + 1);
    });
}

}  // namespace

TEST_CASE("check_sizes accepts sizes in the range of lengths and rejects others by vertex") {
    check_size_range<2>();
    check_size_range<3>();
}

TEST_CASE("metric operations reject invalid arguments") {
    const auto mesh = unit_box<2>(2, 4);
    const Column<LogMetric<2>> field(Buffer<LogMetric<2>>(mesh.points.size(), LogMetric<2>{}));
    const Column<LogMetric<2>> other(Buffer<LogMetric<2>>(3, LogMetric<2>{}));
    CHECK(intersection(field, other, one_thread).error().kind == ErrorKind::usage);
    CHECK(complexity(mesh, other, one_thread).error().kind == ErrorKind::usage);
    CHECK(scale_to_complexity(mesh, field, 0, one_thread).error().kind == ErrorKind::usage);
    CHECK(apply_bounds(field, MetricBounds{.min_size = 2, .max_size = 1}, one_thread).error().kind == ErrorKind::usage);
    CHECK(apply_bounds(field, MetricBounds{.max_anisotropy = 0.5}, one_thread).error().kind == ErrorKind::usage);
}
