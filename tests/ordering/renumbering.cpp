// Renumbered meshes have the same entities, and the inverse renumbering restores the mesh.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.ordering;

using namespace camber;
using namespace camber::testing;

namespace {

template <class T>
Column<T> some(std::size_t count, Dice& dice, auto&& make) {
    Buffer<T> rows;
    for (std::size_t i = 0; i < count; ++i)
        if (dice.below(3) == 0) rows.push_back(make(i));
    return rows;
}

template <class EntityId>
Permutation<EntityId> any_order(std::size_t count, std::uint64_t seed) {
    Buffer<EntityId> ids;
    for (std::size_t i = 0; i < count; ++i) ids.push_back(EntityId(i));
    std::shuffle(ids.begin(), ids.end(), std::mt19937_64(seed));
    return must(permutation(Column<EntityId>(std::move(ids)), one_thread));
}

/// A random mesh with data of every kind.
template <int D>
LinearMesh<D> full_mesh(std::uint64_t seed) {
    Dice dice(seed);
    LatticeOptions<D> options;
    for (int& n : options.cells) n = 1 + static_cast<int>(dice.below(D == 2 ? 6 : 3));
    if (dice.below(2) != 0) options.keep = all_but_one_in<D>(4, seed);
    LinearMesh<D> mesh = lattice_mesh(options);
    const auto any = [&] { return static_cast<Reference>(dice.below(100)); };
    const std::size_t vertices = mesh.points.size(), elements = mesh.elements.size();
    mesh.point_references = must(map_each(one_thread, vertices, [&](std::size_t) { return any(); }));
    mesh.elements.references = must(map_each(one_thread, elements, [&](std::size_t) { return any(); }));
    if (dice.below(2) != 0) mesh.elements.entities = mesh.elements.references;
    mesh.elements.required =
        some<std::uint32_t>(elements, dice, [](std::size_t e) { return static_cast<std::uint32_t>(e); });
    const auto vertex = [](std::size_t v) { return VertexId(v); };
    mesh.corners = some<VertexId>(vertices, dice, vertex);
    mesh.required_vertices = some<VertexId>(vertices, dice, vertex);
    const auto around = must(balls(mesh, one_thread));
    Buffer<SimplexVertices<D - 1>> facets;
    for (const ElementFace face : boundary_faces<D>(must(neighbours(mesh, around, one_thread))))
        facets.push_back(face_of(mesh, face));
    mesh.facets.references = must(map_each(one_thread, facets.size(), [&](std::size_t) { return any(); }));
    mesh.facets.vertices = std::move(facets);
    if (D == 3) {
        mesh.edges.vertices = some<SimplexVertices<1>>(elements, dice, [&](std::size_t e) {
            return SimplexVertices<1>{mesh.elements.vertices[e][2], mesh.elements.vertices[e][0]};
        });
        mesh.edges.references = Buffer<Reference>(mesh.edges.vertices.size(), 3);
    }
    mesh.geometry.normals = {Buffer<Vec<D>>(1, dice.vector<D>()), some<DirectionRow>(vertices, dice, [](std::size_t v) {
                                 return DirectionRow{VertexId(v)};
                             })};
    mesh.geometry.on_surfaces = some<Association<2>>(
        vertices, dice, [&](std::size_t v) { return Association<2>{.item = VertexId(v), .entity = any()}; });
    return mesh;
}

template <int D>
Renumbering any_renumbering(const LinearMesh<D>& mesh, std::uint64_t seed) {
    return {any_order<VertexId>(mesh.points.size(), seed + 1), any_order<ElementId>(mesh.elements.size(), seed + 2)};
}

/// True if the vertices of both simplices have the same points in order.
template <int D, int K>
bool has_points_of(const LinearMesh<D>& now, const SimplexVertices<K>& is, const LinearMesh<D>& before,
                   const SimplexVertices<K>& was) {
    bool same = true;
    for (std::size_t i = 0; i < is.size(); ++i) same = same && now.points[is[i]] == before.points[was[i]];
    return same;
}

template <int D>
void check_renumbering(std::uint64_t seed) {
    const LinearMesh<D> mesh = full_mesh<D>(seed);
    const Renumbering order = any_renumbering(mesh, seed);
    const LinearMesh<D> now = must(renumbered(mesh, order, Execution{.threads = 2}));
    RC_ASSERT(must(renumbered(now, inverse(order), one_thread)) == mesh);
    for (std::size_t v = 0; v < now.points.size(); ++v) {
        const VertexId was = order.vertices.before[v];
        RC_ASSERT(now.points[v] == mesh.points[was]);
        RC_ASSERT(now.point_references[v] == mesh.point_references[was]);
    }
    for (std::size_t e = 0; e < now.elements.size(); ++e) {
        const ElementId was = order.elements.before[e];
        RC_ASSERT((has_points_of<D, D>(now, now.elements.vertices[e], mesh, mesh.elements.vertices[was])));
        RC_ASSERT(now.elements.references[e] == mesh.elements.references[was]);
    }
    for (std::size_t f = 0; f < now.facets.size(); ++f)
        RC_ASSERT((has_points_of<D, D - 1>(now, now.facets.vertices[f], mesh, mesh.facets.vertices[f])));
    for (std::size_t e = 0; e < now.edges.size(); ++e)
        RC_ASSERT((has_points_of<D, 1>(now, now.edges.vertices[e], mesh, mesh.edges.vertices[e])));
    for (std::size_t i = 0; i < mesh.corners.size(); ++i)
        RC_ASSERT(now.points[now.corners[i]] == mesh.points[mesh.corners[i]]);
    for (std::size_t i = 0; i < mesh.elements.required.size(); ++i)
        RC_ASSERT(now.elements.vertices[now.elements.required[i]].size() == D + 1 &&
                  order.elements.before[now.elements.required[i]].value == mesh.elements.required[i]);
    for (std::size_t i = 0; i < mesh.geometry.on_surfaces.size(); ++i) {
        const auto &is = now.geometry.on_surfaces[i], &was = mesh.geometry.on_surfaces[i];
        RC_ASSERT(now.points[is.item] == mesh.points[was.item] && is.entity == was.entity);
    }
}

template <int D>
void check_quadratic_renumbering(std::uint64_t seed) {
    QuadraticMesh<D> mesh = must(elevate(full_mesh<D>(seed), one_thread));
    Dice dice(seed);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (auto& node : nodes) node.point = node.point + 0.1 * dice.vector<D>();
    mesh.mid_nodes = std::move(nodes);
    const Renumbering order = any_renumbering(mesh.linear, seed);
    const auto [now, edges] = must(renumbered(mesh, order, Execution{.threads = 2}));
    RC_ASSERT(must(renumbered(now, inverse(order), one_thread)).mesh == mesh);
    RC_ASSERT(now.linear == must(renumbered(mesh.linear, order, one_thread)));
    for (std::size_t e = 0; e < now.edges.size(); ++e) {
        const auto [a, b] = now.edges.vertices[e];
        const EdgeId was = find_edge(mesh.edges, order.vertices.before[a], order.vertices.before[b]);
        RC_ASSERT(edges[e] == was);
        RC_ASSERT(now.mid_nodes[e] == mesh.mid_nodes[was]);
    }
}

}  // namespace

TEST_CASE("renumbering preserves a mesh and can be inverted") {
    property("renumbering preserves the mesh and can be inverted, 2D",
             [](std::uint64_t seed) { check_renumbering<2>(seed); });
    property("renumbering preserves the mesh and can be inverted, 3D",
             [](std::uint64_t seed) { check_renumbering<3>(seed); });
    property("renumbering preserves the node of each edge, 2D, degree 2",
             [](std::uint64_t seed) { check_quadratic_renumbering<2>(seed); });
    property("renumbering preserves the node of each edge, 3D, degree 2",
             [](std::uint64_t seed) { check_quadratic_renumbering<3>(seed); });
}

TEST_CASE("renumbering keeps rows of several values together") {
    const auto order = must(permutation(Column<VertexId>({VertexId(2), VertexId(0), VertexId(1)}), one_thread));
    const Column<int> rows({1, 2, 3, 4, 5, 6});
    CHECK(must(renumbered_rows(rows, order.before, one_thread, 2)) == Column<int>({5, 6, 1, 2, 3, 4}));
    CHECK(must(renumbered_rows(Column<int>{}, order.before, one_thread)).empty());
}
