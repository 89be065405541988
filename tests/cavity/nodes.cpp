// Nodes of degree 2 follow their edges: a patch changes only the nodes of the edges at its point.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "domains.hpp"
#include "mesh_invariants.hpp"
#include "property.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

using Ends = std::array<VertexId, 2>;
Ends ends_of(VertexId a, VertexId b) { return {std::min(a, b), std::max(a, b)}; }

template <int D>
Vec<D> anywhere(Dice& dice) {
    Vec<D> p;
    for (double& x : p.c) x = dice.uniform(-1, 1);
    return p;
}

template <int D>
DynamicMesh<D> curved_domain(std::uint64_t seed, Dice& dice) {
    QuadraticMesh<D> mesh;
    mesh.linear = random_domain<D>(seed);
    mesh.edges = must(unique_edges(mesh.linear, one_thread));
    Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
    for (auto& node : nodes) node.point = anywhere<D>(dice);
    mesh.mid_nodes = std::move(nodes);
    return must(make_dynamic(mesh, {}, one_thread));
}

/// The node of each edge, keyed by its ends.
template <int D>
std::map<Ends, Vec<D>> nodes_by_ends(const DynamicMesh<D>& mesh) {
    std::map<Ends, Vec<D>> nodes;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (!mesh.is_free(EdgeId(e))) nodes[mesh.edges[e]] = mesh.nodes[e].point;
    return nodes;
}

/// The edges of elements and facets outside a cavity.
template <int D>
std::map<Ends, Vec<D>> outer_nodes(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    std::map<Ends, Vec<D>> nodes;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (mesh.is_free(ElementId(e)) ||
            std::ranges::find(patch.removed.elements, ElementId(e)) != patch.removed.elements.end())
            continue;
        for (const EdgeId edge : mesh.edges_of[e]) nodes[mesh.edges[edge]] = mesh.nodes[edge].point;
    }
    const auto known = nodes_by_ends(mesh);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.is_free(FacetId(f)) ||
            std::ranges::find(patch.removed.facets, FacetId(f)) != patch.removed.facets.end())
            continue;
        const auto& facet = mesh.facets.vertices[f];
        for (const auto& [i, j] : local_edges<D - 1>) nodes.insert(*known.find(ends_of(facet[i], facet[j])));
    }
    return nodes;
}

template <int D>
void check_followed_nodes(std::uint64_t seed) {
    Dice dice(seed);
    DynamicMesh<D> mesh = curved_domain<D>(seed, dice);
    std::map<Ends, Vec<D>> known = nodes_by_ends(mesh);
    StarWorkspace<D> workspace;
    for (int step = 0; step < 12; ++step) {
        auto patch = Trying<D>(mesh, dice, workspace).planned(kinds<D>()[dice.below(kinds<D>().size())]).patch;
        if (!patch) continue;
        const auto outer = outer_nodes(mesh, *patch);
        for (const VertexId v : patch->star.boundary) {
            const auto existing =
                patch->point.vertex.valid() ? outer.find(ends_of(patch->point.vertex, v)) : outer.end();
            patch->nodes.push_back({existing == outer.end() ? anywhere<D>(dice) : existing->second});
        }
        const auto nodes = patch->nodes;
        const auto boundary = patch->star.boundary;
        auto changed = must(replace_cavities<D>(std::move(mesh), {&*patch, 1}));
        mesh = std::move(changed.mesh);
        for (std::size_t i = 0; i < nodes.size(); ++i)
            known[ends_of(changed.changes.points[0], boundary[i])] = nodes[i].point;
        RC_ASSERT(check_consistency(mesh, one_thread).has_value());
        for (const auto& [ends, node] : nodes_by_ends(mesh)) RC_ASSERT(known.at(ends) == node);
    }
    const auto compact = must(compacted(mesh, one_thread));
    RC_ASSERT(compact.nodes.size() == compact.edges.size());
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (const EdgeId to = compact.maps.edges[EdgeId(e)]; to.valid()) RC_ASSERT(compact.nodes[to] == mesh.nodes[e]);
}

}  // namespace

TEST_CASE("mid nodes follow their edges through random operations") {
    property("2D", [](std::uint64_t seed) { check_followed_nodes<2>(seed); });
    property("3D", [](std::uint64_t seed) { check_followed_nodes<3>(seed); }, {.count = 40});
}

TEST_CASE("replace_cavities rejects nodes that do not fit the mesh") {
    Dice dice(3);
    const DynamicMesh<3> mesh = curved_domain<3>(7, dice);
    StarWorkspace<3> workspace;
    auto patch = Trying<3>(mesh, dice, workspace).planned({Operation::insert, VertexPlace::inside}).patch.value();
    const auto without = replace_cavities<3>(mesh, {&patch, 1});
    REQUIRE(!without.has_value());
    CHECK(without.error().what == "a patch must have one node for each edge at its point");

    for (int tries = 0; tries < 5000; ++tries) {
        auto swapped = Trying<3>(mesh, dice, workspace).planned({Operation::swap_edge, VertexPlace::inside}).patch;
        if (!swapped || swapped->star.preserved.empty()) continue;
        swapped->nodes.assign(swapped->star.boundary.size(), {Vec<3>{{9, 9, 9}}});
        const auto moved = replace_cavities<3>(mesh, {&*swapped, 1});
        REQUIRE(!moved.has_value());
        CHECK(moved.error().what == "a patch moves a node of elements or facets outside its cavity");
        return;
    }
    FAIL("no swap was found");
}
