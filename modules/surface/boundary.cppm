module;
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>
export module camber.surface:boundary;
import camber.core;
import camber.box_tree;
import camber.bezier;
import :features;
import :geometry;
import :surrogate;

export namespace camber {

/// A boundary vertex is off its surface or curve if its distance exceeds this share of its shortest boundary edge.
inline constexpr double off_limit = 0.05;

/// Largest share of the vertices of one surface or curve that may be off. A larger share means that the mesh was made
/// on another surface.
inline constexpr double off_vertices = 0.02;

[[nodiscard]] inline std::string three_digits(double number) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::general, 3);
    return {digits.data(), end.ptr};
}

struct EdgeLengthsAt {
    double shortest = 0, longest = 0;
};
template <int D>
[[nodiscard]] EdgeLengthsAt edge_lengths_at(const LinearMesh<D>& mesh, std::span<const FacetId> facets, VertexId v) {
    EdgeLengthsAt out{std::numeric_limits<double>::infinity(), 0};
    for (const FacetId f : facets)
        for (const VertexId other : mesh.facets.vertices[f]) {
            if (other == v) continue;
            const double length = distance(mesh.points[v], mesh.points[other]);
            out = {std::fmin(out.shortest, length), std::fmax(out.longest, length)};
        }
    return out;
}

/// Fit of mesh vertices to one surface or curve. `off`: number of vertices that are off (see `off_limit`).
struct VertexFit {
    std::size_t vertices = 0, off = 0;
    std::size_t lost = 0;            ///< vertices whose distance exceeds half of their longest edge
    double largest = 0, length = 0;  ///< distance and shortest edge of the farthest vertex
    VertexId farthest = {};

    void add(VertexId v, double distance, const EdgeLengthsAt& edges) {
        constexpr double half = 0.5;
        ++vertices;
        if (distance <= off_limit * edges.shortest) return;
        const double far = std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
        const std::size_t is_lost = far <= half * edges.longest ? 0 : 1;
        add({0, 1, is_lost, far, edges.shortest, v});
    }
    /// If several vertices are equally far, `farthest` becomes the lowest of them. The result does not depend on the
    /// order of the calls.
    void add(const VertexFit& others) {
        vertices += others.vertices;
        off += others.off;
        lost += others.lost;
        if (others.off == 0 || others.largest < largest) return;
        if (off > others.off && others.largest == largest && farthest < others.farthest) return;
        largest = others.largest;
        length = others.length;
        farthest = others.farthest;
    }
    /// True if too many vertices are off. Fewer than `facet_vertices` (number of vertices of a facet) are accepted,
    /// because a mesher may have merged a small edge.
    [[nodiscard]] bool is_refused(std::size_t facet_vertices) const {
        return off >= facet_vertices && static_cast<double>(off) > off_vertices * static_cast<double>(vertices);
    }
    [[nodiscard]] std::string text(std::string_view name) const {
        return "is " + three_digits(largest) + " away from " + std::string(name) + ", " +
               three_digits(100 * largest / length) + " % of the shortest boundary edge there; " + std::to_string(off) +
               " of the " + std::to_string(vertices) + " vertices of the mesh on " + std::string(name) +
               " are off by more than " + three_digits(100 * off_limit) + " % of that length";
    }
};

/// Largest accepted distance of a facet's vertex from another mesh's boundary, relative to the facet's longest edge.
inline constexpr double fit_tolerance = 0.1;

struct FitError {
    double distance = 0, allowed = 0;
    VertexId vertex = {};
    Reference reference = 0;
};
[[nodiscard]] inline FitError worse(const FitError& a, const FitError& b) {
    if (a.distance != b.distance) return a.distance > b.distance ? a : b;
    return b.distance > 0 && b.vertex < a.vertex ? b : a;
}

/// Distances of facets from another mesh's boundary. One facet in a hundred may be off, by less than half of its
/// longest edge, because adaptation to thin layers can leave vertices off the surface.
struct BoundaryFit {
    std::size_t facets = 0, off = 0;
    FitError worst;

    void add(const FitError& fit_error) {
        ++facets;
        off += fit_error.distance > 0 ? 1 : 0;
        worst = worse(worst, fit_error);
    }
    void add(const BoundaryFit& others) {
        facets += others.facets;
        off += others.off;
        worst = worse(worst, others.worst);
    }
    /// Returns the error of the worst facet if its distance is too large or if too many facets are off, else nothing.
    [[nodiscard]] std::optional<FitError> refused() const {
        constexpr std::size_t most = 100;
        constexpr double farthest = 0.5 / fit_tolerance;
        if (off * most <= facets && !(worst.distance > farthest * worst.allowed)) return {};
        return worst;
    }
};

/// Returns a mid node for a boundary edge, such that the curved edge has no cusp. The node is the edge's middle on the
/// geometry (`middle_of`), except in two cases:
/// - The ends of the edge are off the geometry, and their mean offset exceeds `off_limit` of the chord. The node is
///   shifted by
///   the excess, and is at most a quarter of the chord from the chord's middle. The edge then turns by at most 90
///   degrees.
/// - The node is more than a quarter of the chord off the middle, along the chord. This offset is reduced, so that the
///   edge does not leave an end backwards.
template <int D>
[[nodiscard]] Vec<D> node_without_cusp(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

/// Computes the mid nodes of all edges. Volume edges keep their nodes. Nodes of boundary edges depend on the kind of
/// geometry:
///
/// - Surrogate of this mesh: the middle of the edge's curve. Surrogate of another mesh: the projected chord middle, for
///   ridges projected onto ridge curves.
/// - Analytic: the chord's middle, projected onto the surface of the edge's facets or onto the curve of two surfaces.
///   Beside a curved surface, facets without a surface count as planes.
/// - Mixed: the reference of a facet selects its geometry. Between a surface and a flat patch, the node is on the curve
///   of both. Between a surface and a curved patch, it is the surrogate's ridge node, projected onto the surface.
/// - Straight: the chord's middle.
///
/// Edges of flat patches and ridges between planes have exactly the chord's middle. Required edges, and edges of
/// required facets or elements, keep the mesh's node. Errors: `features` of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                              const Geometry<D>& geometry, const Execution& execution);

/// Moves the nodes of edges that lie in a plane (of the geometry, or of a flat patch) by the in-plane part of `shifts`
/// (one per edge). These nodes are fixed:
/// - nodes of required edges;
/// - nodes on curved surfaces, because a node away from the middle of its curve reduces the order of approximation;
/// - nodes of ridges (2D: of all boundary edges), because they could only slide along the curve.
///
/// Errors: those of `boundary_nodes`; wrong row counts (internal).
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>& mesh,
                                                          const Column<LagrangeNode<D>>& nodes,
                                                          std::span<const Vec<D>> shifts, const Features<D>& features,
                                                          const Geometry<D>& geometry, const Execution& execution);

/// Distance of the curved boundary from the geometry (model units). `mean` is weighted by straight facet areas.
struct BoundaryDistance {
    double largest = 0, mean = 0;
    FacetId worst = {};
};

/// Projects 66 points of each curved facet (2D: 11), with barycentric coordinates that are multiples of 1/10. Distances
/// within the tolerance of a flat patch's plane count as 0. In a mixed geometry the reference selects the surface or
/// the surrogate. Facets without a surface are measured from their own plane. Errors: those of `boundary_nodes`.
template <int D>
[[nodiscard]] Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<D>& mesh,
                                                          std::span<const LagrangeNode<D>> mid_nodes,
                                                          const Features<D>& features, const Geometry<D>& geometry,
                                                          const Execution& execution);

/// Largest distances that count as on the geometry, as shares of the local boundary edge length.
struct BoundaryTolerance {
    double nodes = 1e-5;     ///< for a mid node: its distance, divided by its edge's chord
    double vertices = 0.05;  ///< for a vertex: its distance, divided by its longest boundary edge; large because input
                             ///< is inexact

    [[nodiscard]] static constexpr auto options() {
        using S = BoundaryTolerance;
        return std::tuple(
            option("nodes", &S::nodes, "largest distance of the node of a boundary edge from its geometry")
                .unit("shares of the edge's length")
                .at_least(0),
            option("vertices", &S::vertices, "largest distance of a boundary vertex from its geometry")
                .unit("shares of the longest boundary edge at the vertex")
                .at_least(0));
    }
    friend bool operator==(const BoundaryTolerance&, const BoundaryTolerance&) = default;
};

template <class Id>
struct OffGeometry {
    std::size_t measured = 0;  ///< entities with a geometry
    std::size_t off = 0;
    double largest = 0;  ///< largest distance, in model units
    double share = 0;    ///< largest distance divided by the edge length
    Id worst = {};       ///< entity with this share; invalid if all distances are 0
};

struct BoundaryDeviation {
    OffGeometry<EdgeId> nodes;
    OffGeometry<VertexId> vertices;
};

/// Measures boundary nodes and vertices against a tolerance. Distances within the rounding of coordinates are never
/// off.
///
/// `kinds` (one per edge): nodes of kind `surface` and `ridge` are measured. All boundary vertices except required ones
/// are measured too.
///
/// `own_nodes`: the input's nodes (one per edge), or empty for a straight mesh. If `geometry` prescribes no surface at
/// an edge, its node is measured from the node in `own_nodes`. Errors: wrong row counts (internal), stopped.
template <int D>
[[nodiscard]] Outcome<BoundaryDeviation> boundary_deviation(
    const QuadraticMesh<D>& mesh, std::span<const EdgeKind> kinds, const Geometry<D>& geometry,
    std::span<const LagrangeNode<D>> own_nodes, const BoundaryTolerance& tolerance, const Execution& execution);

/// Computes only the largest distance of `boundary_distance`. Skips points that are provably nearer than another point.
/// Skips facets whose 21 test points (2D: 6) are within 0.8 times another facet's largest distance. The result is the
/// same up to rounding where the distance is smooth, as between a facet and its surface. Errors: those of
/// `boundary_nodes`.
template <int D>
[[nodiscard]] Outcome<LargestDistance> largest_boundary_distance(const QuadraticMesh<D>& mesh,
                                                                 std::span<const LagrangeNode<D>> mid_nodes,
                                                                 const Features<D>& features,
                                                                 const Geometry<D>& geometry,
                                                                 const Execution& execution);

template <int D>
struct NearBoundary {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> mid_nodes;
    double largest = 0;
};

/// Faster version for a boundary close to `near`, whose largest distance is known. Skips facets whose nodes are close
/// to the nodes of `near`.
template <int D>
[[nodiscard]] Outcome<LargestDistance> largest_boundary_distance(
    const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, const Features<D>& features,
    const Geometry<D>& geometry, const NearBoundary<D>& near, const Execution& execution);

/// Curves of a 3D mesh across which the surface is smooth. Their edges are listed in the file, or are between two
/// entities of the mesher's model. Listed edges may be inside the volume. The geometry does not contain these curves,
/// so their shape in the mesh is preserved.
template <int D>
struct EmbeddedCurves {
    struct Piece {
        CubicSimplex<1, D> curve;
        Reference reference = 0;
    };
    Column<Piece> pieces;
    Column<EdgeId> edges;      ///< mesh edge of each piece
    BoxTree<D> tree;           ///< over bounding boxes of control points
    Column<VertexId> corners;  ///< mesh vertices where a curve turns, ascending
};

/// Finds the embedded curves. `nodes`: one per unique edge, or empty. With nodes, each piece is the quadratic curve of
/// its edge. Without nodes, pieces on a surface of the geometry are as smooth as the surrogate's ridge curves, and
/// other pieces are straight. Curves have corners where they turn by more than 40 degrees, or, beside a straight edge,
/// by more than rounding. Errors: those of `find_features` and `build_surrogate`.
template <int D>
[[nodiscard]] Outcome<EmbeddedCurves<D>> find_embedded_curves(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              const Features<D>& features, const Geometry<D>& geometry,
                                                              std::span<const LagrangeNode<D>> nodes,
                                                              const Execution& execution);

template <int D>
[[nodiscard]] std::optional<Vec<D>> closest_on_curves(const EmbeddedCurves<D>& curves, Reference reference,
                                                      const Vec<D>& p);

/// Moves the nodes (one per unique edge) of boundary edges on embedded curves to the middles of their pieces, projected
/// onto the geometry's surface. Required edges and edges inside the volume are unchanged. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> nodes_on_curves(const QuadraticMesh<D>& mesh,
                                                               Buffer<LagrangeNode<D>> nodes,
                                                               const EmbeddedCurves<D>& curves,
                                                               const Geometry<D>& geometry, const Execution& execution);

/// Returns `kinds`, but edges on the curves are ridges, so that their nodes stay on the curves.
template <int D>
[[nodiscard]] Column<EdgeKind> kinds_with_curves(const Column<EdgeKind>& kinds, const EmbeddedCurves<D>& curves);

}  // namespace camber

export namespace camber {

enum class DistanceDirections : std::uint8_t { boundary, both };
[[nodiscard]] constexpr auto words(DistanceDirections) {
    return words_of(Word{DistanceDirections::boundary, "boundary"}, Word{DistanceDirections::both, "both"});
}

/// Curved facets for closest-point searches, exactly converted to degree 3.
template <int D>
struct CurvedBoundary {
    Column<CubicSimplex<D - 1, D>> facets;
    BoxTree<D> tree;  ///< over bounding boxes of control points
};
template <int D>
[[nodiscard]] Outcome<CurvedBoundary<D>> curved_boundary(const QuadraticMesh<D>& mesh,
                                                         std::span<const LagrangeNode<D>> mid_nodes,
                                                         const Execution& execution);

template <int D>
struct BoundaryFoot {
    FacetId facet;
    Barycentric<D - 1> xi{};
    Vec<D> point;
    double distance_squared = std::numeric_limits<double>::infinity();
};
/// Returns the closest point to p, on the lowest of equally near facets. `near`: a nearby facet, if known. The result
/// has an invalid facet if the boundary is empty.
template <int D>
[[nodiscard]] BoundaryFoot<D> closest_on(const CurvedBoundary<D>& boundary, const Vec<D>& p, FacetId near = {});

/// Samples the geometry over a mesh: over a lattice on each facet (`GeometryModel::surface_points`), and along each
/// edge between two surfaces (`on_edge`). Parts of the geometry without facets are not sampled. Errors: `features` of
/// another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> sample_over_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                           const Geometry<D>& geometry, const Execution& execution);

/// Distances from points of the boundary to the geometry, or in the reverse direction (model units).
template <int D>
struct DirectedDistance {
    std::size_t samples = 0;
    double largest = 0, mean = 0;  ///< `mean` is weighted by area or length
    Vec<D> from, to;               ///< the two points between which the distance is largest
    FacetId facet = {};            ///< facet of these points; for a curve, a facet beside it
};

/// Distances of one surface or curve, or of facets without a surface.
template <int D>
struct EntityDistances {
    GeometryEntity entity;
    std::size_t pieces = 0;             ///< number of facets, or of edges of a curve
    std::vector<Reference> references;  ///< references of the facets (for a curve: of the facets beside it), ascending
    double measure = 0;                 ///< area or length of the straight pieces
    bool is_flat = false;               ///< all facets of the entity are in one plane (edges of a curve: on one line)
    DirectedDistance<D> to_geometry, to_boundary;
};

template <int D>
struct GeometryDistances {
    std::vector<EntityDistances<D>> entities;      ///< surfaces, then curves
    DirectedDistance<D> to_geometry, to_boundary;  ///< over all surfaces
    /// Largest distances, one per facet. `of_facets`: distance from the facet's points to the geometry. `to_facets`:
    /// distance to the facet from the geometry's samples that are closest to this facet; 0 without such samples.
    Column<double> of_facets, to_facets;
};

/// Measures distances from the boundary to the geometry and back. From the boundary, facets are sampled as in
/// `boundary_distance`, and edges on curves at multiples of 1/10 of their parameter. From the geometry, each sample is
/// measured to the closest curved facet. Samples of a curve are measured to its closest mesh edge, if it has one.
/// Errors: `features` or `mid_nodes` of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<GeometryDistances<D>> two_sided_distances(
    const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, const Features<D>& features,
    const Geometry<D>& geometry, const GeometrySamples<D>& samples, const Execution& execution);

}  // namespace camber

namespace camber {

template <int N, int D>
inline constexpr auto facet_lattice = [] {
    std::array<Barycentric<D - 1>, node_count<N, D - 1>> all{};
    for (std::size_t n = 0; n < all.size(); ++n)
        for (std::size_t i = 0; i < D; ++i) all[n][i] = static_cast<double>(multi_indices<N, D - 1>[n][i]) / N;
    return all;
}();

template <int D>
[[nodiscard]] double straight_measure(const FacetSite<D>& facet) {
    const auto& c = facet.corners;
    if constexpr (D == 2)
        return distance(c[0], c[1]);
    else
        return 0.5 * norm(cross(c[1] - c[0], c[2] - c[0]));
}

}  // namespace camber
