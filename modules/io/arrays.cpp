module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :arrays;
import :first_fault;
import :listing;

namespace camber {

namespace {

constexpr std::size_t grain = 65536;

template <int D>
Outcome<Done> check_points(const Column<Vec<D>>& points, const Execution& execution) {
    FirstFault fault;
    auto looked = each(
        execution, points.size(),
        [&](std::size_t i) {
            for (int d = 0; d < D; ++d)
                if (!std::isfinite(points[i][d])) return fault.note(i);
        },
        grain);
    if (!looked) return looked;
    if (!fault.any()) return Done{};
    return fail(ErrorKind::input, "has a coordinate that is not finite", "points", Entity{"row", fault.row()});
}

template <std::size_t N>
bool has_twice(const std::array<VertexId, N>& nodes) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (nodes[i] == nodes[j]) return true;
    return false;
}

/// `name`: what the caller knows the cells by.
template <int Nodes>
Outcome<Done> check_cells(const CellArray<Nodes>& cells, std::size_t points, const std::string& name,
                          const Execution& execution) {
    if (!cells.references.empty() && cells.references.size() != cells.nodes.size())
        return fail(
            ErrorKind::input,
            std::to_string(cells.references.size()) + " references of " + std::to_string(cells.nodes.size()) + " cells",
            name, {}, "give one a cell, or none");
    FirstFault missing, twice;
    auto looked = each(
        execution, cells.nodes.size(),
        [&](std::size_t c) {
            for (const VertexId v : cells.nodes[c])
                if (v.index() >= points) return missing.note(c);
            if (has_twice(cells.nodes[c])) twice.note(c);
        },
        grain);
    if (!looked) return looked;
    if (missing.any())
        return fail(ErrorKind::input, "has a node that is none of the " + std::to_string(points) + " points", name,
                    Entity{"row", missing.row()}, "nodes count the points from 0");
    if (twice.any()) return fail(ErrorKind::input, "has a node twice", name, Entity{"row", twice.row()});
    return Done{};
}

template <int K>
constexpr const char* name_of_cells(int degree) {
    constexpr std::array<std::array<const char*, 2>, 3> names{
        {{"line", "line3"}, {"triangle", "triangle6"}, {"tetra", "tetra10"}}};
    return names[K - 1][static_cast<std::size_t>(degree - 1)];
}
template <int K>
Outcome<Done> check_all(const CellArrays<K>& cells, std::size_t points, const Execution& execution) {
    auto done = check_cells(cells.straight, points, name_of_cells<K>(1), execution);
    return done ? check_cells(cells.curved, points, name_of_cells<K>(2), execution) : done;
}

Column<Reference> references_of(Column<Reference> given, std::size_t count) {
    if (!given.empty() || count == 0) return given;
    return Column<Reference>(Buffer<Reference>(count, 0));
}

template <int K>
Simplices<K> simplices_of(CellArray<K + 1> cells) {
    const std::size_t count = cells.nodes.size();
    return {std::move(cells.nodes), references_of(std::move(cells.references), count), {}};
}

/// As files list them.
template <int Nodes>
listing::Rows<Nodes> rows_of(CellArray<Nodes> cells, const char* name) {
    listing::Rows<Nodes> rows;
    const std::size_t count = cells.nodes.size();
    rows.nodes = take(std::move(cells.nodes));
    rows.references = take(references_of(std::move(cells.references), count));
    rows.origin.noun = name;
    return rows;
}
template <int K>
listing::Simplices<K> listed_of(CellArrays<K> cells) {
    listing::Simplices<K> listed;
    listed.straight = rows_of(std::move(cells.straight), name_of_cells<K>(1));
    listed.curved = rows_of(std::move(cells.curved), name_of_cells<K>(2));
    return listed;
}

template <int D>
Outcome<DecodedMesh> of_degree_2(MeshArrays<D> arrays, const Execution& execution) {
    listing::Mesh<D> mesh;
    mesh.name = "the arrays";
    const std::size_t points = arrays.points.size();
    mesh.points = take(std::move(arrays.points));
    mesh.point_references = take(references_of(std::move(arrays.point_references), points));
    mesh.elements = listed_of(std::move(arrays.elements));
    mesh.facets = listed_of(std::move(arrays.facets));
    if constexpr (D == 3) mesh.edges = listed_of(std::move(arrays.edges));
    mesh.groups.assign(arrays.groups.begin(), arrays.groups.end());
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, {}, execution);
}

template <int D>
DecodedMesh of_degree_1(MeshArrays<D> arrays) {
    LinearMesh<D> mesh;
    mesh.point_references = references_of(std::move(arrays.point_references), arrays.points.size());
    mesh.points = std::move(arrays.points);
    mesh.elements = simplices_of<D>(std::move(arrays.elements.straight));
    mesh.facets = simplices_of<D - 1>(std::move(arrays.facets.straight));
    if constexpr (D == 3) mesh.edges = simplices_of<1>(std::move(arrays.edges.straight));
    mesh.groups = Column<Group>(Buffer<Group>(arrays.groups.begin(), arrays.groups.end()));
    return DecodedMesh{AnyMesh(std::move(mesh)), {}};
}

}  // namespace

template <int D>
Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution) {
    const std::size_t points = arrays.points.size();
    if (!arrays.point_references.empty() && arrays.point_references.size() != points)
        return fail(ErrorKind::input, "are not one a point", "references of points");
    return check_points(arrays.points, execution)
        .and_then([&](Done) { return check_all(arrays.elements, points, execution); })
        .and_then([&](Done) { return check_all(arrays.facets, points, execution); })
        .and_then([&](Done) { return D == 3 ? check_all(arrays.edges, points, execution) : Outcome<Done>(Done{}); })
        .and_then([&](Done) -> Outcome<DecodedMesh> {
            const bool is_curved = arrays.elements.curved.nodes.size() + arrays.facets.curved.nodes.size() +
                                       arrays.edges.curved.nodes.size() >
                                   0;
            return is_curved ? of_degree_2(std::move(arrays), execution) : of_degree_1(std::move(arrays));
        });
}

template <int D>
Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner) {
    static_assert(sizeof(Vec<D>) == D * sizeof(double));
    const std::span<const Vec<D>> points(reinterpret_cast<const Vec<D>*>(coordinates.data()), coordinates.size() / D);
    return owner ? Column<Vec<D>>(points, std::move(owner))
                 : Column<Vec<D>>(Buffer<Vec<D>>(points.begin(), points.end()));
}

template <int K>
Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n) {
    Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes(vertices.size());
    for (std::size_t c = 0; c < vertices.size(); ++c) {
        for (std::size_t i = 0; i <= K; ++i) nodes[c][i] = vertices[c][i];
        for (std::size_t e = 0; e < edges_per_simplex<K>; ++e) nodes[c][K + 1 + e] = VertexId(n + edges[c][e].index());
    }
    return nodes;
}

#define CAMBER_INSTANTIATE(K)                                                    \
    template Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells<K>( \
        const Column<SimplexVertices<K>>&, const Column<std::array<EdgeId, edges_per_simplex<K>>>&, std::size_t);
CAMBER_INSTANTIATE(1)
CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE
template Column<Vec<2>> points_of<2>(std::span<const double>, std::shared_ptr<const void>);
template Column<Vec<3>> points_of<3>(std::span<const double>, std::shared_ptr<const void>);
template Outcome<DecodedMesh> mesh_of_arrays<2>(MeshArrays<2>, const Execution&);
template Outcome<DecodedMesh> mesh_of_arrays<3>(MeshArrays<3>, const Execution&);

}  // namespace camber
