// Dynamic meshes of parts, and meshes without free slots.
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

template <int D>
Outcome<Done> check_rows(const MeshPart<D>& part) {
    if (part.states.size() == part.mesh.points.size() && part.facet_marks.size() == part.mesh.facets.size() &&
        part.line_marks.size() == part.mesh.edges.size())
        return Done{};
    return fail(ErrorKind::internal, "the rows of a part of a mesh have inconsistent sizes");
}

template <int D>
Buffer<std::uint8_t> rim_of(const DynamicMesh<D>& mesh) {
    Buffer<std::uint8_t> on_rim(mesh.points.size(), 0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int face = 0; face <= D; ++face) {
            const FaceNeighbour across = mesh.face_neighbours[e][face];
            if (across.valid() && !(across.is_facet() && mesh.facets.marks[across.facet()].has(Mark::frozen))) continue;
            for (int i = 0; i <= D; ++i)
                if (i != face) on_rim[mesh.elements.vertices[e][i].index()] = 1;
        }
    return on_rim;
}

void put_lines(const MeshPart<3>& part, const EdgeSet<3>& edges, const Incidence<FacetId>& facet_shells,
               const Buffer<std::uint8_t>& on_rim, DynamicMesh<3>& mesh) {
    Buffer<LineId> of_edges(edges.size(), LineId{});
    Buffer<EdgeId> lines;
    const auto& listed = part.mesh.edges;
    Buffer<Reference> references(listed.references.begin(), listed.references.end());
    Buffer<Reference> entities(listed.entities.begin(), listed.entities.end());
    Buffer<Marks> marks(part.line_marks.begin(), part.line_marks.end());
    references.resize(listed.size(), 0);
    entities.resize(listed.size(), 0);
    for (std::size_t l = 0; l < listed.size(); ++l) {
        of_edges[edges.of_edges[l].index()] = LineId(l);
        lines.push_back(edges.of_edges[l]);
    }
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto& [a, b] = edges.vertices[e];
        if (of_edges[e].valid() || on_rim[a.index()] == 0 || on_rim[b.index()] == 0) continue;
        if (facet_shells[EdgeId(e)].size() != 1) continue;
        of_edges[e] = LineId(lines.size());
        lines.push_back(EdgeId(e));
        references.push_back(0);
        entities.push_back(0);
        marks.push_back(Mark::implied | Marks(Mark::required));
    }
    mesh.line_of = std::move(of_edges);
    mesh.lines = std::move(lines);
    mesh.line_references = std::move(references);
    mesh.line_entities = std::move(entities);
    mesh.line_marks = std::move(marks);
}

template <int D>
Outcome<Buffer<VertexState>> fixed_states(const MeshPart<D>& part, const DynamicMesh<D>& mesh,
                                          const Incidence<ElementId>& balls, const EdgeSet<D>& edges,
                                          const Buffer<std::uint8_t>& on_rim, const Execution& execution) {
    const auto around = shells(edges, execution);
    if (!around) return fail(around.error());
    Buffer<VertexState> states(part.states.begin(), part.states.end());
    auto done = each_chunk(execution, states.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<ElementId> found;
        for (std::size_t v = begin; v < end; ++v) {
            if (on_rim[v] == 0) continue;
            states[v].marks |= Mark::required;
            if (states[v].place != VertexPlace::inside) states[v].place = VertexPlace::corner;
            if (is_pinched(mesh, balls[v].size(), VertexId(v), *around, found)) states[v].marks |= Mark::frozen;
        }
    });
    if (!done) return fail(done.error());
    return states;
}

}  // namespace

template <int D>
Outcome<DynamicPart<D>> make_dynamic_part(const MeshPart<D>& part, const Execution& execution) {
    return guarded([&]() -> Outcome<DynamicPart<D>> {
        if (auto checked = check_rows(part); !checked) return fail(checked.error());
        const auto edges = unique_edges(part.mesh, execution);
        if (!edges) return fail(edges.error());
        const auto around = balls(part.mesh, execution);
        if (!around) return fail(around.error());
        auto result = with_faces(part.mesh, *edges, *around, execution);
        if (!result) return fail(result.error());
        Buffer<Marks> facet_marks(part.facet_marks.begin(), part.facet_marks.end());
        for (Marks& marks : facet_marks)
            if (marks.has(Mark::frozen)) marks |= Mark::required;
        result->facets.marks = std::move(facet_marks);
        auto on_rim = rim_of(*result);
        if constexpr (D == 3) {
            const auto facets = facet_shells(*edges, execution);
            if (!facets) return fail(facets.error());
            put_lines(part, *edges, *facets, on_rim, *result);
        }
        auto states = fixed_states(part, *result, *around, *edges, on_rim, execution);
        if (!states) return fail(states.error());
        result->states = std::move(*states);
        result->stamp = new_stamp();
        return DynamicPart<D>{std::move(*result), std::move(on_rim)};
    });
}

namespace {

template <class Id>
struct NewIds {
    Buffer<Id> of;
    std::size_t count = 0;
};
/// True if `compacted` keeps an entity: it exists and is not at infinity. No element of a standalone surface is kept.
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
    auto part_simplices = take(rows(from.vertices, ids));
    for (auto& simplex : part_simplices)
        for (VertexId& v : simplex) v = vertices[v.index()];
    return {std::move(part_simplices), rows(from.references, ids), marked(from.marks, ids.of, Mark::required),
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
DirectionsAtVertices<D> directions(const DirectionsAtVertices<D>& specified, const DynamicMesh<D>& mesh,
                                   const Buffer<VertexId>& vertices) {
    Buffer<DirectionRow> at;
    for (const DirectionRow& row : specified.at)
        if (const Marks marks = mesh.states[row.vertex].marks;
            marks.has(Mark::has_input_data) && !marks.has(Mark::moved))
            at.push_back({vertices[row.vertex.index()], row.row});
    return {specified.table, std::move(at)};
}

template <int G, int D>
Column<Association<G>> associations(const Column<Association<G>>& specified, const DynamicMesh<D>& mesh,
                                    const Buffer<VertexId>& vertices) {
    Buffer<Association<G>> out;
    for (Association<G> on : specified) {
        const Marks marks = mesh.states[on.item].marks;
        if (!marks.has(Mark::has_input_data)) continue;
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
    const InputGeometry<D>& specified = mesh.geometry;
    out.geometry = {directions(specified.normals, mesh, ids), directions(specified.tangents, mesh, ids),
                    associations(specified.on_points, mesh, ids), associations(specified.on_curves, mesh, ids),
                    associations(specified.on_surfaces, mesh, ids)};
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

#define CAMBER_INSTANTIATE(D)                                                                    \
    template Outcome<DynamicPart<D>> make_dynamic_part<D>(const MeshPart<D>&, const Execution&); \
    template Outcome<CompactMesh<D>> compacted<D>(const DynamicMesh<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
