module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.partition;
import camber.core;

namespace camber {

namespace {

using Rows = Buffer<std::uint32_t>;
constexpr std::uint32_t none = VertexId().value;

Rows rows_of(const Column<std::int32_t>& parts, std::int32_t part) {
    Rows rows;
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (parts[i] == part) rows.push_back(static_cast<std::uint32_t>(i));
    return rows;
}

template <class T>
Column<T> chosen(const Column<T>& column, const Rows& rows) {
    Buffer<T> some;
    if (column.empty()) return some;
    some.reserve(rows.size());
    for (const std::uint32_t row : rows) some.push_back(column[row]);
    return some;
}

/// The new numbers of those in a list that stay; `rows` rise.
template <class Item>
Column<Item> renumbered(const Column<Item>& list, const Rows& rows) {
    Buffer<Item> some;
    for (const Item item : list) {
        std::uint32_t number = 0;
        if constexpr (requires { item.value; })
            number = item.value;
        else
            number = item;
        const auto at = std::ranges::lower_bound(rows, number);
        if (at != rows.end() && *at == number) some.push_back(Item(static_cast<std::size_t>(at - rows.begin())));
    }
    return some;
}

template <int K>
void mark(const Simplices<K>& kind, const Rows& rows, Buffer<std::uint8_t>& used) {
    for (const std::uint32_t row : rows)
        for (const VertexId v : kind.vertices[row]) used[v.index()] = 1;
}

template <int K>
Simplices<K> some_of(const Simplices<K>& kind, const Rows& rows, const Rows& number) {
    Buffer<SimplexVertices<K>> vertices;
    vertices.reserve(rows.size());
    for (const std::uint32_t row : rows) {
        SimplexVertices<K> simplex = kind.vertices[row];
        for (VertexId& v : simplex) v = VertexId(std::size_t{number[v.index()]});
        vertices.push_back(simplex);
    }
    return {std::move(vertices), chosen(kind.references, rows), renumbered(kind.required, rows),
            chosen(kind.entities, rows)};
}

template <int D>
MeshPiece<LinearMesh<D>> linear_piece(const LinearMesh<D>& mesh, const CellParts& parts, std::int32_t part) {
    const Rows elements = rows_of(parts.elements, part), facets = rows_of(parts.facets, part),
               edges = rows_of(parts.edges, part);
    Buffer<std::uint8_t> used(mesh.points.size(), 0);
    mark(mesh.elements, elements, used);
    mark(mesh.facets, facets, used);
    mark(mesh.edges, edges, used);
    Rows vertices, number(used.size(), none);
    for (std::size_t v = 0; v < used.size(); ++v) {
        if (used[v] == 0) continue;
        number[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(static_cast<std::uint32_t>(v));
    }
    LinearMesh<D> made;
    made.points = chosen(mesh.points, vertices);
    made.point_references = chosen(mesh.point_references, vertices);
    made.corners = renumbered(mesh.corners, vertices);
    made.required_vertices = renumbered(mesh.required_vertices, vertices);
    made.elements = some_of(mesh.elements, elements, number);
    made.facets = some_of(mesh.facets, facets, number);
    made.edges = some_of(mesh.edges, edges, number);
    made.ridges = renumbered(mesh.ridges, D == 2 ? facets : edges);
    made.groups = mesh.groups;
    return {std::move(made), vertices, elements, facets, edges};
}

/// The edges of a piece among those of the whole, which are sorted by their vertices.
template <int D>
Outcome<Rows> edges_in(const EdgeSet<D>& whole, const EdgeSet<D>& own, const Column<std::uint32_t>& vertices,
                       const Execution& execution) {
    return map_each(execution, own.size(), [&](std::size_t e) {
        const auto& [a, b] = own.vertices[e];
        const std::array ends{VertexId(std::size_t{vertices[a]}), VertexId(std::size_t{vertices[b]})};
        return static_cast<std::uint32_t>(std::ranges::lower_bound(whole.vertices, ends) - whole.vertices.begin());
    });
}

template <int D>
Outcome<MeshPiece<LinearMesh<D>>> made_piece(const LinearMesh<D>& mesh, const CellParts& parts, std::int32_t part,
                                             const Execution&) {
    return linear_piece(mesh, parts, part);
}
template <int D>
Outcome<MeshPiece<QuadraticMesh<D>>> made_piece(const QuadraticMesh<D>& mesh, const CellParts& parts, std::int32_t part,
                                                const Execution& execution) {
    auto linear = linear_piece(mesh.linear, parts, part);
    auto edges = unique_edges(linear.mesh, execution);
    if (!edges) return fail(std::move(edges.error()));
    auto rows = edges_in(mesh.edges, *edges, linear.vertices, execution);
    if (!rows) return fail(std::move(rows.error()));
    auto mid_nodes = chosen(mesh.mid_nodes, *rows);
    return MeshPiece<QuadraticMesh<D>>{{std::move(linear.mesh), std::move(*edges), std::move(mid_nodes)},
                                       std::move(linear.vertices),
                                       std::move(linear.elements),
                                       std::move(linear.facets),
                                       std::move(linear.edges),
                                       std::move(*rows)};
}

}  // namespace

template <class Mesh>
Outcome<MeshPiece<Mesh>> piece_of(const Mesh& mesh, const CellParts& parts, std::int32_t part,
                                  const Execution& execution) {
    return guarded([&] { return made_piece(mesh, parts, part, execution); });
}

#define CAMBER_INSTANTIATE(MESH) \
    template Outcome<MeshPiece<MESH>> piece_of<MESH>(const MESH&, const CellParts&, std::int32_t, const Execution&);

CAMBER_INSTANTIATE(LinearMesh<2>)
CAMBER_INSTANTIATE(LinearMesh<3>)
CAMBER_INSTANTIATE(QuadraticMesh<2>)
CAMBER_INSTANTIATE(QuadraticMesh<3>)
#undef CAMBER_INSTANTIATE

}  // namespace camber
