// Gradation limits growth on every edge, never increases sizes, and is exact for isotropic fields.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "back.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
Column<LogMetric<D>> random_field(const LinearMesh<D>& mesh, Dice& dice) {
    Buffer<LogMetric<D>> logs(mesh.points.size());
    for (auto& m : logs) {
        Vec<D> sizes;
        for (double& h : sizes.c) h = std::pow(10.0, dice.uniform(-2.5, 0.5));
        m = log_metric_of_sizes(sizes, dice.rotation<D>());
    }
    return logs;
}

template <int D>
void check_gradation(GradationSpace space) {
    property("gradation enforces the growth limit, shrinks sizes only and is idempotent",
             [=](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = unit_box<D>(3, seed + 1);
                 const auto edges = must(unique_edges(mesh, one_thread));
                 const auto field = random_field(mesh, dice);
                 const GradationOptions options{.space = space, .ratio = dice.uniform(1.1, 3)};
                 const auto out = must(apply_gradation(mesh, edges, field, options, one_thread));
                 RC_ASSERT(out.converged);
                 RC_ASSERT(must(gradation_excess(mesh, edges, field, options, one_thread)) > 0.1);
                 RC_ASSERT(must(gradation_excess(mesh, edges, out.log_metrics, options, one_thread)) <= 1e-5);
                 for (std::size_t v = 0; v < field.size(); ++v)
                     RC_ASSERT(size_excess(out.log_metrics[v], field[v]) <= 1e-10);
                 const auto again = must(apply_gradation(mesh, edges, out.log_metrics, options, one_thread));
                 for (std::size_t v = 0; v < field.size(); ++v)
                     RC_ASSERT(norm(again.log_metrics[v].l - out.log_metrics[v].l) <= 1e-4);
                 RC_ASSERT(again.sweeps <= 2);
                 const auto threaded = must(apply_gradation(mesh, edges, field, options, Execution{.threads = 3}));
                 RC_ASSERT(threaded.log_metrics == out.log_metrics);
             },
             {.count = 12});
}

/// The sizes after isotropic gradation: the minimum over paths of h(p) + log β · path length (Dijkstra's problem),
/// solved by relaxation.
template <int D>
std::vector<double> shortest_paths(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, std::vector<double> h,
                                   double growth) {
    for (bool any = true; any;) {
        any = false;
        for (const auto& [a, b] : edges.vertices) {
            const double step = growth * distance(mesh.points[a], mesh.points[b]);
            for (const auto& [p, q] : {std::array{a, b}, std::array{b, a}})
                if (h[p.index()] + step < h[q.index()] * (1 - 1e-14)) {
                    h[q.index()] = h[p.index()] + step;
                    any = true;
                }
        }
    }
    return h;
}

template <int D>
void check_isotropic(GradationSpace space) {
    Dice dice(3);
    const auto mesh = unit_box<D>(6, 2);
    const auto edges = must(unique_edges(mesh, one_thread));
    std::vector<double> sizes(mesh.points.size(), 10);
    sizes[0] = 0.01;
    sizes[mesh.points.size() / 2] = 0.03;
    Buffer<LogMetric<D>> logs(sizes.size());
    for (std::size_t v = 0; v < sizes.size(); ++v) logs[v] = {-2 * std::log(sizes[v]) * Sym<D>::identity()};
    const GradationOptions options{.space = space, .ratio = 1.4, .tolerance = 1e-12};
    const auto out = must(apply_gradation(mesh, edges, Column<LogMetric<D>>(std::move(logs)), options, one_thread));
    const auto expected = shortest_paths(mesh, edges, sizes, std::log(1.4));
    for (std::size_t v = 0; v < sizes.size(); ++v)
        for (const double x : eigen_system(out.log_metrics[v].l).values.c)
            CHECK(std::exp(-x / 2) == doctest::Approx(expected[v]).epsilon(1e-9));
    CHECK(out.sweeps > 2);
}

}  // namespace

TEST_CASE("gradation enforces the growth limit and is idempotent in 2D") {
    for (const auto space : {GradationSpace::metric, GradationSpace::physical, GradationSpace::mixed})
        check_gradation<2>(space);
}
TEST_CASE("gradation enforces the growth limit and is idempotent in 3D") {
    for (const auto space : {GradationSpace::metric, GradationSpace::physical, GradationSpace::mixed})
        check_gradation<3>(space);
}
TEST_CASE("isotropic gradation gives shortest-path sizes in all spaces") {
    for (const auto space : {GradationSpace::metric, GradationSpace::physical, GradationSpace::mixed}) {
        check_isotropic<2>(space);
        check_isotropic<3>(space);
    }
}

namespace {

/// A layer at radius 0.5 around the origin (in 3D an axis), as UGAWG's polar-1: size ht along it and hr across it. The
/// size across grows by 2 (ht − hr) per unit length.
template <int D>
Column<LogMetric<D>> turning_layer(const LinearMesh<D>& mesh, double ht, double hr) {
    Buffer<LogMetric<D>> logs(mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) {
        const Vec<D>& x = mesh.points[v];
        const double r = std::max(std::hypot(x[0], x[1]), 1e-9);
        const double across = hr + 2 * (ht - hr) * std::abs(r - 0.5);
        logs[v] = {-2 * std::log(ht) * Sym<D>::identity()};
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j <= i; ++j) logs[v].l(i, j) += 2 * std::log(ht / across) * (x[i] / r) * (x[j] / r);
    }
    return logs;
}

template <int D>
void check_layer(int cells, double ht, double hr) {
    const auto mesh = unit_box<D>(cells, 5);
    const auto edges = must(unique_edges(mesh, one_thread));
    const auto field = turning_layer<D>(mesh, ht, hr);
    const auto graded = must(apply_gradation(mesh, edges, field, {}, one_thread));
    CHECK(graded.converged);
    const double before = must(complexity(mesh, field, one_thread)),
                 after = must(complexity(mesh, graded.log_metrics, one_thread));
    CAPTURE(before);
    CAPTURE(after);
    CHECK(after < 1.05 * before);
    double most = 0, least = 0;
    for (std::size_t v = 0; v < field.size(); ++v) {
        most = std::max(most, anisotropy(field[v]));
        least = std::max(least, anisotropy(graded.log_metrics[v]));
    }
    CHECK(least > 0.9 * most);
}

}  // namespace

// With unrotated axes the complexity rose from 95 to 227 in 2D at ht = 0.2.
TEST_CASE("gradation keeps complexity and anisotropy of a layer with turning axes") {
    for (const double ht : {0.05, 0.1, 0.2}) check_layer<2>(40, ht, 0.002);
    check_layer<3>(10, 0.2, 0.004);
}

TEST_CASE("turn_between returns the rotation of the axes and ignores scaling") {
    property("turn_between returns the rotation and ignores scaling", [](std::uint64_t seed) {
        Dice dice(seed);
        const Mat<3> frame = dice.rotation<3>();
        const Vec<3> sizes{{dice.uniform(0.001, 0.01), 1, dice.uniform(0.9, 1.1)}};
        const double angle = dice.uniform(-0.5, 0.5);
        const AxesTurn<3> by{angle * frame.column[2]};
        Mat<3> turned_frame;
        for (int i = 0; i < 3; ++i) turned_frame.column[i] = by(frame.column[i]);
        const auto from = log_metric_of_sizes(sizes, frame), to = log_metric_of_sizes(sizes, turned_frame);
        const AxesTurn<3> found = turn_between(from.l, to.l);
        RC_ASSERT(norm(found.about - by.about) < 0.02 * std::abs(angle) + 1e-9);
        const double scale = dice.uniform(-3, 3);
        RC_ASSERT(norm(turn_between(from.l, from.l + scale * Sym<3>::identity()).about) < 1e-12);
    });
}

TEST_CASE("spanned metrics of sizes 0.01 and 1 have the closed-form sizes at distance 2") {
    // In metric space sizes grow by the factor 1 + 2 ln β = 3, in physical space by the length 2 ln β = 2. Mixed
    // factors are geometric means with the physical share 1/8.
    const auto metric = log_metric_of_sizes(Vec<2>{{1, 0.01}});
    const EigenSystem<2> at{.values = {{0, -2 * std::log(0.01)}}, .vectors = Mat<2>::identity()};
    const auto sizes = [&](GradationSpace space) {
        const auto e = spanned_metric<2>(at, {}, Vec<2>{{2, 0}}, {.space = space, .ratio = std::exp(1.0)});
        return std::array{std::exp(-e.values[0] / 2), std::exp(-e.values[1] / 2)};
    };
    CHECK(anisotropy(metric) == doctest::Approx(100));
    CHECK(sizes(GradationSpace::metric)[0] == doctest::Approx(3));
    CHECK(sizes(GradationSpace::metric)[1] == doctest::Approx(0.03));
    CHECK(sizes(GradationSpace::physical)[0] == doctest::Approx(3));
    CHECK(sizes(GradationSpace::physical)[1] == doctest::Approx(2.01));
    CHECK(sizes(GradationSpace::mixed)[1] == doctest::Approx(0.01 * std::pow(201, 0.125) * std::pow(3, 0.875)));
}

TEST_CASE("gradation rejects invalid options") {
    const auto mesh = unit_box<2>(3, 4);
    const auto edges = must(unique_edges(mesh, one_thread));
    Dice dice(1);
    const auto field = random_field(mesh, dice);
    for (const double ratio : {1.0, 0.5, -1.0, std::nan("")})
        CHECK(apply_gradation(mesh, edges, field, {.ratio = ratio}, one_thread).error().kind == ErrorKind::usage);
    CHECK(apply_gradation(mesh, edges, field, {.physical_share = 2}, one_thread).error().kind == ErrorKind::usage);
    CHECK(apply_gradation(mesh, edges, Column<LogMetric<2>>{}, {}, one_thread).error().kind == ErrorKind::usage);
}

TEST_CASE("gradation reports that it has not converged") {
    const auto mesh = unit_box<2>(3, 4);
    const auto edges = must(unique_edges(mesh, one_thread));
    Dice dice(1);
    const auto field = random_field(mesh, dice);
    const auto graded = must(apply_gradation(mesh, edges, field, {.max_sweeps = 1}, one_thread));
    CHECK_FALSE(graded.converged);
    CHECK(graded.sweeps == 1);
}
