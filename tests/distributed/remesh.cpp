// Remeshing by blocks preserves the domain and its features, and its quality at block boundaries is that of the rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "dynamic_measures.hpp"
#include "goals.hpp"
#include "property.hpp"
#include "thread_ranks.hpp"

import camber.core;
import camber.metric;
import camber.io;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.distributed;

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

template <int D>
std::size_t corners_of(const DynamicMesh<D>& mesh) {
    std::size_t n = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        n += !mesh.is_free(VertexId(v)) && mesh.states[v].place == VertexPlace::corner ? 1 : 0;
    return n;
}

template <int D>
RemeshResult<D> by_blocks(Adaptation<D> r, const AdaptationGoal<D>& goal, std::size_t elements,
                          const Execution& execution) {
    const ToMetricOptions options;
    const auto ranks = one_rank();
    return must(remesh_by_blocks(std::move(r), goal, options, {elements, *ranks}, block_iterations<D>(options),
                                 without_wrapper(execution)));
}

template <int D>
void check_remeshing(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, dice.uniform(0.35, 1.5), dice);
    const Adaptation<D> r = start_adaptation(mesh, goal);
    const Sizes domain = measures(r.mesh);
    const std::size_t corners = corners_of(r.mesh);
    const auto [state, statistics] = by_blocks(r, goal, 1 + dice.below(60), one_thread);
    expect_same_domain(state.mesh, domain);
    RC_ASSERT(corners_of(state.mesh) == corners);
    RC_ASSERT(statistics.after.unit_share() >= statistics.before.unit_share() - 0.1);
    for (std::size_t v = 0; v < state.mesh.points.size(); ++v) {
        RC_ASSERT(!state.mesh.is_free(VertexId(v)));
        const auto sample = sample_value(goal.field, state.mesh.points[v], state.vertices.metrics[v].back);
        const Sym<D> difference = sample.log_metric.l - state.vertices.metrics[v].log_metric.l;
        RC_ASSERT(inner(difference, difference) < 1e-16);
    }
}

}  // namespace

TEST_CASE("remeshing by blocks preserves the domain and its features") {
    property("2D", [](std::uint64_t seed) { check_remeshing<2>(seed); }, {.count = 30});
    property("3D", [](std::uint64_t seed) { check_remeshing<3>(seed); }, {.count = 10});
}

TEST_CASE("remeshing by blocks does not depend on the number of threads") {
    const LinearMesh<3> mesh = random_domain<3>(5);
    Dice dice(5);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.3, dice);
    const auto by_one = by_blocks(start_adaptation(mesh, goal), goal, 300, {.threads = 1});
    const auto by_two = by_blocks(start_adaptation(mesh, goal), goal, 300, {.threads = 2});
    CHECK(by_one.statistics.split.accepted > 100);
    CHECK(by_one.statistics.split == by_two.statistics.split);
    CHECK(by_one.state.mesh.points == by_two.state.mesh.points);
    CHECK(by_one.state.mesh.elements == by_two.state.mesh.elements);
    CHECK(by_one.state.mesh.facets == by_two.state.mesh.facets);
    CHECK(by_one.state.mesh.edges == by_two.state.mesh.edges);
    CHECK(by_one.state.vertices.metrics == by_two.state.vertices.metrics);
}

TEST_CASE("remeshing by blocks gives the same mesh on every rank and number of ranks") {
    const LinearMesh<3> mesh = random_domain<3>(5);
    Dice dice(5);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.5, dice);
    const auto by_one = by_blocks(start_adaptation(mesh, goal), goal, 60, one_thread);
    for (const std::size_t ranks : {2U, 3U}) {
        const auto result = on_ranks(ranks, [&](Ranks& rank) {
            return remesh_by_blocks(start_adaptation(mesh, goal), goal, {}, {60, rank}, block_iterations<3>({}),
                                    without_wrapper(one_thread));
        });
        for (const auto& one : result) {
            const auto& [state, statistics] = must(one);
            CHECK(statistics.split == by_one.statistics.split);
            CHECK(state.mesh.points == by_one.state.mesh.points);
            CHECK(state.mesh.elements == by_one.state.mesh.elements);
            CHECK(state.vertices.metrics == by_one.state.vertices.metrics);
        }
    }
}

TEST_CASE("an error on one rank is returned on all ranks") {
    const LinearMesh<2> mesh = random_domain<2>(6);
    Dice dice(6);
    const AdaptationGoal<2> goal = goal_over(mesh, 0.3, dice);
    const auto result = on_ranks(3, [&](Ranks& rank) {
        std::stop_source stop;
        if (rank.rank() == 1) stop.request_stop();
        return remesh_by_blocks(start_adaptation(mesh, goal), goal, {}, {10, rank}, block_iterations<2>({}),
                                without_wrapper({.threads = 1, .stop = stop.get_token()}));
    });
    for (const auto& one : result) {
        REQUIRE_FALSE(one);
        CHECK(one.error().kind == ErrorKind::stopped);
    }
}

TEST_CASE("remeshing with one block reaches the quality of remeshing the whole mesh") {
    LatticeOptions<3> options;
    options.cells = {4, 4, 4};
    const auto mesh = with_references<3>(lattice_mesh(options), options.cells, false);
    Dice dice(1);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.5, dice);
    const auto whole = must(remesh_to_metric<3>(start_adaptation(mesh, goal), goal, {}, one_thread));
    const auto by_one_block = by_blocks(start_adaptation(mesh, goal), goal, 1U << 20U, one_thread);
    const auto& a = whole.statistics.after;
    const auto& b = by_one_block.statistics.after;
    CHECK(static_cast<double>(b.elements) == doctest::Approx(static_cast<double>(a.elements)).epsilon(0.05));
    CHECK(b.unit_share() > a.unit_share() - 0.01);
    CHECK(b.mean_quality > a.mean_quality - 0.01);
    CHECK(b.worst_quality > 0.7 * a.worst_quality);
}

namespace {

/// The share of unit edges among those with both ends marked.
template <int D>
double unit_share(const Adaptation<D>& r, const Buffer<std::uint8_t>& marked) {
    std::size_t edges = 0, unit = 0;
    for (std::size_t e = 0; e < r.mesh.edges.size(); ++e) {
        const auto& ends = r.mesh.edges[e];
        if (!std::ranges::all_of(ends, [&](VertexId v) { return marked[v.index()] != 0; })) continue;
        const double length = length_of(r, EdgeId(e));
        ++edges;
        unit += length >= shortest_unit_edge && length <= longest_unit_edge ? 1 : 0;
    }
    return static_cast<double>(unit) / static_cast<double>(std::max<std::size_t>(edges, 1));
}

template <int D>
void check_block_boundaries(const std::array<int, D>& cells, double size, std::size_t elements) {
    LatticeOptions<D> options;
    options.cells = cells;
    const auto mesh = with_references<D>(lattice_mesh(options), cells, false);
    Dice dice(2);
    const AdaptationGoal<D> goal = goal_over(mesh, size, dice);
    const auto ranks = one_rank();
    RemeshedRows<D> adapted_rows{must(share_of(must(rows_of(start_adaptation(mesh, goal))), *ranks))};
    for (const BlockIteration& turn : block_iterations<D>({}))
        adapted_rows = must(run_block_iteration(std::move(adapted_rows), goal, {}, {elements, *ranks}, turn,
                                                without_wrapper(one_thread)));
    const Buffer<std::uint8_t> on_rim = adapted_rows.shared.on_rim;
    const auto whole = must(assembled(adapted_rows.shared.rows, one_thread));
    REQUIRE(std::ranges::count(on_rim, 1) > 100);
    const double all = unit_share(whole.state, Buffer<std::uint8_t>(on_rim.size(), 1));
    CHECK(all > 0.85);
    CHECK(unit_share(whole.state, on_rim) > all - 0.03);
}

}  // namespace

TEST_CASE("the share of unit edges at block boundaries is near that of the whole mesh") {
    SUBCASE("2D") { check_block_boundaries<2>({12, 12}, 0.3, 400); }
    SUBCASE("3D") { check_block_boundaries<3>({4, 4, 4}, 0.4, 1500); }
}

TEST_CASE("remeshing by blocks rejects curved meshes") {
    const LinearMesh<2> mesh = random_domain<2>(6);
    Dice dice(6);
    const AdaptationGoal<2> goal = goal_over(mesh, 0.3, dice);
    Adaptation<2> r = start_adaptation(mesh, goal);
    r.mesh.nodes = Buffer<LagrangeNode<2>>(r.mesh.edges.size());
    const auto ranks = one_rank();
    const auto result =
        remesh_by_blocks(std::move(r), goal, {}, {10, *ranks}, block_iterations<2>({}), without_wrapper(one_thread));
    REQUIRE_FALSE(result);
    CHECK(result.error().kind == ErrorKind::unsupported);
}

TEST_CASE("remeshing by blocks keeps associations of vertices and groups") {
    LinearMesh<3> mesh = random_domain<3>(7);
    Buffer<Association<1>> on_curves;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        on_curves.push_back({VertexId(v), static_cast<Reference>(v + 1), {}, {}});
    mesh.geometry.on_curves = std::move(on_curves);
    mesh.groups = Buffer<Group>{{.dimension = 3, .reference = 1, .name = "left"}};
    Dice dice(7);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.7, dice);
    const auto result = by_blocks(start_adaptation(mesh, goal), goal, 40, one_thread);
    const LinearMesh<3> after = must(compacted(result.state.mesh, one_thread)).mesh;
    CHECK(after.groups == mesh.groups);
    REQUIRE(after.geometry.on_curves.size() > 8);
    for (const Association<1>& on : after.geometry.on_curves)
        CHECK(after.points[on.item] == mesh.points[static_cast<std::size_t>(on.entity - 1)]);
}

namespace {

/// A domain with required vertices, facets and elements, associations and groups.
LinearMesh<3> described_domain(std::uint64_t seed) {
    LinearMesh<3> mesh = random_domain<3>(seed);
    mesh.required_vertices = Buffer<VertexId>{VertexId(std::size_t{0}), VertexId(mesh.points.size() / 2)};
    mesh.facets.required = Buffer<std::uint32_t>{0U, 3U};
    mesh.elements.required = Buffer<std::uint32_t>{1U};
    Buffer<Association<1>> on_curves;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        on_curves.push_back({VertexId(v), static_cast<Reference>(v + 1), {}, {}});
    mesh.geometry.on_curves = std::move(on_curves);
    mesh.groups = Buffer<Group>{{.dimension = 3, .reference = 1, .name = "left"}};
    return mesh;
}

/// The final rows of a rank.
template <int D>
struct EndOfRank {
    FinishedRows<D> rows;
    MeasuredRows measured;
};
template <int D>
Outcome<EndOfRank<D>> end_on(const LinearMesh<D>& mesh, const AdaptationGoal<D>& goal, std::size_t elements,
                             Ranks& ranks) {
    auto adapted_rows = must(remesh_shared_rows(start_adaptation(mesh, goal), goal, {}, {elements, ranks},
                                                block_iterations<D>({}), without_wrapper(one_thread)));
    auto measured = must(measured_rows(adapted_rows.shared, ranks, one_thread));
    return EndOfRank<D>{must(finished_rows(std::move(adapted_rows.shared), adapted_rows.original, ranks)),
                        std::move(measured)};
}

/// Checks that a run continues the rows of a mesh.
template <int K>
void expect_rows(const SimplexRun<K, 1>& run, std::size_t& row, const Simplices<K>& expected) {
    RC_ASSERT(run.first == row);
    for (std::size_t i = 0; i < run.nodes.size(); ++i, ++row) {
        for (int v = 0; v <= K; ++v) RC_ASSERT(run.nodes[i][v] == expected.vertices[row][v].index());
        RC_ASSERT(run.references[i] == expected.references[row]);
    }
}

template <int D>
void check_finished_rows(const LinearMesh<D>& mesh, std::uint64_t seed) {
    Dice dice(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.5, dice);
    const std::size_t elements = 20 + dice.below(60);
    const auto whole = by_blocks(start_adaptation(mesh, goal), goal, elements, one_thread);
    const LinearMesh<D> expected = must(finished(whole.state, one_thread)).compact.mesh;
    for (const std::size_t count : {1U, 3U}) {
        std::size_t points = 0, inside = 0, facets = 0, lines = 0, edges = 0;
        double longest = 0;
        for (const auto& result : on_ranks(count, [&](Ranks& rank) { return end_on(mesh, goal, elements, rank); })) {
            const auto& [rows, measured] = must(result);
            RC_ASSERT(rows.part.vertices.first == points);
            for (const Vec<D>& point : rows.part.vertices.points) RC_ASSERT(point == expected.points[points++]);
            expect_rows(rows.part.elements, inside, expected.elements);
            expect_rows(rows.part.facets, facets, expected.facets);
            if constexpr (D == 3) expect_rows(rows.part.edges, lines, expected.edges);
            RC_ASSERT(rows.lists.corners == expected.corners);
            RC_ASSERT(rows.lists.ridges == expected.ridges);
            RC_ASSERT(rows.lists.required_vertices == expected.required_vertices);
            RC_ASSERT(rows.lists.elements.required == expected.elements.required);
            RC_ASSERT(rows.lists.facets.required == expected.facets.required);
            RC_ASSERT(rows.lists.edges.required == expected.edges.required);
            RC_ASSERT(rows.lists.geometry == expected.geometry);
            RC_ASSERT(rows.lists.groups == expected.groups);
            RC_ASSERT(measured.qualities.size() == rows.part.elements.nodes.size());
            edges += measured.lengths.size();
            for (const double length : measured.lengths) longest = std::max(longest, length);
        }
        RC_ASSERT(points == expected.points.size());
        RC_ASSERT(inside == expected.elements.size());
        RC_ASSERT(facets == expected.facets.size());
        RC_ASSERT(lines == expected.edges.size());
        RC_ASSERT(edges == whole.statistics.after.edges);
        RC_ASSERT(longest == whole.statistics.after.longest);
    }
}

}  // namespace

TEST_CASE("the rows of all ranks form the remeshed mesh") {
    property("2D", [](std::uint64_t seed) { check_finished_rows<2>(random_domain<2>(seed), seed); }, {.count = 8});
    property("3D", [](std::uint64_t seed) { check_finished_rows<3>(described_domain(seed), seed); }, {.count = 4});
}

TEST_CASE("remeshing by blocks preserves required vertices, facets and elements") {
    LinearMesh<3> mesh = random_domain<3>(8);
    mesh.required_vertices = Buffer<VertexId>{VertexId(std::size_t{0}), VertexId(mesh.points.size() / 2)};
    mesh.facets.required = Buffer<std::uint32_t>{0U, 3U};
    mesh.elements.required = Buffer<std::uint32_t>{1U};
    Dice dice(8);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.4, dice);
    const auto result = by_blocks(start_adaptation(mesh, goal), goal, 50, one_thread);
    const LinearMesh<3> after = must(compacted(result.state.mesh, one_thread)).mesh;
    const auto has_point = [&](VertexId v) {
        return std::ranges::find(after.points, mesh.points[v]) != after.points.end();
    };
    CHECK(after.required_vertices.size() == 2);
    CHECK(after.facets.required.size() == 2);
    CHECK(after.elements.required.size() == 1);
    for (const VertexId v : mesh.required_vertices) CHECK(has_point(v));
    for (const VertexId v : mesh.elements.vertices[1]) CHECK(has_point(v));
    for (const std::uint32_t f : mesh.facets.required)
        for (const VertexId v : mesh.facets.vertices[f]) CHECK(has_point(v));
}

TEST_CASE("remeshing by blocks with 0 rounds and 0 mend sweeps returns the same mesh") {
    const LinearMesh<2> mesh = random_domain<2>(9);
    Dice dice(9);
    const AdaptationGoal<2> goal = goal_over(mesh, 0.01, dice);
    const auto ranks = one_rank();
    ToMetricOptions options;
    options.rounds = 0;
    options.mend.sweeps = 0;
    const Adaptation<2> before = start_adaptation(mesh, goal);
    const auto result = must(remesh_by_blocks(before, goal, options, {5, *ranks}, block_iterations<2>(options),
                                              without_wrapper(one_thread)));
    CHECK(by_places(result.state.mesh) == by_places(before.mesh));
}

TEST_CASE("remeshing by blocks reaches unit edges when the mesh grows a hundredfold") {
    LatticeOptions<2> options;
    options.cells = {3, 3};
    const auto mesh = with_references<2>(lattice_mesh(options), options.cells, false);
    Dice dice(3);
    const AdaptationGoal<2> goal = goal_over(mesh, 0.05, dice);
    const auto [state, statistics] = by_blocks(start_adaptation(mesh, goal), goal, 500, one_thread);
    CHECK(state.mesh.element_count() > 100 * mesh.elements.size());
    CHECK(statistics.after.unit_share() > 0.95);
    CHECK(statistics.after.worst_quality > 0.4);
}
