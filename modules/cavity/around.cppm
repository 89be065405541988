module;
#include <cstddef>
#include <vector>
export module camber.cavity:around;
import camber.core;
import :mesh;

/// What is around an entity, by walking from element to element: at the cost of what is found.
export namespace camber {

/// The element across a face, beyond a facet too; invalid on the boundary.
template <int D>
[[nodiscard]] inline ElementId element_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    if (!across.valid()) return {};
    if (across.is_element()) return across.element();
    const FacetSides& sides = mesh.sides[across.facet()];
    return sides[0] == e ? sides[1] : sides[0];
}

/// The facet on a face of an element, if there is one.
template <int D>
[[nodiscard]] inline FacetId facet_at(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    return across.is_facet() ? across.facet() : FacetId{};
}

/// Of a surface alone: the facet that an element stands for.
[[nodiscard]] inline FacetId facet_of(const DynamicMesh<3>& mesh, ElementId e) { return facet_at(mesh, e, 3); }

/// The elements around a vertex that faces connect, into `found`; in the order of the walk, which begins at element_of.
template <int D>
void ball(const DynamicMesh<D>& mesh, VertexId v, std::vector<ElementId>& found);

/// The elements around an edge of element e that faces connect, into `found`: from e one way round, then, where that
/// ends at the boundary, the other way.
template <int D>
void shell(const DynamicMesh<D>& mesh, ElementId e, int local_edge, std::vector<ElementId>& found);

/// The facets with this vertex, or edge, among those on faces of these elements, into `found`, rising.
template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                 std::vector<FacetId>& found);
template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, EdgeId edge,
                 std::vector<FacetId>& found);
/// The lines with this vertex among the edges of these elements, into `found`, rising.
template <int D>
void lines_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                std::vector<LineId>& found);

/// Whether the node of an element's edge stays, by what this element tells: that of the boundary, of an interface, of a
/// line, of a required element, and where facets without elements may have it.
template <int D>
[[nodiscard]] inline bool is_node_fixed(const DynamicMesh<D>& mesh, ElementId e, int local_edge) {
    const EdgeId edge = mesh.edges_of[e][local_edge];
    const auto& [a, b] = mesh.edges[edge];
    if (mesh.elements.marks[e].has(Mark::required) || mesh.line_at(edge).valid()) return true;
    if (mesh.states[a].marks.has(Mark::frozen) && mesh.states[b].marks.has(Mark::frozen)) return true;
    for (int face = 0; face <= D; ++face) {
        if (face == local_edges<D>[local_edge][0] || face == local_edges<D>[local_edge][1]) continue;
        const FaceNeighbour across = mesh.face_neighbours[e][face];
        if (!across.valid() || across.is_facet()) return true;
    }
    return false;
}

/// The edge of a facet opposite its local vertex k (3D), by the element on its first side.
[[nodiscard]] EdgeId facet_edge(const DynamicMesh<3>& mesh, FacetId f, int k);

}  // namespace camber
