module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>
module camber.partition;
import camber.core;

namespace camber {

namespace {

/// Graph of a surface mesh: triangles that share an edge are neighbours. An edge may have any number of triangles.
Outcome<DualGraph> graph_of_surface(const LinearMesh<3>& mesh, const Execution& execution) {
    const auto edges = unique_edges(mesh, execution);
    if (!edges) return fail(edges.error());
    const auto shells = facet_shells(*edges, execution);
    if (!shells) return fail(shells.error());
    DualGraph graph;
    graph.starts.push_back(0);
    std::vector<std::uint32_t> beside;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        beside.clear();
        for (const EdgeId edge : edges->of_facets[f])
            for (const FacetId other : (*shells)[edge])
                if (other.index() != f) beside.push_back(other.value);
        std::sort(beside.begin(), beside.end());
        beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
        graph.neighbours.insert(graph.neighbours.end(), beside.begin(), beside.end());
        if (graph.neighbours.size() > std::numeric_limits<std::uint32_t>::max())
            return fail(ErrorKind::unsupported, "has more edges between triangles than 32 bits can number");
        graph.starts.push_back(static_cast<std::uint32_t>(graph.neighbours.size()));
    }
    return graph;
}

}  // namespace

template <int D>
Outcome<DualGraph> dual_graph(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<DualGraph> {
        if constexpr (D == 3)
            if (is_standalone_surface(mesh)) return graph_of_surface(mesh, execution);
        const auto around = balls(mesh, execution);
        if (!around) return fail(around.error());
        const auto across = neighbours(mesh, *around, execution);
        if (!across) return fail(across.error());
        DualGraph graph;
        graph.starts.resize(mesh.elements.size() + 1);
        std::size_t arcs = 0;
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
            graph.starts[e] = static_cast<std::uint32_t>(arcs);
            arcs += static_cast<std::size_t>(std::ranges::count_if((*across)[e], &ElementId::valid));
            if (arcs > std::numeric_limits<std::uint32_t>::max())
                return fail(ErrorKind::unsupported, "has more faces between elements than 32 bits can number");
        }
        graph.starts.back() = static_cast<std::uint32_t>(arcs);
        graph.neighbours.resize(arcs);
        auto filled = each(execution, mesh.elements.size(), [&](std::size_t e) {
            std::uint32_t* const begin = graph.neighbours.data() + graph.starts[e];
            std::uint32_t* at = begin;
            for (const ElementId other : (*across)[e])
                if (other.valid()) *at++ = other.value;
            std::sort(begin, at);
        });
        if (!filled) return fail(std::move(filled.error()));
        return graph;
    });
}

template Outcome<DualGraph> dual_graph<2>(const LinearMesh<2>&, const Execution&);
template Outcome<DualGraph> dual_graph<3>(const LinearMesh<3>&, const Execution&);

namespace {

/// For each simplex, the part of the lowest cell that contains all its vertices; 0 if there is no such cell.
template <int C, int K, class Id>
Outcome<Column<std::int32_t>> parts_of(const Simplices<C>& cells, const Incidence<Id>& balls,
                                       const Simplices<K>& simplices, const Column<std::int32_t>& parts,
                                       const Execution& execution) {
    return map_each(execution, simplices.size(),
                    [&](std::size_t s) -> std::int32_t {
                        const SimplexVertices<K>& simplex = simplices.vertices[s];
                        for (const Id c : balls[simplex[0]])  // cells are in ascending order
                            if (std::ranges::all_of(simplex, [&](VertexId v) {
                                    return std::ranges::find(cells.vertices[c], v) != cells.vertices[c].end();
                                }))
                                return parts[c];
                        return 0;
                    })
        .map([](Buffer<std::int32_t> result) { return Column<std::int32_t>(std::move(result)); });
}

Outcome<CellParts> parts_of_surface(const LinearMesh<3>& mesh, Column<std::int32_t> facets,
                                    const Execution& execution) {
    const auto around = facet_balls(mesh, execution);
    if (!around) return fail(around.error());
    auto edges = parts_of(mesh.facets, *around, mesh.edges, facets, execution);
    if (!edges) return fail(std::move(edges.error()));
    return CellParts{{}, std::move(facets), std::move(*edges)};
}

}  // namespace

template <int D>
Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                  const Execution& execution) {
    if constexpr (D == 3)
        if (is_standalone_surface(mesh)) return parts_of_surface(mesh, std::move(elements), execution);
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto facets = parts_of(mesh.elements, *around, mesh.facets, elements, execution);
    if (!facets) return fail(std::move(facets.error()));
    auto edges = parts_of(mesh.elements, *around, mesh.edges, elements, execution);
    if (!edges) return fail(std::move(edges.error()));
    return CellParts{std::move(elements), std::move(*facets), std::move(*edges)};
}

template <int D>
Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution) {
    const std::size_t cells = is_standalone_surface(mesh) ? mesh.facets.size() : mesh.elements.size();
    if (parts == 0 || parts > std::max<std::size_t>(cells, 1))
        return fail(ErrorKind::usage, "a mesh of " + std::to_string(cells) +
                                          (is_standalone_surface(mesh) ? " triangles" : " elements") + " has no " +
                                          std::to_string(parts) + " parts");
    const auto graph = dual_graph(mesh, execution);
    if (!graph) return fail(graph.error());
    return guarded([&] { return parts_of_graph(*graph, parts); }).and_then([&](Buffer<std::int32_t> of_cells) {
        return parts_of_cells(mesh, std::move(of_cells), execution);
    });
}

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
    LinearMesh<D> result;
    result.points = chosen(mesh.points, vertices);
    result.point_references = chosen(mesh.point_references, vertices);
    result.corners = renumbered(mesh.corners, vertices);
    result.required_vertices = renumbered(mesh.required_vertices, vertices);
    result.elements = some_of(mesh.elements, elements, number);
    result.facets = some_of(mesh.facets, facets, number);
    result.edges = some_of(mesh.edges, edges, number);
    result.ridges = renumbered(mesh.ridges, D == 2 ? facets : edges);
    result.groups = mesh.groups;
    return {std::move(result), vertices, elements, facets, edges};
}

/// For each edge in `own`, its row in `whole`, where edges are sorted by vertices. `vertices`: number in `whole` of
/// each vertex.
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
Outcome<MeshPiece<LinearMesh<D>>> make_piece(const LinearMesh<D>& mesh, const CellParts& parts, std::int32_t part,
                                             const Execution&) {
    return linear_piece(mesh, parts, part);
}
template <int D>
Outcome<MeshPiece<QuadraticMesh<D>>> make_piece(const QuadraticMesh<D>& mesh, const CellParts& parts, std::int32_t part,
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
    return guarded([&] { return make_piece(mesh, parts, part, execution); });
}

#define CAMBER_INSTANTIATE(MESH) \
    template Outcome<MeshPiece<MESH>> piece_of<MESH>(const MESH&, const CellParts&, std::int32_t, const Execution&);

CAMBER_INSTANTIATE(LinearMesh<2>)
CAMBER_INSTANTIATE(LinearMesh<3>)
CAMBER_INSTANTIATE(QuadraticMesh<2>)
CAMBER_INSTANTIATE(QuadraticMesh<3>)
#undef CAMBER_INSTANTIATE

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<CellParts> partition<D>(const LinearMesh<D>&, std::size_t, const Execution&); \
    template Outcome<CellParts> parts_of_cells<D>(const LinearMesh<D>&, Column<std::int32_t>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
