module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

namespace {

/// Ids of what stays, rising, and how many these are; invalid elsewhere.
template <class Id>
struct NewIds {
    Buffer<Id> of;
    std::size_t count = 0;
};
/// What is there, and not at infinity: of a surface alone no element is.
template <int D>
bool stays(const DynamicMesh<D>& mesh, VertexId v) {
    return !mesh.is_free(v) && !mesh.is_at_infinity(v);
}
template <int D>
bool stays(const DynamicMesh<D>& mesh, FacetId f) {
    return !mesh.is_free(f) && !mesh.is_at_infinity(f);
}
template <int D>
bool stays(const DynamicMesh<D>& mesh, ElementId e) {
    return !mesh.is_free(e) && !mesh.is_surface();
}
template <class Id, int D>
NewIds<Id> new_ids(const DynamicMesh<D>& mesh, std::size_t places) {
    NewIds<Id> ids{Buffer<Id>(places)};
    for (std::size_t i = 0; i < places; ++i) ids.of[i] = stays(mesh, Id(i)) ? Id(ids.count++) : Id{};
    return ids;
}

/// The rows that stay.
template <class T, class Id>
Column<T> rows(const Column<T>& column, const NewIds<Id>& ids) {
    if (column.empty() || ids.count == ids.of.size()) return column;
    Buffer<T> out;
    out.reserve(ids.count);
    for (std::size_t i = 0; i < ids.of.size(); ++i)
        if (ids.of[i].valid()) out.push_back(column[i]);
    return out;
}

template <class Id>
Column<std::uint32_t> marked(const Column<Marks>& marks, const Buffer<Id>& ids, Mark mark) {
    Buffer<std::uint32_t> out;
    for (std::size_t i = 0; i < ids.size(); ++i)
        if (ids[i].valid() && marks[i].has(mark)) out.push_back(ids[i].value);
    return out;
}

template <int K, class Id>
Simplices<K> simplices(const DynamicSimplices<K>& from, const NewIds<Id>& ids, const Buffer<VertexId>& vertices) {
    auto kept = take(rows(from.vertices, ids));
    for (auto& simplex : kept)
        for (VertexId& v : simplex) v = vertices[v.index()];
    return {std::move(kept), rows(from.references, ids), marked(from.marks, ids.of, Mark::required),
            rows(from.entities, ids)};
}

template <int D>
Simplices<1> listed_lines(const DynamicMesh<D>& mesh, const Buffer<VertexId>& vertices, Column<std::uint32_t>& ridges) {
    Buffer<SimplexVertices<1>> ends;
    Buffer<Reference> references, entities;
    Buffer<std::uint32_t> required, sharp;
    for (std::size_t l = 0; l < mesh.lines.size(); ++l) {
        const Marks marks = mesh.line_marks[l];
        if (mesh.is_free(LineId(l)) || marks.has(Mark::implied) || mesh.is_at_infinity(mesh.lines[l])) continue;
        const auto row = static_cast<std::uint32_t>(ends.size());
        const auto& [a, b] = mesh.edges[mesh.lines[l]];
        ends.push_back({vertices[a.index()], vertices[b.index()]});
        references.push_back(mesh.line_references[l]);
        entities.push_back(mesh.line_entities[l]);
        if (marks.has(Mark::required)) required.push_back(row);
        if (marks.has(Mark::ridge)) sharp.push_back(row);
    }
    ridges = std::move(sharp);
    if (std::ranges::all_of(entities, [](Reference e) { return e == 0; })) entities.clear();
    return {std::move(ends), std::move(references), std::move(required), std::move(entities)};
}

template <int D>
DirectionsAtVertices<D> directions(const DirectionsAtVertices<D>& given, const DynamicMesh<D>& mesh,
                                   const Buffer<VertexId>& vertices) {
    Buffer<DirectionRow> at;
    for (const DirectionRow& row : given.at)
        if (const Marks marks = mesh.states[row.vertex].marks; marks.has(Mark::given) && !marks.has(Mark::moved))
            at.push_back({vertices[row.vertex.index()], row.row});
    return {given.table, std::move(at)};
}

template <int G, int D>
Column<Association<G>> associations(const Column<Association<G>>& given, const DynamicMesh<D>& mesh,
                                    const Buffer<VertexId>& vertices) {
    Buffer<Association<G>> out;
    for (Association<G> on : given) {
        const Marks marks = mesh.states[on.item].marks;
        if (!marks.has(Mark::given)) continue;
        if (marks.has(Mark::moved) && G < D - 1) continue;
        if (marks.has(Mark::moved)) on.parameters = {}, on.distance = {};
        on.item = vertices[on.item.index()];
        out.push_back(on);
    }
    return out;
}

template <int D>
void put_vertices(const DynamicMesh<D>& mesh, const NewIds<VertexId>& new_vertices, LinearMesh<D>& out) {
    const Buffer<VertexId>& ids = new_vertices.of;
    out.points = rows(mesh.points, new_vertices);
    out.point_references = rows(mesh.point_references, new_vertices);
    Buffer<VertexId> corners, required;
    for (std::size_t v = 0; v < ids.size(); ++v) {
        if (!ids[v].valid()) continue;
        if (mesh.states[v].marks.has(Mark::corner)) corners.push_back(ids[v]);
        if (mesh.states[v].marks.has(Mark::required)) required.push_back(ids[v]);
    }
    out.corners = std::move(corners);
    out.required_vertices = std::move(required);
    const GivenGeometry<D>& given = mesh.geometry;
    out.geometry = {directions(given.normals, mesh, ids), directions(given.tangents, mesh, ids),
                    associations(given.on_points, mesh, ids), associations(given.on_curves, mesh, ids),
                    associations(given.on_surfaces, mesh, ids)};
}

template <int D>
Outcome<IdMap<EdgeId>> edge_map(const DynamicMesh<D>& mesh, const Buffer<VertexId>& vertices, const EdgeSet<D>& edges,
                                const Execution& execution) {
    auto ids = map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges[e];
        return a.valid() && !mesh.is_at_infinity(EdgeId(e)) ? find_edge(edges, vertices[a.index()], vertices[b.index()])
                                                            : EdgeId{};
    });
    if (!ids) return fail(ids.error());
    return IdMap<EdgeId>(std::move(*ids));
}

template <int D>
Buffer<LagrangeNode<D>> nodes_of(const DynamicMesh<D>& mesh, const IdMap<EdgeId>& edges, std::size_t count) {
    Buffer<LagrangeNode<D>> out(count);
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (const EdgeId to = edges[EdgeId(e)]; to.valid()) out[to.index()] = mesh.nodes[e];
    return out;
}

}  // namespace

template <int D>
Outcome<CompactMesh<D>> compacted(const DynamicMesh<D>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<CompactMesh<D>> {
        CompactMesh<D> out;
        auto vertices = new_ids<VertexId>(mesh, mesh.points.size());
        auto facets = new_ids<FacetId>(mesh, mesh.facets.size());
        auto elements = new_ids<ElementId>(mesh, mesh.elements.size());
        put_vertices(mesh, vertices, out.mesh);
        out.mesh.elements = simplices<D>(mesh.elements, elements, vertices.of);
        out.mesh.facets = simplices<D - 1>(mesh.facets, facets, vertices.of);
        if constexpr (D == 3)
            out.mesh.edges = listed_lines(mesh, vertices.of, out.mesh.ridges);
        else
            out.mesh.ridges = marked(mesh.facets.marks, facets.of, Mark::ridge);
        out.mesh.groups = mesh.groups;
        auto edges = unique_edges(out.mesh, execution);
        if (!edges) return fail(edges.error());
        out.edges = std::move(*edges);
        auto edge_ids = edge_map(mesh, vertices.of, out.edges, execution);
        if (!edge_ids) return fail(edge_ids.error());
        if (mesh.is_curved()) out.nodes = nodes_of(mesh, *edge_ids, out.edges.size());
        out.maps = {IdMap<VertexId>(std::move(vertices.of)), std::move(*edge_ids),
                    IdMap<ElementId>(std::move(elements.of)), IdMap<FacetId>(std::move(facets.of))};
        return out;
    });
}

#define CAMBER_INSTANTIATE(D) template Outcome<CompactMesh<D>> compacted<D>(const DynamicMesh<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
