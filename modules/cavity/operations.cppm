module;
#include <cstddef>
export module camber.cavity:operations;
import camber.core;
import :emptied;
import :mesh;

/// Operations as cavities (paper §1.3): what is taken out for each, with the facets and lines that go with it. Joined
/// to a new point on the edge it is a split, to a vertex of its boundary a swap, to a neighbour a collapse, to the
/// vertex itself a reinsertion, elsewhere a move.
export namespace camber {

/// The elements around local edge k of an element, the facets on it and its line: of a split, or, where no line is, of
/// a swap.
template <int D>
void cavity_of_edge(const DynamicMesh<D>& mesh, ElementId e, int k, Cavity<D>& out);

/// Everything around a vertex: of a reinsertion, a move, or a collapse.
template <int D>
void cavity_of_vertex(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out);

/// The elements on both sides of a face, and the facet on it: of an insertion there, or, where no facet is, of a swap.
template <int D>
void cavity_of_face(const DynamicMesh<D>& mesh, ElementId e, int face, Cavity<D>& out);

/// An element joins a cavity, of a surface alone with its triangle.
template <int D>
void join(const DynamicMesh<D>& mesh, Cavity<D>& cavity, ElementId e);

/// Whether v may go into w, the other end of one of its edges, by where they lie: from the inside anywhere, from a
/// surface along it, from a line along it, from a corner nowhere. `around`: cavity_of_vertex of v.
template <int D>
[[nodiscard]] bool may_collapse(const DynamicMesh<D>& mesh, const Cavity<D>& around, VertexId v, VertexId w);

}  // namespace camber
