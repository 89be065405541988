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

/// A P3 K-simplex (K = 1, 2) by its Bézier points in the order of multi_indices<3, K>: 30 21 12 03, or 300 210 201 120
/// 111 102 030 021 012 003.
template <int K, int D>
struct CubicSimplex {
    std::array<Vec<D>, node_count<3, K>> control{};

    [[nodiscard]] constexpr const Vec<D>& at(const MultiIndex<K>& alpha) const {
        return control[position<3, K>(alpha)];
    }
    [[nodiscard]] constexpr Vec<D>& at(const MultiIndex<K>& alpha) { return control[position<3, K>(alpha)]; }
    friend bool operator==(const CubicSimplex&, const CubicSimplex&) = default;
};

/// Point F and its derivatives by ξ_a, with ξ_0 = 1 − Σ ξ_a: first[a−1] = F_a, second[a−1][b−1] = F_ab.
template <int K, int D>
struct CubicExpansion {
    Vec<D> point;
    std::array<Vec<D>, K> first{};
    std::array<std::array<Vec<D>, K>, K> second{};
};

/// Evaluates by de Casteljau's algorithm. Step r gives the control points b^r. The derivatives are ∂_i ∂_j F = 6
/// b^1_{e_i+e_j} and ∂_i F = 3 b^2_{e_i}, with the unit multi-index e_i of ξ_i.
template <int K, int D>
[[nodiscard]] CubicExpansion<K, D> expand(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi);

template <int K, int D>
[[nodiscard]] Vec<D> point_at(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi);

template <int K, int D>
struct CubicFoot {
    Barycentric<K> xi{};
    Vec<D> point;
    double distance_squared = 0;
};

/// Returns a local minimum of the distance of p, by Newton's method with constraints. It is never farther from p than
/// `start`.
template <int K, int D>
[[nodiscard]] CubicFoot<K, D> closest_from(const CubicSimplex<K, D>& simplex, const Vec<D>& p,
                                           const Barycentric<K>& start);

/// Returns the closest point to p. If p is near a slightly bent simplex, the squared distance is convex over it and has
/// one minimum. Otherwise the result is the best of three searches, which start from the nearest points of a lattice
/// with spacing 1/4.
template <int K, int D>
[[nodiscard]] CubicFoot<K, D> closest_on(const CubicSimplex<K, D>& simplex, const Vec<D>& p);

/// Returns the cubic from a to b with these tangents, of any length, both in the direction from a to b. The inner
/// control points are as far from the ends as on a circle: |b − a| (2/3)/(1 + cos φ), with the angle φ between chord
/// and tangent. The error is O(h⁴) in the middle, O(h⁶) on circles. The chord replaces a tangent that deviates from it
/// by more than 75°.
template <int D>
[[nodiscard]] CubicSimplex<1, D> cubic_edge(const Vec<D>& a, const Vec<D>& tangent_a, const Vec<D>& tangent_b,
                                            const Vec<D>& b);

/// Middle control point computed from the nine others, exact for quadratics: b_111 = ¼ Σ edge points − ⅙ Σ vertices.
template <int D>
[[nodiscard]] Vec<D> classical_centre(const CubicSimplex<2, D>& triangle);

/// Distances of many points from one triangle, in packs (core:tensors), by Newton's method from each start. A distance
/// is NaN where the closest point is not inside or the method does not converge. Other distances are those of
/// `closest_from`. Bitwise identical for all instruction sets.
void distances_inside(const CubicSimplex<2, 3>& simplex, std::span<const Barycentric<2>> starts,
                      std::span<const Vec<3>> points, std::span<double> distances,
                      Instructions set = widest_instructions());

}  // namespace camber

namespace camber {

template <int D>
class FileDirections {
  public:
    explicit FileDirections(const DirectionsAtVertices<D>& specified) : table_(specified.table) {
        for (const DirectionRow& at : specified.at)
            if (at.row < table_.size()) sorted_.push_back(at);
        std::sort(sorted_.begin(), sorted_.end(), [](const DirectionRow& a, const DirectionRow& b) {
            return std::pair(a.vertex, a.row) < std::pair(b.vertex, b.row);
        });
    }

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
    std::vector<DirectionRow> sorted_;  ///< sorted by vertex, then row
};

/// Junctions of the surrogate with facets whose surface is prescribed (CAD, analytic): data of that surface at shared
/// vertices. The boundary is smooth there if the prescribed direction differs from the fitted one by at most
/// `junction_share` of the turns of facets around the vertex (see `PrescribedNeighbour` and `curve_tangents`). Creases
/// above about a quarter of these turns are preserved.
template <int D>
struct Junctions {
    Column<std::uint8_t> prescribed;  ///< one per facet; empty: no facet is prescribed
    Column<FacetId> facets;           ///< prescribed facets with a shared vertex, ascending
    /// Unit normals of the prescribed surface at the vertices of `facets`. They are zero at vertices that are not
    /// shared. They are also zero at breaks that the file lists between both parts: at the ends of ridges (2D: at
    /// corners).
    Column<std::array<Vec<D>, D>> normals;

    [[nodiscard]] bool is_prescribed(FacetId f) const { return !prescribed.empty() && prescribed[f] != 0; }
    [[nodiscard]] Vec<D> normal(const LinearMesh<D>& mesh, FacetId f, VertexId v) const;
};

inline constexpr double junction_share = 0.25;

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Junctions<D>> find_junctions(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const Incidence<FacetId>& shells, const GeometryModel<D>& prescribed,
                                                   const Execution& execution);

struct PrescribedNeighbour {
    FacetId facet;         ///< prescribed facet at the vertex; invalid if there is none
    Vec<3> normal;         ///< normal at the vertex; if there are several, the closest to the fitted normal
    double tolerance = 0;  ///< largest deviation (radians) of a smooth continuation
};
[[nodiscard]] PrescribedNeighbour prescribed_neighbour(const Junctions<3>& junctions, const MeshBoundary<3>& boundary,
                                                       const Fans& fans, std::uint32_t fan, const Vec<3>& fitted);

template <int D>
struct CurveTangents {
    Column<EdgeId> edges;  ///< edges of curves, ascending: ridges in 3D, facets in 2D
    Column<std::array<Vec<D>, 2>> tangents;
    Column<std::array<std::uint8_t, 2>> supports;  ///< number of neighbours in each fit; 4 for a tangent that is not
                                                   ///< fitted

    /// Row of e; edges.size() if the edge is not on a curve.
    [[nodiscard]] std::size_t row(EdgeId e) const;
};

/// Computes tangents at both ends of each curve edge. A polynomial is fitted at each curve vertex to the heights of up
/// to four neighbours over the tangent (iterated): two per side, one-sided at corners. The error is O(h⁴). Both edges
/// at a vertex that is no corner get the same tangent line. Tangents from the file take precedence if they agree within
/// `max_degrees`. Smooth junctions get the tangents of the prescribed curve.
template <int D>
[[nodiscard]] Outcome<CurveTangents<D>> curve_tangents(const MeshBoundary<D>& boundary, const Junctions<D>& junctions,
                                                       double max_degrees, const Execution& execution);

/// Fitted unit normal of a surface; degree 0: not determined.
struct FittedNormal {
    Vec<3> normal;
    int degree = 0;
};

/// Fits a jet: a polynomial for the height over the plane of `normal`, which is 0 at `origin`. Near points have larger
/// weights in the least-squares fit. The polynomial is quartic for at least 18 points, cubic for 12, quadratic for 5,
/// if the points determine it. For thin stencils, the axes are principal axes, and scaled columns are pivoted (QR). The
/// jet is then fitted again over its tangent plane. The error is O(h^degree).
[[nodiscard]] FittedNormal fitted_normal(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points);

struct PointAndNormal {
    Vec<3> point, normal;
};

/// Height of a fitted surface along `normal`. Degree 0: the height is undetermined, or a sample's normal is far from
/// `normal`.
struct FittedHeight {
    double height = 0;
    int degree = 0;
};

/// Fits a polynomial of degree 4, else 3, to heights and slopes by least squares. The error is O(h⁵), plus the error of
/// the normals.
[[nodiscard]] FittedHeight fitted_height(const Vec<3>& origin, const Vec<3>& normal,
                                         std::span<const PointAndNormal> samples);

/// An edge in a smooth face: listed by the mesh, or between two entities of the mesher's model.
struct EmbeddedEdge {
    EdgeId edge;
    Reference reference = 0;
};
/// Distinct embedded edges, listed ones first.
[[nodiscard]] std::vector<EmbeddedEdge> embedded_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                       const Features<3>& features, const Incidence<FacetId>& shells);

template <int D>
struct SurrogateInput {
    MeshBoundary<D> boundary;
    const Column<FlatPatch<D>>& flats;
    const CurveTangents<D>& tangents;
    const Junctions<D>& junctions;
};

struct FanNormals {
    Column<Vec<3>> normals;           ///< one per fan: unit normal, or zero
    Column<std::uint8_t> prescribed;  ///< one per fan; 1: the normal is that of a prescribed surface
};

/// Unit normals of fans, oriented like the patch; zero for pointed fans. Each normal is the first that exists of:
/// - Normal of a flat patch.
/// - Normal of the file that agrees with the area-weighted normal within `max_degrees`.
/// - Normal of a locally flat fan.
/// - At a smooth junction, normal of the prescribed surface.
/// - Normal of a jet through surrounding rings (error O(h⁴), O(h³), O(h²) by degree).
/// - Area-weighted normal.
///
/// At a ridge, the last two are made perpendicular to the ridge's tangents, which are more accurate. Errors: stopped.
[[nodiscard]] Outcome<FanNormals> fan_normals(const SurrogateInput<3>& input, const Fans& fans, double max_degrees,
                                              const Execution& execution);

}  // namespace camber

export namespace camber {

struct SurrogateOptions {
    /// Normals and tangents of the file (`LinearMesh::geometry`) replace computed ones from which they differ by at
    /// most this angle (degrees). 0 ignores the file's.
    double file_directions_degrees = 30;
};

template <int D>
struct SurrogateEdge {
    CubicSimplex<1, D> curve;                 ///< from the lower vertex to the higher
    Vec<D> middle;                            ///< the curve at t = 1/2; exactly the chord's middle if straight
    std::uint32_t curve_number = no_feature;  ///< ridge curve (3D) or smooth curve (2D)
    friend bool operator==(const SurrogateEdge&, const SurrogateEdge&) = default;
};

/// A piecewise cubic surface through a mesh's boundary, G1 at vertices, made from the mesh alone (paper §3.1). It
/// consists of triangles in 3D and of curves in 2D. Later changes of the mesh do not affect it. Flat patches stay in
/// their planes.
template <int D>
struct Surrogate {
    static constexpr int K = D - 1;

    Column<CubicSimplex<K, D>> facets;
    Column<Reference> references;               ///< one per facet
    Column<std::uint32_t> patches;              ///< one per facet
    Column<FlatPatch<D>> flats;                 ///< one per patch
    Column<SimplexVertices<K>> vertices;        ///< one per facet
    Column<std::array<FacetId, D>> neighbours;  ///< facets across the smooth edge (2D: vertex) opposite each corner
    Column<EdgeId> edges;                       ///< boundary edges, ascending
    Column<SurrogateEdge<D>> edge_curves;       ///< one per row of `edges`
    BoxTree<D> tree;                            ///< over bounding boxes of control points
    BoxTree<D> curve_tree;                      ///< over bounding boxes of control points of `ridge_rows` (3D)
    Column<std::uint32_t> ridge_rows;           ///< rows of ridges in `edges`

    /// Row of e in `edges`; edges.size() if absent.
    [[nodiscard]] std::size_t row(EdgeId e) const;
};

/// Builds the surrogate of a boundary. Inner control points of edges are in the tangent planes at the vertices (ridges:
/// on the curve's tangents), as far from the vertices as on a circle. Edges beside bent ridges bend like the ridges
/// (`extend_over_triangles`), so that thin facets do not fold. The middle control point of a triangle is fitted to
/// adjacent vertices and normals, so that the centroid is as accurate as the edges, O(h⁴). Errors: `edges` or
/// `features` of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                    const Features<D>& features, const SurrogateOptions& options,
                                                    const Execution& execution);
/// Builds the surrogate of the part of the boundary on which `prescribed` has no surface. Smooth junctions get the
/// normals and tangents of `prescribed`.
template <int D>
[[nodiscard]] Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                    const Features<D>& features, const GeometryModel<D>& prescribed,
                                                    const SurrogateOptions& options, const Execution& execution);

template <int D>
struct SurrogateFoot {
    FacetId facet;
    Barycentric<D - 1> xi{};
    Vec<D> point;
    double distance_squared = 0;
};

/// Searches the closest point to p locally. The search starts on facet `start` and crosses smooth edges while the
/// distance falls. It then tests adjacent facets, because edges have slight creases. The result is never farther from p
/// than facet `start`.
template <int D>
[[nodiscard]] SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Vec<D>& p);
/// Starts at the coordinates `xi` and does not test adjacent facets: fast, for points very near the surface.
template <int D>
[[nodiscard]] SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Barycentric<D - 1>& xi,
                                            const Vec<D>& p);

/// Closest point on the facets for which admits(facet) is true; its facet is invalid if there are none. `known`:
/// closest point of one admitted facet, as a bound.
template <int D, class Admits>
[[nodiscard]] SurrogateFoot<D> closest_among(const Surrogate<D>& surrogate, const Vec<D>& p, Admits&& admits,
                                             const SurrogateFoot<D>& known = {}) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    double least = known.facet.valid() ? known.distance_squared : infinite;
    SurrogateFoot<D> best;
    const auto distance_squared = [&](std::size_t f) {
        if (FacetId(f) == known.facet || !admits(FacetId(f))) return infinite;
        Box<D> box;  // bounding box of the control points
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

/// Closest point of all ridge curves (3D). `row`: row of its edge in `Surrogate::edges`, or edges.size() without
/// ridges.
template <int D>
struct CurveFoot {
    std::size_t row = 0;
    double t = 0;
    Vec<D> point;
    double distance_squared = 0;
};
template <int D>
[[nodiscard]] CurveFoot<D> closest_on_ridges(const Surrogate<D>& surrogate, const Vec<D>& p);

/// Unit normal: to the right of a 2D facet, right-handed on a triangle.
template <int D>
[[nodiscard]] Vec<D> normal_at(const CubicSimplex<D - 1, D>& facet, const Barycentric<D - 1>& xi);

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] Outcome<Done> build_trees(Surrogate<D>& surrogate, const Execution& execution);

}  // namespace camber

export namespace camber {

struct CurvedPatches {
    std::size_t smooth = 0;    ///< number of patches whose curved facets are approximated by a smooth surface
    std::size_t as_read = 0;   ///< number of patches that keep their curved facets and kinks
    double largest_angle = 0;  ///< largest turn between pieces of smooth patches, radians
    double mean_angle = 0;     ///< root mean square of these turns
};

template <int D>
struct CurvedSurrogate {
    Surrogate<D> surrogate;
    CurvedPatches patches;
};

template <int D>
struct BoundaryCurves {
    const LinearMesh<D>& linear;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    std::span<const LagrangeNode<D>> nodes;  ///< one per edge
};

/// Builds a smooth surface through the vertices and nodes of a curved boundary; `straight` is the surrogate of its
/// straight facets.
///
/// - A patch has no own curves if all its nodes are on `straight` (to 1e-6 of the chord) or all are chord middles. If
///   no
///   patch has own curves, the result is `straight`.
/// - Otherwise facets are cut at their nodes, and normals and tangents are fitted to vertices and nodes. Patches
///   without own curves go through the nodes of `straight`.
/// - Patches of one facet, and patches whose curves are not smooth, keep the mesh's own facets exactly. Curves are not
///   smooth if the turns between quadratic facets exceed a quarter of the turns between straight facets (root mean
///   squares over the patch).
///
/// Ridges, patches and their neighbours are those of the straight mesh. Flat patches stay flat if their nodes are in
/// the plane. `prescribed`: as in `build_surrogate`. Errors: `straight` of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<CurvedSurrogate<D>> build_curved_surrogate(Surrogate<D> straight, const BoundaryCurves<D>& mesh,
                                                                 const GeometryModel<D>& prescribed,
                                                                 const SurrogateOptions& options,
                                                                 const Execution& execution);

/// Geometry of straight facets: no surface to project onto.
template <int D>
class StraightGeometry final : public GeometryModel<D> {
  public:
    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override;
    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override;
};

/// Geometry model of a surrogate. Surfaces are patches, curves are ridge curves. Facets and edges of the original mesh
/// are recognised by number and position; others are projected.
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(Surrogate<D> surrogate);

/// Surrogate of another mesh. It prescribes the surface of its references, and its ridges for edges with both ends near
/// a ridge.
template <int D>
struct PrescribedSurrogate {
    Surrogate<D> surrogate;
};
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(PrescribedSurrogate<D> prescribed);

/// References without an analytic surface have no surface.
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D> analytic);

/// Two geometries: facets with a reference in `references` lie on `first`, other facets on `rest` (possibly itself
/// mixed). The curve of an edge between `first` and `rest` depends on `rest`:
/// - `rest` is prescribed: the curve where both surfaces meet. For tangent surfaces, it is the rim of one of them, if
///   numbered (a CAD face ends at an edge).
/// - `rest` is not prescribed: the rim of `first`, if any. Without a rim, beside a plane, it is the curve where surface
///   and plane meet. Otherwise the edge's curve on `rest` is projected onto `first`.
template <int D>
struct MixedGeometry {
    std::vector<Reference> references;
    Geometry<D> first, rest;
};
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(MixedGeometry<D> mixed);

template <int D>
using SurrogateFactory = std::function<Outcome<Surrogate<D>>(const GeometryModel<D>& prescribed)>;

/// Returns the geometry of the analytic surfaces. If some facets have none, `surrogate` makes the geometry of these
/// facets. Errors: those of `surrogate`.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D> analytic, const LinearMesh<D>& mesh,
                                                  const SurrogateFactory<D>& surrogate);

}  // namespace camber
