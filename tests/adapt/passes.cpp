// Passes towards a metric preserve the domain and its features, and edges become closer to unit length.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include "dice.hpp"
#include "domains.hpp"
#include "dynamic_measures.hpp"
#include "goals.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void expect_same_domain(const DynamicMesh<D>& mesh, const Sizes& expected) {
    const auto consistent = check_consistency(mesh, one_thread);
    if (!consistent) RC_FAIL(describe(consistent.error()));
    const Sizes now = measures(mesh);
    RC_ASSERT(now.size() == expected.size());
    for (const auto& [key, value] : expected) RC_ASSERT(std::abs(now.at(key) - value) < 1e-8);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e))) RC_ASSERT(volume_of(mesh, mesh.elements.vertices[e]) > 0);
}

void expect_consistent_counts(const PassStatistics& s) {
    RC_ASSERT(s.proposals == s.accepted + std::accumulate(s.rejected.begin(), s.rejected.end(), std::size_t{0}));
    RC_ASSERT(s.rejected[0] == 0U);
}

template <int D>
Adaptation<D> one_round(Adaptation<D> r, const AdaptationGoal<D>& goal, const Execution& execution,
                        PassStatistics& all) {
    auto result = must(collapse<D>(std::move(r), goal, {}, execution));
    expect_consistent_counts(result.statistics);
    all += result.statistics;
    result = must(split<D>(std::move(result.state), goal, {}, execution));
    expect_consistent_counts(result.statistics);
    all += result.statistics;
    result = must(swap<D>(std::move(result.state), goal, {}, execution));
    expect_consistent_counts(result.statistics);
    all += result.statistics;
    result = must(smooth<D>(std::move(result.state), goal, {}, execution));
    expect_consistent_counts(result.statistics);
    all += result.statistics;
    return std::move(result.state);
}

template <int D>
void check_remeshing(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, dice.uniform(0.35, 1.5), dice);
    Adaptation<D> r = start_adaptation(mesh, goal);
    const Sizes domain = measures(r.mesh);
    const UnitMeshStatistics before = must(unit_mesh_statistics(r, one_thread));
    PassStatistics all;
    for (int round = 0; round < 3; ++round) {
        r = one_round(std::move(r), goal, one_thread, all);
        expect_same_domain(r.mesh, domain);
    }
    const UnitMeshStatistics after = must(unit_mesh_statistics(r, one_thread));
    RC_ASSERT(after.unit_share() >= before.unit_share() - 0.1);
    RC_ASSERT(r.vertices.metrics.size() == r.mesh.points.size());
    // Each vertex has the metric of the field at its position.
    for (std::size_t v = 0; v < r.mesh.points.size(); ++v) {
        if (r.mesh.is_free(VertexId(v))) continue;
        const auto sample = sample_value(goal.field, r.mesh.points[v], r.vertices.metrics[v].back);
        const Sym<D> difference = sample.log_metric.l - r.vertices.metrics[v].log_metric.l;
        RC_ASSERT(inner(difference, difference) < 1e-16);
    }
}

}  // namespace

TEST_CASE("each round of passes preserves the domain and its features") {
    property("2D", [](std::uint64_t seed) { check_remeshing<2>(seed); }, {.count = 40});
    property("3D", [](std::uint64_t seed) { check_remeshing<3>(seed); }, {.count = 12});
}

TEST_CASE("a round of passes does not depend on the number of threads") {
    const LinearMesh<3> mesh = random_domain<3>(5);
    Dice dice(5);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.3, dice);
    PassStatistics one, two;
    const auto by_one = one_round(start_adaptation(mesh, goal), goal, {.threads = 1}, one);
    const auto by_two = one_round(start_adaptation(mesh, goal), goal, {.threads = 2}, two);
    CHECK(one == two);
    CHECK(one.accepted > 100);
    CHECK(by_one.mesh.points == by_two.mesh.points);
    CHECK(by_one.mesh.elements == by_two.mesh.elements);
    CHECK(by_one.mesh.edges == by_two.mesh.edges);
    CHECK(by_one.mesh.free == by_two.mesh.free);
    CHECK(by_one.vertices.metrics == by_two.vertices.metrics);
}

TEST_CASE("remeshing a box to a constant size makes over 90 % of its edges unit") {
    LatticeOptions<3> options;
    options.cells = {3, 3, 3};
    const auto mesh = with_references<3>(lattice_mesh(options), options.cells, false);
    AdaptationGoal<3> goal;
    Buffer<LogMetric<3>> logs(mesh.points.size(), log_metric_of_sizes<3>({{0.4, 0.4, 0.4}}));
    goal.field =
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<3>>(std::move(logs)), one_thread));
    const auto [r, statistics] = must(remesh_to_metric<3>(start_adaptation(mesh, goal), goal, {}, one_thread));
    CHECK(statistics.before.unit_share() == 0);
    CHECK(statistics.rounds > 1);
    CHECK(statistics.split.accepted > statistics.collapse.accepted);
    const auto s = must(unit_mesh_statistics(r, one_thread));
    CHECK(s.unit_share() == statistics.after.unit_share());
    INFO(s.unit_share() << " of " << s.edges << " edges are unit, worst quality " << s.worst_quality);
    CHECK(s.unit_share() > 0.9);
    CHECK(s.worst_quality > 0.1);
}

namespace {

template <int D>
void check_spheres(double size, double min_share, double min_quality) {
    ShellOptions<D> options;
    options.outer_radius = 2;
    options.inner_size = options.outer_size = 0.5;
    const LinearMesh<D> mesh = must(generate(options));
    const AnalyticGeometry<D> spheres{{{1, Sphere<D>{{}, 2}}, {2, Sphere<D>{{}, 1}}}};
    Vec<D> sizes;
    for (double& h : sizes.c) h = size;
    Buffer<LogMetric<D>> logs(mesh.points.size(), log_metric_of_sizes<D>(sizes));
    const AdaptationGoal<D> goal{
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<D>>(std::move(logs)), one_thread)),
        Geometry<D>(spheres)};
    const auto [r, statistics] =
        must(remesh_to_metric<D>(start_adaptation(mesh, goal), goal, {.rounds = 3}, one_thread));
    CHECK(check_consistency(r.mesh, one_thread).has_value());
    std::size_t off = 0;  // points that were moved only part of the way
    for (std::size_t v = 0; v < r.mesh.points.size(); ++v) {
        if (r.mesh.is_free(VertexId(v)) || r.mesh.states[v].place == VertexPlace::inside) continue;
        const double radius = norm(r.mesh.points[v]);
        off += std::min(std::abs(radius - 1), std::abs(radius - 2)) < 1e-12 ? 0 : 1;
    }
    CHECK(off <= statistics.split.shortened);
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e)
        if (!r.mesh.is_free(ElementId(e))) CHECK(volume_of(r.mesh, r.mesh.elements.vertices[e]) > 0);
    CHECK(statistics.after.unit_share() > min_share);
    CHECK(statistics.after.worst_quality > min_quality);
}

}  // namespace

TEST_CASE("boundary vertices stay on spheres when the mesh is refined or coarsened") {
    check_spheres<2>(0.1, 0.95, 0.3);
    check_spheres<2>(1, 0.7, 0.3);
    check_spheres<3>(0.25, 0.9, 0.05);
    check_spheres<3>(0.9, 0.8, 0.04);  // the shell is as thick as its edges are long
}

TEST_CASE("passes preserve required vertices, facets and elements") {
    LinearMesh<3> mesh = random_domain<3>(11);
    mesh.required_vertices = Buffer<VertexId>{VertexId(0), VertexId(5)};
    mesh.elements.required = Buffer<std::uint32_t>{1};
    mesh.facets.required = Buffer<std::uint32_t>{2};
    Dice dice(11);
    for (const double size : {0.3, 3.0}) {
        const AdaptationGoal<3> goal = goal_over(mesh, size, dice);
        PassStatistics all;
        const auto r = one_round(start_adaptation(mesh, goal), goal, one_thread, all);
        CHECK(all.of(RejectionReason::required) > 0);
        CHECK(r.mesh.points[0] == mesh.points[0]);
        CHECK(r.mesh.points[5] == mesh.points[5]);
        CHECK(r.mesh.elements.vertices[1] == mesh.elements.vertices[1]);
        CHECK(r.mesh.elements.marks[1].has(Mark::required));
        CHECK(r.mesh.facets.vertices[2] == mesh.facets.vertices[2]);
        CHECK(r.mesh.facets.marks[2].has(Mark::required));
    }
}

TEST_CASE("the metric field may be on a coarser mesh") {
    LatticeOptions<3> options;
    options.cells = {1, 1, 1};
    options.place = [](const Vec<3>& p) { return 3.0 * p; };
    const auto coarse = lattice_mesh(options);
    LatticeOptions<3> fine;
    fine.cells = {3, 3, 3};
    const auto mesh = with_references<3>(lattice_mesh(fine), fine.cells, false);
    Dice dice(3);
    const AdaptationGoal<3> goal = goal_over(coarse, 0.7, dice);
    const auto r = start_adaptation(mesh, goal);
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        CHECK(r.vertices.metrics[v].back.index() < coarse.elements.size());
    PassStatistics all;
    CHECK(check_consistency(one_round(r, goal, one_thread, all).mesh, one_thread).has_value());
}

TEST_CASE("a pass that exceeds the maximum number of elements returns a memory error") {
    const LinearMesh<2> mesh = random_domain<2>(1);
    Dice dice(1);
    AdaptationGoal<2> goal = goal_over(mesh, 0.05, dice);
    const std::size_t elements =
        must(split<2>(start_adaptation(mesh, goal), goal, {}, one_thread)).state.mesh.element_count();
    goal.max_elements = elements;
    CHECK(split<2>(start_adaptation(mesh, goal), goal, {}, one_thread).has_value());
    goal.max_elements = elements / 2;
    const auto refused = split<2>(start_adaptation(mesh, goal), goal, {}, one_thread);
    REQUIRE(!refused.has_value());
    CHECK(refused.error().kind == ErrorKind::memory);
}

namespace {

LinearMesh<2> one_triangle(const std::array<Vec<2>, 3>& corners) {
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>(corners.begin(), corners.end());
    mesh.elements.vertices = Buffer<SimplexVertices<2>>{{VertexId(0), VertexId(1), VertexId(2)}};
    mesh.facets.vertices =
        Buffer<SimplexVertices<1>>{{VertexId(0), VertexId(1)}, {VertexId(1), VertexId(2)}, {VertexId(2), VertexId(0)}};
    return mesh;
}

/// A Euclidean metric: metric lengths are lengths in space.
AdaptationGoal<2> unit_sizes_over(const LinearMesh<2>& mesh) {
    Buffer<LogMetric<2>> logs(mesh.points.size(), log_metric_of_sizes<2>({{1, 1}}));
    return {
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<2>>(std::move(logs)), one_thread)),
        {}};
}

}  // namespace

TEST_CASE("an overlong edge is split although a vertex is closer than the minimum edge length") {
    const auto splits = [](double length) {
        const LinearMesh<2> mesh = one_triangle({{{{-length / 2, 0}}, {{length / 2, 0}}, {{0, 0.45}}}});
        const AdaptationGoal<2> goal = unit_sizes_over(mesh);
        const auto [r, statistics] = must(split<2>(start_adaptation(mesh, goal), goal, {.longest = 1.9}, one_thread));
        return statistics.accepted;
    };
    CHECK(splits(1.95) == 0);  // 0.45 is below the minimum length of 0.61
    CHECK(splits(3) == 1);     // but above 0.61 · 2/3
}

TEST_CASE("an overlong edge is split into elements of quality 0.02 but not below") {
    // Two edges of about 20 and one of `width`: a half of the split element is worse than the whole.
    const auto splits = [](double width) {
        const LinearMesh<2> mesh = one_triangle({{{{0, 0}}, {{20, 0}}, {{20, width}}}});
        const AdaptationGoal<2> goal = unit_sizes_over(mesh);
        const Adaptation<2> before = start_adaptation(mesh, goal);
        const double quality = must(unit_mesh_statistics(before, one_thread)).worst_quality;
        const auto [r, statistics] = must(split<2>(before, goal, {.longest = 19}, one_thread));
        CHECK(must(unit_mesh_statistics(r, one_thread)).worst_quality >= (1 - 1e-8) * std::min(0.02, quality));
        return statistics.accepted;
    };
    CHECK(splits(0.6) > 0);   // quality 0.052; a half has 0.035
    CHECK(splits(0.2) == 0);  // quality 0.017; a half would have 0.012
}

TEST_CASE("split rejects options out of range") {
    const LinearMesh<2> mesh = random_domain<2>(1);
    Dice dice(1);
    const AdaptationGoal<2> goal = goal_over(mesh, 0.3, dice);
    const auto refused = split<2>(start_adaptation(mesh, goal), goal, {.longest = -1}, one_thread);
    REQUIRE(!refused.has_value());
    CHECK(refused.error().kind == ErrorKind::usage);
}
