module;
#include <cstddef>
export module camber.cavity:insertion;
import camber.core;
import :emptied;
import :locate;
import :mesh;

export namespace camber {

/// A point as it is to be put into a mesh: joined to it, the cavity is what holds it already, with the facets and the
/// line that it lies on.
template <int D>
struct Insertion {
    Cavity<D> cavity;
    PointSite<D> site;
    VertexPlace place = VertexPlace::inside;  ///< what the point becomes
    VertexId vertex;  ///< the vertex that it lies at, if it does: then there is nothing to put in, and the cavity is
                      ///< that of the vertex

    [[nodiscard]] bool is_at_vertex() const { return vertex.valid(); }
};

/// The cavity of a point: an element; both sides of a face, with the facet on it; the shell of an edge, with its facets
/// and line. Faces may be added to it (a Delaunay cavity); whether the star is free of inverted elements is for the
/// caller to judge, as it is of a point that is near to what it is counted as on (see `locate`, whose errors these
/// are).
template <int D>
[[nodiscard]] Outcome<Insertion<D>> insertion(const DynamicMesh<D>& mesh, const Vec<D>& point, ElementId hint = {},
                                              double near = near_share);

/// The same for a point whose site is known.
template <int D>
[[nodiscard]] Insertion<D> insertion_at(const DynamicMesh<D>& mesh, const PointSite<D>& site);

}  // namespace camber
