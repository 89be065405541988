// Curving by blocks is curving: the same nodes on any number of ranks, and those of the mesh as a whole.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "meshes.hpp"
#include "thread_ranks.hpp"

import camber.core;
import camber.bezier;
import camber.curving;
import camber.distributed;
import camber.ordering;
import camber.recipes;
import camber.shapes;
import camber.validity;

using namespace camber;
using namespace camber::testing;

namespace {

/// A shell between spheres with layers on the inner one, in an order in which what is near is near.
template <int D>
LinearMesh<D> shell(double size) {
    ShellOptions<D> options;
    options.outer_radius = 2;
    options.inner_size = size;
    options.outer_size = 2 * size;
    options.inner_layer = {.count = 2, .first_height = 0.1 * size, .growth = 1.5};
    auto mesh = must(generate(options, alone));
    return must(renumbered(mesh, must(space_filling_order(mesh, alone)), alone));
}

/// Nodes of all edges, from those who own them.
template <int D>
std::vector<LagrangeNode<D>> nodes_of(const std::vector<Outcome<CurvedBlocks<D>>>& made) {
    std::vector<LagrangeNode<D>> nodes(must(made.front()).first_edges.back());
    for (const auto& of_rank : made) {
        const CurvedBlocks<D>& blocks = must(of_rank);
        for (std::size_t b = 0; b < blocks.curved.size(); ++b) {
            const CurvedBlock<D>& block = blocks.curved[b];
            const GlobalNumber first = blocks.first_edges[blocks.blocks.layout.first_blocks[0] + b];
            (void)first;
            std::size_t number = 0;
            for (std::size_t i = 0; i < blocks.blocks.layout.size(); ++i)
                if (blocks.blocks.layout.first_vertices[i] == blocks.blocks.own[b].vertices[blocks.blocks.own[b].first])
                    number = blocks.first_edges[i];
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

template <int D>
void compare(const LinearMesh<D>& mesh, std::size_t elements_of_block, const CurveMeshOptions& options,
             double tolerance = 1e-12) {
    const auto whole = must(curve_mesh<D>(mesh, {}, options, plainly(alone)));
    CurveBlocksOptions by_blocks{{elements_of_block}, options};
    const auto on = [&](std::size_t ranks) {
        return on_ranks(ranks, [&](Ranks& among) {
            const auto rows = rows_of(mesh);
            return curve_blocks<D>(*rows, BlocksGoal<D>{}, by_blocks, among, plainly(alone));
        });
    };
    const auto one = on(1), three = on(3);
    const auto nodes = nodes_of(one);
    REQUIRE(nodes.size() == whole.mesh.edges.size());
    CHECK(nodes == nodes_of(three));
    const double farthest = farthest_of_chord(whole.mesh, nodes);
    MESSAGE(mesh.elements.size(), " elements in ", must(one.front()).blocks.layout.size(), " blocks: ", farthest);
    CHECK(farthest < tolerance);
    const BlocksValidation& after = must(one.front()).after;
    CHECK(after.invalid == whole.after.invalid);
    CHECK(after.smallest == whole.after.smallest);
}

}  // namespace

TEST_CASE("curving by blocks is that of the whole mesh") {
    SUBCASE("2D") { compare(shell<2>(0.1), 300, {}); }
    SUBCASE("3D") { compare(shell<3>(0.25), 1500, {}); }
    SUBCASE("3D by energy") {
        CurveMeshOptions options;
        options.curve.objective = Objective::energy;
        compare(shell<3>(0.35), 1500, options, 1e-9);  // searches and programmes of repair carry rounding on
    }
}
