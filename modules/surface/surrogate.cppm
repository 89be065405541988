module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>
export module camber.surface:surrogate;
import camber.core;
import camber.box_tree;
import camber.bezier;
import :features;
import :geometry;

export namespace camber {

/// A P3 K-simplex in D dimensions, K = 1 or 2, by its Bézier points in the order of multi_indices<3, K>:
/// 30 21 12 03, and 300 210 201 120 111 102 030 021 012 003.
template <int K, int D>
struct CubicSimplex {
    std::array<Vec<D>, node_count<3, K>> control{};

    [[nodiscard]] constexpr const Vec<D>& at(const MultiIndex<K>& alpha) const {
        return control[position<3, K>(alpha)];
    }
    [[nodiscard]] constexpr Vec<D>& at(const MultiIndex<K>& alpha) { return control[position<3, K>(alpha)]; }
    friend bool operator==(const CubicSimplex&, const CubicSimplex&) = default;
};

/// A cubic simplex at one place: the point, and its derivatives by ξ_a with ξ_0 = 1 − Σ ξ_a: first[a−1] = F_a and
/// second[a−1][b−1] = F_ab.
template <int K, int D>
struct CubicExpansion {
    Vec<D> point;
    std::array<Vec<D>, K> first{};
    std::array<std::array<Vec<D>, K>, K> second{};
};

/// De Casteljau: after r steps the net b^r holds the derivatives, ∂_i∂_j F = 6 b^1_{e_i+e_j}, ∂_i F = 3 b^2_{e_i}.
template <int K, int D>
[[nodiscard]] CubicExpansion<K, D> expand(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi);

/// F(ξ) = Σ B_α(ξ) P_α, of degree 3.
template <int K, int D>
[[nodiscard]] Vec<D> point_at(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi);

/// A place on a cubic simplex.
template <int K, int D>
struct CubicFoot {
    Barycentric<K> xi{};
    Vec<D> point;
    double distance_squared = 0;
};

/// A local minimum of the distance from p over the simplex: Newton's method with the constraints kept, from `start`.
/// Never farther from p than the start is.
template <int K, int D>
[[nodiscard]] CubicFoot<K, D> closest_from(const CubicSimplex<K, D>& simplex, const Vec<D>& p,
                                           const Barycentric<K>& start);

/// The nearest place: where the squared distance is convex over the simplex, as from near a simplex that bends little,
/// the one minimum; else the best of those from the three nearest points of the lattice of quarters.
template <int K, int D>
[[nodiscard]] CubicFoot<K, D> closest_on(const CubicSimplex<K, D>& simplex, const Vec<D>& p);

/// The cubic from a to b with the given tangents (any length, both along a → b) whose handles are those of a circle:
/// |e| (2/3)/(1 + cos φ), φ the angle of chord and tangent. Error O(h⁴) in the middle, O(h⁶) on circles. A tangent that
/// leaves the chord by more than 75° is replaced by the chord.
template <int D>
[[nodiscard]] CubicSimplex<1, D> cubic_edge(const Vec<D>& a, const Vec<D>& tangent_a, const Vec<D>& tangent_b,
                                            const Vec<D>& b);

/// The classical middle point of a cubic triangle with its nine rim points set, exact on quadratics:
/// b_111 = ¼ Σ edge points − ⅙ Σ vertices.
template <int D>
[[nodiscard]] Vec<D> classical_centre(const CubicSimplex<2, D>& triangle);

/// Distances of many points from one cubic triangle, in packs (core:tensors): by Newton's method from each start, as
/// `closest_from` finds them, for those whose foot is inside the triangle. Not a number for the others: on the rim, or
/// where the plain method does not settle. The same bytes with any instructions.
void distances_inside(const CubicSimplex<2, 3>& simplex, std::span<const Barycentric<2>> starts,
                      std::span<const Vec<3>> points, std::span<double> distances,
                      Instructions set = widest_instructions());

}  // namespace camber

namespace camber {

/// Directions that the mesh's maker gave, by vertex; rows that the table does not have are left out.
template <int D>
class GivenAtVertices {
  public:
    explicit GivenAtVertices(const DirectionsAtVertices<D>& given) : table_(given.table) {
        for (const DirectionRow& at : given.at)
            if (at.row < table_.size()) sorted_.push_back(at);
        std::sort(sorted_.begin(), sorted_.end(), [](const DirectionRow& a, const DirectionRow& b) {
            return std::pair(a.vertex, a.row) < std::pair(b.vertex, b.row);
        });
    }

    /// The vertex's rows, in their order.
    [[nodiscard]] std::span<const DirectionRow> of(VertexId v) const {
        const auto begin = std::lower_bound(sorted_.begin(), sorted_.end(), v,
                                            [](const DirectionRow& at, VertexId w) { return at.vertex < w; });
        auto end = begin;
        while (end != sorted_.end() && end->vertex == v) ++end;
        return {begin, end};
    }
    [[nodiscard]] Vec<D> unit(const DirectionRow& at) const { return normalised(table_[at.row]); }

  private:
    Column<Vec<D>> table_;
    std::vector<DirectionRow> sorted_;  ///< by rising vertex, then row
};

/// Where facets whose surface another geometry prescribes (a CAD model, analytic surfaces) end and the surrogate
/// begins: what that geometry tells of the vertices that both share. Whether the boundary is smooth there, the mesh
/// decides: it is if the prescribed direction is near that which is fitted to the mesh, by `junction_share` of the
/// turns around (Beyond, and curve_tangents along curves). So a crease stays one, but for less than about a quarter of
/// these.
template <int D>
struct Junctions {
    Column<std::uint8_t> prescribed;  ///< one a facet; none at all where nothing is prescribed
    Column<FacetId> facets;           ///< rising: the prescribed ones with a vertex that others have too
    /// The surface's unit normals at their vertices. Zero where no others are, or where the file says that the boundary
    /// breaks: at ends of its ridges between both (2D: at its corners).
    Column<std::array<Vec<D>, D>> normals;

    [[nodiscard]] bool is_prescribed(FacetId f) const { return !prescribed.empty() && prescribed[f] != 0; }
    /// The normal of a facet's surface at a vertex of it, or the zero vector.
    [[nodiscard]] Vec<D> normal(const LinearMesh<D>& mesh, FacetId f, VertexId v) const;
};

inline constexpr double junction_share = 0.25;

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Junctions<D>> find_junctions(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const Incidence<FacetId>& shells, const GeometryModel<D>& prescribed,
                                                   const Execution& execution);

/// What is prescribed beyond the edges of a fan at its vertex.
struct Beyond {
    FacetId facet;         ///< whose surface it is; invalid: there is none
    Vec<3> normal;         ///< of that surface at the vertex; of several surfaces the nearest to what was fitted
    double tolerance = 0;  ///< by how much (radians) what is fitted may be off it where the boundary is smooth
};
[[nodiscard]] Beyond beyond_fan(const Junctions<3>& junctions, const MeshBoundary<3>& boundary, const Fans& fans,
                                std::uint32_t fan, const Vec<3>& fitted);

/// The unit tangents of curve edges at both their ends, along the edge from its lower vertex to its higher.
template <int D>
struct CurveTangents {
    Column<EdgeId> edges;  ///< rising: ridges in 3D, all facets in 2D
    Column<std::array<Vec<D>, 2>> tangents;
    Column<std::array<std::uint8_t, 2>> supports;  ///< neighbours that each tangent was fitted to; 4 for given ones

    /// The row of an edge, or size() when it is not on a curve.
    [[nodiscard]] std::size_t row(EdgeId e) const;
};

/// At each vertex of a curve the polynomial through up to four neighbours along it, as heights over the tangent (found
/// again until it stays), two a side where the curve goes on, one-sided at corners: error O(h⁴). Both edges at a vertex
/// that is no corner get the same line. Tangents of the file's notes take precedence where they agree within
/// `max_degrees`; at junctions those of the prescribed curve that the curve goes on in (see Junctions).
template <int D>
[[nodiscard]] Outcome<CurveTangents<D>> curve_tangents(const MeshBoundary<D>& boundary, const Junctions<D>& junctions,
                                                       double max_degrees, const Execution& execution);

/// The unit normal of the surface through `origin` and the points around it; degree 0: the points do not tell.
struct FittedNormal {
    Vec<3> normal;
    int degree = 0;
};

/// A jet: the height over the plane of `normal` as a polynomial that vanishes at `origin`, by least squares, weighted
/// towards the near points. Quartic from 18 points on, else cubic from 12, else quadratic from 5, each only where the
/// points determine it (column-pivoted QR of scaled columns; axes and scales are the points' own principal ones, so
/// that thin stencils work as well as round ones). Fitted twice, the second time over the tangent plane found. Error of
/// the normal O(h^degree).
[[nodiscard]] FittedNormal fitted_normal(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points);

/// A point of a surface with its unit normal.
struct PointAndNormal {
    Vec<3> point, normal;
};

/// How far along `normal` a surface is from a point; degree 0: the samples do not tell, or turn away from the plane.
struct FittedHeight {
    double height = 0;
    int degree = 0;
};

/// Least squares on heights and slopes of the samples, of degree 4, else 3: error O(h⁵) but for that of the normals.
[[nodiscard]] FittedHeight fitted_height(const Vec<3>& origin, const Vec<3>& normal,
                                         std::span<const PointAndNormal> samples);

/// An edge that the mesh lists inside a smooth face, or that parts two entities there.
struct EmbeddedEdge {
    EdgeId edge;
    Reference reference = 0;
};
/// Returns the embedded edges, each once: first those that the mesh lists, then those between entities.
[[nodiscard]] std::vector<EmbeddedEdge> embedded_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                       const Features<3>& features, const Incidence<FacetId>& shells);

/// The boundary that a surrogate goes through, with what was found of it.
template <int D>
struct SurrogateInput {
    MeshBoundary<D> boundary;
    const Column<FlatPatch<D>>& flats;  ///< one a patch
    const CurveTangents<D>& tangents;
    const Junctions<D>& junctions;
};

struct FanNormals {
    Column<Vec<3>> normals;           ///< one a fan: unit, or zero
    Column<std::uint8_t> prescribed;  ///< one a fan: whether its normal is that of the surface beyond a junction
};

/// The unit normal of each fan, turned to the patch's side; the zero vector of a pointed one. A flat patch gives its
/// plane's, a locally flat fan its own plane's; else that of the jet through the rings around (error O(h⁴), O(h³),
/// O(h²) by its degree), else the area-weighted one. The file's normals take precedence where they agree with the
/// area-weighted one within `max_degrees`. At a ridge the normal is made perpendicular to the ridge's tangents, which
/// are known better. At a junction that the boundary passes smoothly it is the prescribed surface's. Errors: stopped.
[[nodiscard]] Outcome<FanNormals> fan_normals(const SurrogateInput<3>& input, const Fans& fans, double max_degrees,
                                              const Execution& execution);

}  // namespace camber

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
/// handles of a circle; both facets of an edge share them. Beside a ridge that bends within the surface, edges are bent
/// in the same way (extend_over_triangles), so that thin facets there do not fold. The middle point of a triangle is
/// fitted to the vertices and normals of the facets around it, so that the centroid errs no more than the edges do,
/// O(h⁴). Errors: `edges` or `features` is not of this mesh (ErrorKind::internal), stopped.
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

export namespace camber {

/// What became of the patches of a mesh that has curves.
struct CurvedPatches {
    std::size_t smooth = 0;    ///< patches with curves of their own, that one surface goes through
    std::size_t as_read = 0;   ///< those whose curved facets stay as they are, with their kinks
    double largest_angle = 0;  ///< by which the smooth ones turn between their pieces, in radians
    double mean_angle = 0;     ///< the root mean square of these turns
};

template <int D>
struct CurvedSurrogate {
    Surrogate<D> surrogate;
    CurvedPatches patches;
};

/// The boundary of a curved mesh.
template <int D>
struct BoundaryCurves {
    const LinearMesh<D>& linear;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    std::span<const LagrangeNode<D>> nodes;  ///< one an edge
};

/// The boundary of a curved mesh as a smooth surface through its vertices and nodes. `straight` is the surrogate of its
/// straight facets: patches keep it where all of their edges' nodes lie on it (to 1e-6 of the chord), or all in the
/// middles of chords: they have no curves of their own. If there are others, the surrogate is that of the facets cut at
/// their nodes, so normals and tangents are fitted to vertices and nodes; pieces of patches without curves go through
/// the nodes that `straight` has. Curves that are no smooth surface's, since facets of degree 2 turn between each other
/// by more than a quarter of what straight ones do (root mean squares over the patch), and patches of one facet stay as
/// they are: these pieces are the mesh's own facets, exactly. Ridges, patches and their neighbours are those of the
/// straight mesh. Patches of planes are flat where the nodes are in them too. `prescribed`: as build_surrogate has it.
/// Errors: `straight` is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<CurvedSurrogate<D>> with_curves(Surrogate<D> straight, const BoundaryCurves<D>& mesh,
                                                      const GeometryModel<D>& prescribed,
                                                      const SurrogateOptions& options, const Execution& execution);

/// The boundary is what the straight facets are: nothing is curved, and there is no surface to project onto.
template <int D>
class StraightGeometry final : public GeometryModel<D> {
  public:
    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override;
    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override;
};

/// The surrogate as a geometry: surfaces are its patches, curves its ridge curves. Edges and facets of the mesh that it
/// was made from are known by their number and place; those of others are projected.
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(Surrogate<D> surrogate);

/// A surrogate that was made from another mesh: it prescribes the surface of the references that it has, and each of
/// its ridges that of edges whose ends are near it.
template <int D>
struct PrescribedSurrogate {
    Surrogate<D> surrogate;
};
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(PrescribedSurrogate<D> prescribed);

/// Analytic surfaces as a geometry; references without one have no surface.
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D> analytic);

/// Two geometries mixed by reference: facets of `references` lie on `first`, which has surfaces for them, all others on
/// `rest`, which may be a mixture too. Where a surface of `first` meets one that `rest` prescribes, edges lie on the
/// curve of both; where these touch rather than cross, on the rim of one of them, if that has one there and tells its
/// number (a CAD model's face ends at an edge). Where it meets what is not prescribed, on its own rim, if it has one;
/// else, beside a plane, on the curve of both, and beside another, which is known by its nodes alone, on `first`, next
/// to where `rest` has the edge.
template <int D>
struct MixedGeometry {
    std::vector<Reference> references;
    Geometry<D> first, rest;
};
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(MixedGeometry<D> mixed);

/// Makes the surrogate of what a geometry leaves of a mesh's boundary.
template <int D>
using MakesSurrogate = std::function<Outcome<Surrogate<D>>(const GeometryModel<D>& prescribed)>;

/// The analytic surfaces alone where every facet has one, else with the surrogate for the rest, which is made only
/// then. Errors: of its making.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D> analytic, const LinearMesh<D>& mesh,
                                                  const MakesSurrogate<D>& surrogate);

}  // namespace camber
