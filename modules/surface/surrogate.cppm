module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
export module camber.surface:surrogate;
import camber.core;
import camber.box_tree;
import camber.bezier;
import :features;
import :cubic;
import :flat;
import :geometry;

export namespace camber {

/// What the surrogate takes from the file beside the mesh itself.
struct SurrogateOptions {
    /// Normals and tangents that come with the mesh (`LinearMesh::geometry`) are taken where they agree with the
    /// mesh's own within this angle (degrees); 0 ignores them.
    double file_directions_degrees = 30;
};

/// A boundary edge of the surrogate.
template <int D>
struct SurrogateEdge {
    CubicSimplex<1, D> curve;  ///< from the lower vertex to the higher
    Vec<D> middle;             ///< the curve at t = 1/2; the chord's middle to the last bit where the edge is straight
    std::uint32_t curve_number = no_feature;  ///< of the ridge curve (3D) or the smooth curve (2D)
    friend bool operator==(const SurrogateEdge&, const SurrogateEdge&) = default;
};

/// A smooth (G1 at vertices) piecewise cubic surface through a mesh's boundary, made from the mesh alone (paper §3.1):
/// a value of its own that outlives changes of the mesh. Triangles in 3D, curves in 2D. Facets and edges of patches
/// that are parts of planes stay in those planes.
template <int D>
struct Surrogate {
    static constexpr int K = D - 1;

    Column<CubicSimplex<K, D>> facets;
    Column<Reference> references;               ///< one a facet
    Column<std::uint32_t> patches;              ///< one a facet
    Column<FlatPatch<D>> flats;                 ///< one a patch
    Column<SimplexVertices<K>> vertices;        ///< one a facet
    Column<std::array<FacetId, D>> neighbours;  ///< across the smooth edge (2D: vertex) opposite each corner, if any
    Column<EdgeId> edges;                       ///< rising: the mesh's edges that are on its boundary
    Column<SurrogateEdge<D>> edge_curves;       ///< one a row of `edges`
    BoxTree<D> tree;                            ///< over the facets' control points
    BoxTree<D> curve_tree;                      ///< over the control points of `ridge_rows` (3D)
    Column<std::uint32_t> ridge_rows;           ///< rows of `edges` that are ridges

    /// The row of an edge in `edges`, or edges.size().
    [[nodiscard]] std::size_t row(EdgeId e) const;
};

/// Edge control points lie in the tangent planes of the vertices (ridges: on the tangents of their curves), with the
/// handles of a circle; both facets of an edge share them. The middle point of a triangle is fitted to the vertices and
/// normals of the facets around it, so that the centroid errs no more than the edges do, O(h⁴). Errors: `edges` or
/// `features` is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                    const Features<D>& features, const SurrogateOptions& options,
                                                    const Execution& execution);
/// For what `prescribed` leaves of the boundary: at vertices that facets of its references share with others the
/// surrogate takes its normals and tangents, where both sides go on smoothly.
template <int D>
[[nodiscard]] Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                    const Features<D>& features, const GeometryModel<D>& prescribed,
                                                    const SurrogateOptions& options, const Execution& execution);

/// A place on the surrogate.
template <int D>
struct SurrogateFoot {
    FacetId facet;
    Barycentric<D - 1> xi{};
    Vec<D> point;
    double distance_squared = 0;
};

/// From a facet: the closest point on it, then across smooth edges for as long as the distance falls; where it stops,
/// the facets next to it are searched too, since the surface has slight creases at its edges. Local: never farther than
/// the facet is.
template <int D>
[[nodiscard]] SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Vec<D>& p);
/// From a place on the facet, without that last search: for points very near the surface, in great numbers.
template <int D>
[[nodiscard]] SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Barycentric<D - 1>& xi,
                                            const Vec<D>& p);

/// The closest point of all facets for which `admits(facet)`; an invalid facet when there is none. `known`: one that is
/// near, on a facet that is admitted, if there is one: it is the closest of its facet, and what is farther is not
/// looked at.
template <int D, class Admits>
[[nodiscard]] SurrogateFoot<D> closest_among(const Surrogate<D>& surrogate, const Vec<D>& p, Admits&& admits,
                                             const SurrogateFoot<D>& known = {}) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    double least = known.facet.valid() ? known.distance_squared : infinite;
    SurrogateFoot<D> best;  // of those that are looked at
    const auto distance_squared = [&](std::size_t f) {
        if (FacetId(f) == known.facet || !admits(FacetId(f))) return infinite;
        Box<D> box;  // of its control points: the facet lies within
        for (const Vec<D>& c : surrogate.facets[f].control) box.include(c);
        if (box.distance_squared(p) > least) return infinite;
        const auto foot = closest_on(surrogate.facets[f], p);
        const bool is_nearer = foot.distance_squared < best.distance_squared;
        const bool is_tie = foot.distance_squared == best.distance_squared && FacetId(f) < best.facet;
        if (!best.facet.valid() || is_nearer || is_tie) best = {FacetId(f), foot.xi, foot.point, foot.distance_squared};
        least = std::fmin(least, foot.distance_squared);
        return foot.distance_squared;
    };
    const auto nearest = surrogate.tree.nearest(p, distance_squared, least);
    return best.facet.valid() && FacetId(nearest.item) == best.facet ? best : known;
}

/// The closest point of all ridge curves (3D), and the row of its edge; `row` is edges.size() when there are none.
template <int D>
struct CurveFoot {
    std::size_t row = 0;
    double t = 0;
    Vec<D> point;
    double distance_squared = 0;
};
/// The nearest point of all ridge curves; where there are none, `row` is that past the last edge.
template <int D>
[[nodiscard]] CurveFoot<D> closest_on_ridges(const Surrogate<D>& surrogate, const Vec<D>& p);

/// The unit normal at a place: to the right of a 2D facet's direction, by the right hand on a triangle's vertices.
template <int D>
[[nodiscard]] Vec<D> normal_at(const CubicSimplex<D - 1, D>& facet, const Barycentric<D - 1>& xi);

}  // namespace camber

namespace camber {

/// The trees, from the facets, the curves and the rows of ridges. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> plant_trees(Surrogate<D>& surrogate, const Execution& execution);

}  // namespace camber
