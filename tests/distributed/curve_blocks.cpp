// Curving by blocks gives the same nodes on any number of ranks, and those of curving the whole mesh.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "meshes.hpp"
#include "thread_ranks.hpp"

import camber.core;
import camber.bezier;
import camber.curving;
import camber.distributed;
import camber.metric;
import camber.ordering;
import camber.recipes;
import camber.shapes;
import camber.validity;

using namespace camber;
using namespace camber::testing;

namespace {

/// A shell between spheres with layers on the inner one, ordered along a space-filling curve.
template <int D>
LinearMesh<D> shell(double size, double outer_radius = 2) {
    ShellOptions<D> options;
    options.outer_radius = outer_radius;
    options.inner_size = size;
    options.outer_size = 2 * size;
    options.inner_layer = {.count = 2, .first_height = 0.1 * size, .growth = 1.5};
    auto mesh = must(generate(options, one_thread));
    return must(renumbered(mesh, must(space_filling_order(mesh, one_thread)), one_thread));
}

/// A ring whose elements along the inner circle are so thin that some lose quality when the circle is curved.
LinearMesh<2> ring_of_thin_layers() {
    ShellOptions<2> options;
    options.outer_radius = 2;
    options.inner_size = 0.05;
    options.outer_size = 0.1;
    options.inner_layer = {.count = 4, .first_height = 0.001, .growth = 1.5};
    auto mesh = must(generate(options, one_thread));
    return must(renumbered(mesh, must(space_filling_order(mesh, one_thread)), one_thread));
}

/// Nodes of all edges, collected from the blocks that own them.
template <int D>
std::vector<LagrangeNode<D>> nodes_of(const std::vector<Outcome<CurvedBlocks<D>>>& results) {
    std::vector<LagrangeNode<D>> nodes(must(results.front()).first_edges.back());
    for (const auto& of_rank : results) {
        const CurvedBlocks<D>& blocks = must(of_rank);
        for (std::size_t b = 0; b < blocks.curved.size(); ++b) {
            const CurvedPart<D>& block = blocks.curved[b];
            const RingedPart<D>& of = blocks.parts.own[b];
            std::size_t number = blocks.first_edges[blocks.parts.layout.part_with(of.vertices[of.first])];
            for (EdgeId e = block.first_edge; e < block.last_edge; e = EdgeId(e.index() + 1))
                nodes[number++] = block.mesh.mid_nodes[e];
        }
    }
    return nodes;
}

template <int D>
double farthest_of_chord(const QuadraticMesh<D>& mesh, const std::vector<LagrangeNode<D>>& nodes) {
    double most = 0;
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        most = std::max(most, distance(nodes[e].point, mesh.mid_nodes[e].point) /
                                  distance(mesh.linear.points[a], mesh.linear.points[b]));
    }
    return most;
}

/// Runs all steps.
template <int D>
Outcome<CurvedBlocks<D>> curve_blocks(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                      const CurveBlocksOptions& options, Ranks& ranks, const StepWrapper& around) {
    return together(ranks, [&] {
        return guarded([&]() -> Outcome<CurvedBlocks<D>> {
            BlockSteps<D> steps(rows, goal, options.blocks, ranks);
            auto status = steps.elevate(around);
            if (status) status = steps.curve(options.curving.curve, around);
            if (status) status = steps.validate(options.curving.repair, around);
            if (status) status = steps.relax(options.curving.repair, around);
            if (status) status = steps.measure(options.tolerance, around);
            if (!status) return fail(status.error());
            return std::move(steps).finish();
        });
    });
}

template <int D>
void compare(const LinearMesh<D>& mesh, std::size_t elements_of_block, const CurveMeshOptions& options,
             double tolerance = 1e-12) {
    const auto whole = must(curve_mesh<D>(as_mesh(mesh), {}, options, without_wrapper(one_thread)));
    CurveBlocksOptions by_blocks{{elements_of_block}, options};
    const auto on = [&](std::size_t ranks) {
        return on_ranks(ranks, [&](Ranks& among) {
            const auto rows = rows_of(mesh);
            return curve_blocks<D>(*rows, BlocksGoal<D>{}, by_blocks, among, without_wrapper(one_thread));
        });
    };
    const auto one = on(1), three = on(3);
    const auto nodes = nodes_of(one);
    REQUIRE(nodes.size() == whole.mesh.entities.edges.size());
    CHECK(nodes == nodes_of(three));
    by_blocks.blocks.elements_at_once = 2 * elements_of_block;
    CHECK(nodes == nodes_of(on(2)));
    const double farthest = farthest_of_chord(must(as_quadratic(whole.mesh)), nodes);
    MESSAGE(mesh.elements.size(), " elements in ", must(one.front()).parts.layout.blocks(), " blocks: ", farthest);
    CHECK(farthest < tolerance);
    const BlocksValidation& after = must(one.front()).after;
    REQUIRE(whole.report.validity);
    CHECK(after.invalid == whole.report.validity->invalid);
    CHECK(after.below_bound == whole.report.validity->below_bound);
    CHECK(after.smallest == whole.report.validity->smallest);
}

}  // namespace

TEST_CASE("curving by blocks agrees with curving of the whole mesh") {
    SUBCASE("2D") { compare(shell<2>(0.1), 300, {}); }
    SUBCASE("3D") { compare(shell<3>(0.25), 1500, {}); }
    SUBCASE("2D, blocks without curved boundary") { compare(shell<2>(0.15, 8), 150, {}); }
    SUBCASE("2D, several separate repairs") {
        CurveMeshOptions options;
        options.repair.min_scaled_jacobian = 0.5;
        compare(ring_of_thin_layers(), 700, options, 1e-9);
    }
    SUBCASE("3D, objective energy") {
        CurveMeshOptions options;
        options.curve.objective = Objective::energy;
        compare(shell<3>(0.35), 1500, options, 1e-9);  // searches and repair amplify rounding
    }
}

TEST_CASE("curving by blocks rejects unprepared meshes on all ranks") {
    LinearMesh<3> mesh = shell<3>(0.5);
    const auto error_of = [](const LinearMesh<3>& of) {
        const auto results = on_ranks(2, [&](Ranks& among) {
            const auto rows = rows_of(of);
            return curve_blocks<3>(*rows, BlocksGoal<3>{}, {{500}, {}}, among, without_wrapper(one_thread));
        });
        for (const auto& of_rank : results) {
            REQUIRE(!of_rank);
            CHECK(of_rank.error().what == results.front().error().what);
        }
        return results.front().error();
    };
    SUBCASE("a boundary face without a facet") {
        LinearMesh<3> bare = mesh;
        bare.facets = {};
        const Error error = error_of(bare);
        CHECK(error.kind == ErrorKind::input);
        CHECK(error.what == "has a face on the boundary for which the mesh lists no facet");
    }
    SUBCASE("an inverted element") {
        LinearMesh<3> inverted = mesh;
        auto vertices = take(inverted.elements.vertices);
        std::swap(vertices.back()[0], vertices.back()[1]);
        inverted.elements.vertices = std::move(vertices);
        const Error error = error_of(inverted);
        CHECK(error.what == "is flat or inverted");
        REQUIRE(error.entity);
        CHECK(error.entity->number == mesh.elements.size());
    }
    SUBCASE("an interface without facets") {
        LinearMesh<3> two = mesh;
        auto references = take(two.elements.references);
        references.front() = 77;
        two.elements.references = std::move(references);
        CHECK(error_of(two).what == "has a face towards another material for which the mesh lists no facet");
    }
}

TEST_CASE("blocks may have few elements, and ranks may have no blocks") {
    const LinearMesh<2> mesh = shell<2>(0.4);
    const auto whole = must(curve_mesh<2>(as_mesh(mesh), {}, {}, without_wrapper(one_thread)));
    const auto results = on_ranks(5, [&](Ranks& among) {
        const auto rows = rows_of(mesh);
        return curve_blocks<2>(*rows, BlocksGoal<2>{}, {{40}, {}}, among, without_wrapper(one_thread));
    });
    CHECK(farthest_of_chord(must(as_quadratic(whole.mesh)), nodes_of(results)) < 1e-12);
}

TEST_CASE("curving by blocks accepts a metric at vertices") {
    const LinearMesh<3> mesh = shell<3>(0.35);
    const auto log_metric = [](const Vec<3>& p) {
        LogMetric<3> m;
        for (int i = 0; i < 3; ++i) m.l(i, i) = 2 + 0.5 * p[0] + i;
        return m;
    };
    Buffer<LogMetric<3>> logs;
    for (const Vec<3>& p : mesh.points) logs.push_back(log_metric(p));
    MeshGoal<3> goal;
    goal.metric = metric_at_vertices<3>(Column<LogMetric<3>>(std::move(logs)));
    const auto whole = must(curve_mesh<3>(as_mesh(mesh), goal, {}, without_wrapper(one_thread)));
    BlocksGoal<3> by_blocks;
    by_blocks.metric = [&](const LinearMesh<3>& block, std::span<const GlobalNumber>,
                           const Execution&) -> Outcome<Column<LogMetric<3>>> {
        Buffer<LogMetric<3>> of_block;
        for (const Vec<3>& p : block.points) of_block.push_back(log_metric(p));
        return Column<LogMetric<3>>(std::move(of_block));
    };
    const auto results = on_ranks(2, [&](Ranks& among) {
        const auto rows = rows_of(mesh);
        return curve_blocks<3>(*rows, by_blocks, {{800}, {}}, among, without_wrapper(one_thread));
    });
    CHECK(farthest_of_chord(must(as_quadratic(whole.mesh)), nodes_of(results)) < 1e-12);
}
