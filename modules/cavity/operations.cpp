module;
#include <algorithm>
#include <cstddef>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

template <int D>
void cavity_of_edge(const DynamicMesh<D>& mesh, ElementId e, int k, Cavity<D>& out) {
    const EdgeId edge = mesh.edges_of[e][k];
    shell(mesh, e, k, out.elements);
    out.facets.clear();
    const auto is_inside = [&](VertexId v) { return mesh.states[v].place == VertexPlace::inside; };
    if (std::ranges::none_of(mesh.edges[edge], is_inside))  // what is inside has no facets
        facets_with(mesh, out.elements, edge, out.facets);
    out.lines.clear();
    if (const LineId line = mesh.line_at(edge); line.valid()) out.lines.push_back(line);
}

template <int D>
void cavity_of_vertex(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out) {
    ball(mesh, v, out.elements);
    facets_with(mesh, out.elements, v, out.facets);
    lines_with(mesh, out.elements, v, out.lines);
}

template <int D>
void cavity_of_face(const DynamicMesh<D>& mesh, ElementId e, int face, Cavity<D>& out) {
    out.clear();
    out.elements.push_back(e);
    if (const ElementId other = element_across(mesh, e, face); other.valid()) out.elements.push_back(other);
    if (const FacetId facet = facet_at(mesh, e, face); facet.valid()) out.facets.push_back(facet);
}

template <int D>
void join(const DynamicMesh<D>& mesh, Cavity<D>& cavity, ElementId e) {
    cavity.elements.push_back(e);
    if constexpr (D == 3)
        if (mesh.is_surface()) cavity.facets.push_back(facet_of(mesh, e));
}

template <int D>
bool may_collapse(const DynamicMesh<D>& mesh, const Cavity<D>& around, VertexId v, VertexId w) {
    const VertexState& state = mesh.states[v];
    if (state.marks.has(Mark::required) || state.marks.has(Mark::frozen)) return false;
    switch (state.place) {
        case VertexPlace::inside: return true;
        case VertexPlace::surface:
            return std::ranges::any_of(around.facets,
                                       [&](FacetId f) { return local_vertex(mesh.facets.vertices[f], w) >= 0; });
        case VertexPlace::line:
            return std::ranges::any_of(around.lines, [&](LineId l) {
                const auto& ends = mesh.edges[mesh.lines[l]];
                return ends[0] == w || ends[1] == w;
            });
        case VertexPlace::corner:
        case VertexPlace::infinity: return false;
    }
    return false;
}

#define CAMBER_INSTANTIATE(D)                                                           \
    template void cavity_of_edge<D>(const DynamicMesh<D>&, ElementId, int, Cavity<D>&); \
    template void cavity_of_vertex<D>(const DynamicMesh<D>&, VertexId, Cavity<D>&);     \
    template void cavity_of_face<D>(const DynamicMesh<D>&, ElementId, int, Cavity<D>&); \
    template void join<D>(const DynamicMesh<D>&, Cavity<D>&, ElementId);                \
    template bool may_collapse<D>(const DynamicMesh<D>&, const Cavity<D>&, VertexId, VertexId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
