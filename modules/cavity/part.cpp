module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;
import :with_faces;

namespace camber {

namespace {

template <int D>
Outcome<Done> check_rows(const MeshPart<D>& part) {
    if (part.states.size() == part.mesh.points.size() && part.facet_marks.size() == part.mesh.facets.size() &&
        part.line_marks.size() == part.mesh.edges.size())
        return Done{};
    return fail(ErrorKind::internal, "a part of a mesh has rows that do not fit");
}

/// The vertices of faces that have nothing beyond, and of facets that have something elsewhere.
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

/// The lines that are given, and those where a surface goes on beyond the rim.
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
Outcome<Buffer<VertexState>> held_states(const MeshPart<D>& part, const DynamicMesh<D>& mesh,
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
        auto made = with_faces(part.mesh, *edges, *around, execution);
        if (!made) return fail(made.error());
        Buffer<Marks> facet_marks(part.facet_marks.begin(), part.facet_marks.end());
        for (Marks& marks : facet_marks)
            if (marks.has(Mark::frozen)) marks |= Mark::required;
        made->facets.marks = std::move(facet_marks);
        auto on_rim = rim_of(*made);
        if constexpr (D == 3) {
            const auto facets = facet_shells(*edges, execution);
            if (!facets) return fail(facets.error());
            put_lines(part, *edges, *facets, on_rim, *made);
        }
        auto states = held_states(part, *made, *around, *edges, on_rim, execution);
        if (!states) return fail(states.error());
        made->states = std::move(*states);
        made->stamp = new_stamp();
        return DynamicPart<D>{std::move(*made), std::move(on_rim)};
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<DynamicPart<D>> make_dynamic_part<D>(const MeshPart<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
