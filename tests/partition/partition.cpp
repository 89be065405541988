// Parts have about the same size, are reproducible and together form the mesh.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "cut_meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.partition;

using namespace camber;
using cut::one_thread, cut::must;

namespace {

template <int D>
void check_pieces(std::uint64_t seed) {
    const auto mesh = cut::mesh<D>(seed, 3);
    const auto count = *rc::gen::inRange<std::size_t>(1, 5);
    const CellParts parts = cut::any_parts(mesh.linear, count, seed);
    std::size_t elements = 0, facets = 0;
    for (std::size_t p = 0; p < count; ++p) {
        const auto piece = must(piece_of(mesh, parts, static_cast<std::int32_t>(p), one_thread));
        const LinearMesh<D>& own = piece.mesh.linear;
        elements += own.elements.size();
        facets += own.facets.size();
        for (std::size_t e = 0; e < own.elements.size(); ++e) {
            RC_ASSERT(own.elements.references[e] == mesh.linear.elements.references[piece.elements[e]]);
            for (int i = 0; i <= D; ++i)
                RC_ASSERT(piece.vertices[own.elements.vertices[e][i].index()] ==
                          mesh.linear.elements.vertices[piece.elements[e]][i].value);
            for (int i = 0; i < edges_per_simplex<D>; ++i)
                RC_ASSERT(piece.mid_nodes[piece.mesh.edges.of_elements[e][i].index()] ==
                          mesh.edges.of_elements[piece.elements[e]][i].value);
        }
        for (std::size_t f = 0; f < own.facets.size(); ++f)
            RC_ASSERT(own.facets.references[f] == mesh.linear.facets.references[piece.facets[f]]);
        for (std::size_t v = 0; v < own.points.size(); ++v)
            RC_ASSERT(own.points[v] == mesh.linear.points[piece.vertices[v]]);
        for (std::size_t e = 0; e < piece.mesh.mid_nodes.size(); ++e)
            RC_ASSERT(piece.mesh.mid_nodes[e] == mesh.mid_nodes[piece.mid_nodes[e]]);
    }
    RC_ASSERT(elements == mesh.linear.elements.size());
    RC_ASSERT(facets == mesh.linear.facets.size());
}

}  // namespace

TEST_CASE("pieces have the data of the mesh and each cell once") {
    testing::property("2D", check_pieces<2>);
    testing::property("3D", check_pieces<3>);
}

TEST_CASE("facets are in the part of an element that they bound") {
    const auto mesh = cut::mesh<3>(1, 3).linear;
    const CellParts parts = cut::any_parts(mesh, 4, 2);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        std::set<std::int32_t> around;
        for (std::size_t e = 0; e < mesh.elements.size(); ++e)
            if (std::ranges::all_of(mesh.facets.vertices[f],
                                    [&](VertexId v) { return std::ranges::count(mesh.elements.vertices[e], v) > 0; }))
                around.insert(parts.elements[e]);
        CHECK(around.count(parts.facets[f]) == 1);
    }
}

TEST_CASE("Scotch makes balanced, reproducible parts with few faces between them") {
    const auto mesh = cut::mesh<3>(3, 8).linear;  // 3072 tetrahedra
    const auto one = partition<3>(mesh, 1, one_thread);
    CHECK(std::ranges::count(one->elements, 0) == static_cast<std::ptrdiff_t>(mesh.elements.size()));
    const auto parts = partition<3>(mesh, 6, one_thread);
    if (!parts) {
        CHECK(parts.error().kind == ErrorKind::unsupported);
        return;
    }
    for (std::int32_t p = 0; p < 6; ++p) {
        const auto size = std::ranges::count(parts->elements, p);
        CHECK(size > 460);  // of 512
        CHECK(size < 564);
    }
    const DualGraph graph = must(dual_graph(mesh, one_thread));
    std::size_t between = 0;
    for (std::size_t e = 0; e < graph.size(); ++e)
        for (std::uint32_t i = graph.starts[e]; i < graph.starts[e + 1]; ++i)
            between += parts->elements[e] != parts->elements[graph.neighbours[i]] ? 1 : 0;
    CHECK(between < graph.neighbours.size() / 5);
    const auto again = partition<3>(mesh, 6, {.threads = 2});
    CHECK(again->elements == parts->elements);
}

TEST_CASE("a surface mesh is divided by its triangles") {
    auto mesh = cut::mesh<3>(3, 4).linear;
    mesh.elements = {};
    mesh.edges.vertices = Buffer<SimplexVertices<1>>{{mesh.facets.vertices[5][0], mesh.facets.vertices[5][1]}};
    mesh.edges.references = Buffer<Reference>{1};
    const DualGraph graph = must(dual_graph(mesh, one_thread));
    CHECK(graph.size() == mesh.facets.size());
    CHECK(graph.neighbours.size() == 3 * mesh.facets.size());  // the boundary of a box is closed
    CHECK(partition<3>(mesh, mesh.facets.size() + 1, one_thread).error().kind == ErrorKind::usage);
    const auto parts = partition<3>(mesh, 3, one_thread);
    if (!parts) {
        CHECK(parts.error().kind == ErrorKind::unsupported);
        return;
    }
    std::size_t facets = 0, edges = 0;
    for (std::int32_t p = 0; p < 3; ++p) {
        const auto piece = must(piece_of(mesh, *parts, p, one_thread));
        facets += piece.mesh.facets.size();
        edges += piece.mesh.edges.size();
        CHECK(piece.mesh.facets.size() > mesh.facets.size() / 4);
    }
    CHECK(facets == mesh.facets.size());
    CHECK(edges == 1);
}

TEST_CASE("invalid numbers of parts are rejected") {
    const auto mesh = cut::mesh<2>(3, 2).linear;
    CHECK(partition<2>(mesh, 0, one_thread).error().kind == ErrorKind::usage);
    CHECK(partition<2>(mesh, 9, one_thread).error().kind == ErrorKind::usage);
}
