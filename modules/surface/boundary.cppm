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

/// Largest distance of a boundary vertex from its surface or curve, as a share of the shortest boundary edge at the
/// vertex. A vertex farther away is off.
inline constexpr double off_limit = 0.05;

/// Largest share of the vertices of one surface or curve that may be off. More of them mean that the mesh was made on
/// another surface.
inline constexpr double off_vertices = 0.02;

/// To three significant digits.
[[nodiscard]] inline std::string three_digits(double number) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::general, 3);
    return {digits.data(), end.ptr};
}

/// Lengths of the boundary edges at a vertex.
struct EdgeLengthsAt {
    double shortest = 0, longest = 0;
};
/// Those of the edges of these facets (at least one).
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

/// The vertices of a mesh on one surface or curve, and those of them that are off.
struct VertexFit {
    std::size_t vertices = 0, off = 0;
    std::size_t lost = 0;            ///< off by more than half of their longest edge
    double largest = 0, length = 0;  ///< the largest distance, and the shortest edge at that vertex
    VertexId farthest = {};

    void add(VertexId v, double distance, const EdgeLengthsAt& edges) {
        constexpr double half = 0.5;
        ++vertices;
        if (distance <= off_limit * edges.shortest) return;
        const double far = std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
        const std::size_t is_lost = far <= half * edges.longest ? 0 : 1;
        add({0, 1, is_lost, far, edges.shortest, v});
    }
    /// Adds other vertices of the same surface. Of equally far ones the first is reported, in any order of addition.
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
    /// Whether too many vertices are off. Less than the vertices of one facet of `facet_vertices` vertices say nothing
    /// about a surface: a mesher may have merged a small edge.
    [[nodiscard]] bool is_refused(std::size_t facet_vertices) const {
        return off >= facet_vertices && static_cast<double>(off) > off_vertices * static_cast<double>(vertices);
    }
    /// The sentence about the farthest vertex, and how many are off; `name`: that of the surface or curve.
    [[nodiscard]] std::string text(std::string_view name) const {
        return "is " + three_digits(largest) + " away from " + std::string(name) + ", " +
               three_digits(100 * largest / length) + " % of the shortest boundary edge there; " + std::to_string(off) +
               " of the " + std::to_string(vertices) + " vertices of the mesh on " + std::string(name) +
               " are off by more than " + three_digits(100 * off_limit) + " % of that length";
    }
};

/// How far a vertex may be from the boundary of another mesh, as a share of the facet's longest edge.
inline constexpr double fit_tolerance = 0.1;

/// A vertex that is farther than that.
struct Misfit {
    double distance = 0, allowed = 0;
    VertexId vertex = {};
    Reference reference = 0;
};
/// The farther one; of equally far ones the first, whatever the order in which they are met.
[[nodiscard]] inline Misfit worse(const Misfit& a, const Misfit& b) {
    if (a.distance != b.distance) return a.distance > b.distance ? a : b;
    return b.distance > 0 && b.vertex < a.vertex ? b : a;
}

/// Distances of facets from the boundary of another mesh. A mesh that was adapted to thin layers may have left single
/// vertices short of the surface: those of one facet in a hundred may be beyond the tolerance, but by less than half of
/// their edges.
struct BoundaryFit {
    std::size_t facets = 0, off = 0;
    Misfit worst;

    /// One more facet; a misfit of no distance: on the surface.
    void add(const Misfit& misfit) {
        ++facets;
        off += misfit.distance > 0 ? 1 : 0;
        worst = worse(worst, misfit);
    }
    void add(const BoundaryFit& others) {
        facets += others.facets;
        off += others.off;
        worst = worse(worst, others.worst);
    }
    /// The worst one, where there are too many of them or it is too far.
    [[nodiscard]] std::optional<Misfit> refused() const {
        constexpr std::size_t most = 100;
        constexpr double farthest = 0.5 / fit_tolerance;
        if (off * most <= facets && !(worst.distance > farthest * worst.allowed)) return {};
        return worst;
    }
};

/// The mid node of an edge of the boundary: where the geometry has the edge's middle. Where the ends are off the
/// geometry by more than `off_limit` of the chord (on the average, as vectors), the edge would have cusps at its ends:
/// the node is then within that limit of the curve parallel to the geometry through the ends, and within a quarter of
/// the chord from its middle, so that the edge turns by at most 90 degrees. An edge never leaves an end backwards.
template <int D>
[[nodiscard]] Vec<D> node_without_cusp(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

/// New mid nodes of all edges: those of boundary edges on the geometry, those of volume edges as they are.
///
/// Surrogate: the middle of the edge's own curve where the surrogate was made from this mesh, else the chord's middle
/// projected (ridges: onto the ridge curves). Analytic: the chord's middle projected onto the surface of the edge's
/// facets, or onto the curve where two surfaces meet; a facet without a surface counts as a part of its own plane
/// beside a curved one. Mixed: each edge as its facets' references say; where a surface meets a flat patch of the
/// surrogate, onto the curve of both, and where it meets a curved one, the node of the surrogate's ridge projected onto
/// the surface. Straight: chord middles. Edges of flat patches and ridges between two planes keep the chord's
/// middle to the last bit; edges that are required or belong to required facets or elements keep the mesh's node, which
/// is that middle where the mesh was elevated. Errors: `features` is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                              const Geometry<D>& geometry, const Execution& execution);

/// `nodes` with those of edges within planes (of the geometry, or flat patches of a surrogate) moved by the part of
/// `shifts` (one row an edge) that lies in the plane. Others keep theirs: on a curved surface a node off the middle of
/// its curve costs the geometry an order of approximation, and curves (ridges; in 2D all edges of the boundary) leave
/// only slides along themselves; so do required edges. Errors: as boundary_nodes; rows that do not fit the mesh
/// (ErrorKind::internal).
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>& mesh,
                                                          const Column<LagrangeNode<D>>& nodes,
                                                          std::span<const Vec<D>> shifts, const Features<D>& features,
                                                          const Geometry<D>& geometry, const Execution& execution);

/// How far the curved boundary is from the geometry, in model units. `mean` is weighted by the straight facets' areas.
struct BoundaryDistance {
    double largest = 0, mean = 0;
    FacetId worst = {};
};

/// Each curved facet is sampled on the lattice of tenths (66 points; 11 in 2D) and projected. Facets that lie in a flat
/// patch of the surrogate count 0 within that plane's tolerance. In a mixed geometry the reference tells whether it is
/// the surface or the surrogate. Without either (straight geometry, or a reference that has none) the distance is that
/// to the facet's own plane. Errors: as boundary_nodes.
template <int D>
[[nodiscard]] Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<D>& mesh,
                                                          std::span<const LagrangeNode<D>> mid_nodes,
                                                          const Features<D>& features, const Geometry<D>& geometry,
                                                          const Execution& execution);

/// Largest distances from the geometry at which boundary nodes and vertices count as being on it, as shares of the
/// local boundary edge length.
struct BoundaryTolerance {
    double nodes = 1e-5;     ///< of a mid node, by the chord of its edge
    double vertices = 0.05;  ///< of a vertex, by the longest boundary edge at it: input meshes are not exact

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

/// Boundary entities of one kind that are off the geometry.
template <class Id>
struct OffGeometry {
    std::size_t measured = 0;  ///< number of entities that have a geometry
    std::size_t off = 0;       ///< number of those farther from it than the tolerance
    double largest = 0;        ///< largest distance (model units)
    double share = 0;          ///< largest distance as a share of the local edge length
    Id worst = {};             ///< entity with the largest share; invalid: all shares are 0
};

/// Distances of the boundary's nodes and vertices from the geometry, counted against a tolerance.
struct BoundaryDeviation {
    OffGeometry<EdgeId> nodes;
    OffGeometry<VertexId> vertices;
};

/// Measures the distance of each boundary node and vertex of a mesh from its geometry. Distances within the rounding of
/// the coordinates do not count as off.
///
/// `kinds`: one an edge; nodes of kind `surface` and `ridge` are measured. Those of kind `fixed` and required vertices
/// stay by request and are not.
/// `own_nodes`: one an edge where the input mesh was curved, else empty; the input's node is then the geometry of each
/// edge for which `geometry` prescribes no surface. Errors: rows that do not fit the mesh (ErrorKind::internal),
/// stopped.
template <int D>
[[nodiscard]] Outcome<BoundaryDeviation> boundary_deviation(
    const QuadraticMesh<D>& mesh, std::span<const EdgeKind> kinds, const Geometry<D>& geometry,
    std::span<const LagrangeNode<D>> own_nodes, const BoundaryTolerance& tolerance, const Execution& execution);

/// The largest distance of boundary_distance alone. Points that are known to be nearer than another one are not
/// projected, and a facet is left out if 21 points of it (2D: 6) are all within 0.8 of the largest distance of another:
/// where the distance is as smooth as between a facet and its surface, the result is the same up to rounding.
/// Errors: as boundary_nodes.
template <int D>
[[nodiscard]] Outcome<LargestDistance> largest_boundary_distance(const QuadraticMesh<D>& mesh,
                                                                 std::span<const LagrangeNode<D>> mid_nodes,
                                                                 const Features<D>& features,
                                                                 const Geometry<D>& geometry,
                                                                 const Execution& execution);

/// Other nodes of the same mesh, whose largest distance from the geometry is known.
template <int D>
struct NearBoundary {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> mid_nodes;
    double largest = 0;
};

/// The same largest distance, by the nodes of a boundary that is near the geometry: a facet whose nodes are not far
/// from those is left out. Errors: as boundary_nodes.
template <int D>
[[nodiscard]] Outcome<LargestDistance> largest_boundary_distance(
    const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, const Features<D>& features,
    const Geometry<D>& geometry, const NearBoundary<D>& near, const Execution& execution);

/// The curves of a mesh at which nothing breaks (3D; in 2D facets are the curves, and the geometry knows them): edges
/// that its maker lists, or that part two entities of his, where the surface goes on smoothly, and listed edges inside
/// the volume. A geometry knows the surface around such a curve, not the curve, so it is kept as the mesh has it.
template <int D>
struct EmbeddedCurves {
    /// Of one edge.
    struct Piece {
        CubicSimplex<1, D> curve;
        Reference reference = 0;
    };
    Column<Piece> pieces;
    Column<EdgeId> edges;      ///< of the mesh that they were found in, one a piece
    BoxTree<D> tree;           ///< over their control points
    Column<VertexId> corners;  ///< of the mesh that they were found in, rising: where a curve turns
};

/// Curves in a mesh with these features. A piece is the edge's own curve where the mesh has `nodes` (one a unique edge;
/// none: an empty span); else, on a surface of the geometry, as smooth as a ridge curve of the surrogate; else
/// straight. Corners are where two edges of a curve turn by more than 40 degrees, beside a straight one by more than
/// rounding. Errors: of find_features and build_surrogate.
template <int D>
[[nodiscard]] Outcome<EmbeddedCurves<D>> find_embedded_curves(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              const Features<D>& features, const Geometry<D>& geometry,
                                                              std::span<const LagrangeNode<D>> nodes,
                                                              const Execution& execution);

/// The closest point of all curves with that reference, if there are any.
template <int D>
[[nodiscard]] std::optional<Vec<D>> closest_on_curves(const EmbeddedCurves<D>& curves, Reference reference,
                                                      const Vec<D>& p);

/// `nodes` (one a unique edge of the mesh) with those of the curves' edges on the boundary in the middles of their
/// pieces, put onto the surface that the geometry has there. Edges that are required keep theirs, and edges inside the
/// volume. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> nodes_on_curves(const QuadraticMesh<D>& mesh,
                                                               Buffer<LagrangeNode<D>> nodes,
                                                               const EmbeddedCurves<D>& curves,
                                                               const Geometry<D>& geometry, const Execution& execution);

/// `kinds` with the curves' edges as ridges: what moves nodes within a surface, or in the volume, leaves them.
template <int D>
[[nodiscard]] Column<EdgeKind> kinds_with_curves(const Column<EdgeKind>& kinds, const EmbeddedCurves<D>& curves);

}  // namespace camber

/// How far a curved boundary and its geometry are from each other, both ways and by the geometry's entities.
export namespace camber {

/// Directions of a distance: from the boundary to the geometry, or both ways, by entity.
enum class DistanceWays : std::uint8_t { boundary, both };
[[nodiscard]] constexpr auto words(DistanceWays) {
    return words_of(Word{DistanceWays::boundary, "boundary"}, Word{DistanceWays::both, "both"});
}

/// The curved facets of a mesh to be searched for nearest points: each raised to degree 3, which is exact.
template <int D>
struct CurvedBoundary {
    Column<CubicSimplex<D - 1, D>> facets;
    BoxTree<D> tree;  ///< over the facets' control points
};
template <int D>
[[nodiscard]] Outcome<CurvedBoundary<D>> curved_boundary(const QuadraticMesh<D>& mesh,
                                                         std::span<const LagrangeNode<D>> mid_nodes,
                                                         const Execution& execution);

/// A place on it.
template <int D>
struct BoundaryFoot {
    FacetId facet;
    Barycentric<D - 1> xi{};
    Vec<D> point;
    double distance_squared = std::numeric_limits<double>::infinity();
};
/// The nearest point of all facets, the lowest facet of equally near ones; `near`: one that is not far, if one is
/// known. An invalid facet when there are none.
template <int D>
[[nodiscard]] BoundaryFoot<D> closest_on(const CurvedBoundary<D>& boundary, const Vec<D>& p, FacetId near = {});

/// What of a geometry stands over the facets of a mesh, and over its edges where two surfaces meet: the points at a
/// lattice of each facet, and of each edge, that GeometryModel::points_over and on_edge have there. For makers whose
/// surfaces have no end (a plane, a cylinder), or end where the mesh does (a surrogate): parts of a geometry that no
/// facet stands for are not seen. Errors: `features` is not of this mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_over(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                       const Geometry<D>& geometry, const Execution& execution);

/// One way: from points of one side to the nearest of the other (model units).
template <int D>
struct OneWay {
    std::size_t samples = 0;
    double largest = 0, mean = 0;  ///< the mean by area or length
    Vec<D> from, to;               ///< where it is largest
    FacetId facet = {};            ///< there; of a curve one beside it
};

/// Of one surface or curve. A facet without a surface (`GeometryKind::none`) is measured from its own plane.
template <int D>
struct EntityDistances {
    GeometryEntity entity;
    std::size_t pieces = 0;             ///< facets that lie on it; of a curve edges
    std::vector<Reference> references;  ///< of those facets, rising; of a curve those of facets beside it
    double measure = 0;                 ///< area or length of those pieces, straight
    bool is_flat = false;               ///< a plane, 2D a line, where a facet lies on it
    OneWay<D> to_geometry, to_boundary;
};

template <int D>
struct GeometryDistances {
    std::vector<EntityDistances<D>> entities;  ///< surfaces, then curves, by rising number
    OneWay<D> to_geometry, to_boundary;        ///< of all surfaces
    /// One a facet: the largest of its points from the geometry; and of the points of the geometry that it is nearest
    /// to (0: it is to none).
    Column<double> of_facets, to_facets;
};

/// From the boundary: each curved facet is sampled as by boundary_distance, and each edge on a curve at tenths. From
/// the geometry: each of its points to the nearest of all curved facets; of a curve to the nearest of the edges that
/// lie on it, where there are any. Errors: `features` or `mid_nodes` are not of this mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<GeometryDistances<D>> distances_both_ways(
    const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, const Features<D>& features,
    const Geometry<D>& geometry, const GeometrySamples<D>& samples, const Execution& execution);

}  // namespace camber

namespace camber {

/// α/N for all α: a lattice on a facet.
template <int N, int D>
inline constexpr auto facet_lattice = [] {
    std::array<Barycentric<D - 1>, node_count<N, D - 1>> all{};
    for (std::size_t n = 0; n < all.size(); ++n)
        for (std::size_t i = 0; i < D; ++i) all[n][i] = static_cast<double>(multi_indices<N, D - 1>[n][i]) / N;
    return all;
}();

/// Of the facet when straight: its area, 2D its length.
template <int D>
[[nodiscard]] double straight_measure(const FacetSite<D>& facet) {
    const auto& c = facet.corners;
    if constexpr (D == 2)
        return distance(c[0], c[1]);
    else
        return 0.5 * norm(cross(c[1] - c[0], c[2] - c[0]));
}

}  // namespace camber
