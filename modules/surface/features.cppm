module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>
export module camber.surface:features;
import camber.core;
import camber.bezier;

export namespace camber {

/// When the boundary breaks.
template <int D>
struct FeatureOptions {
    double ridge_angle_degrees = 40;  ///< 2D: a vertex where facets turn by more is a corner
    /// A vertex where a ridge curve turns by more than this (degrees) is a corner (3D).
    double corner_angle_degrees = 40;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("ridge_angle", &FeatureOptions::ridge_angle_degrees,
                                 "facets that meet at more than this angle make a ridge")
                              .unit("degrees")
                              .above(0)
                              .at_most(180));
    }
};

/// Where a vertex lies: a ridge curve passes through a ridge vertex and breaks at a corner. In 2D the boundary edges
/// are pieces of smooth curves: their vertices are surface or corner.
enum class VertexKind : std::uint8_t { volume, surface, ridge, corner };

/// Of no patch, of no curve.
inline constexpr std::uint32_t no_feature = 0xffffffffU;

/// The features of a mesh's boundary (interfaces between materials included).
///
/// 3D: an edge of facets is a ridge if the file lists it among `ridges`, if the references of its facets differ, if
/// they turn by more than the ridge angle, or if it has not exactly two facets. (A turn of less than 1.5 times that
/// angle makes no ridge where it is the mesh's coarseness: around a lone facet whose three edges all turn so, which is
/// too large for a smooth surface and not a face of its own, and at a lone edge that no other ridge meets. At an edge
/// that the file lists among `edges` it does.) An edge that is merely listed is of kind `surface`. A vertex
/// of ridges is a corner if the file says so, if it has not exactly two ridge edges, or if they turn by more than the
/// corner angle; a vertex of none if the file says so, or if it is the tip of a cone: all edges of its facets leave the
/// plane across their mean direction by more than the ridge angle, to one side. A vertex in which surfaces touch is a
/// corner too: where the facets around it, connected across edges that are not ridges, make a sheet that its two ridge
/// edges do not both bound, or more than one sheet at a vertex without ridges. The end of a baffle's rim on a wall is
/// one. A patch is a set of facets connected
/// across edges that are not ridges; a curve is a chain of ridge edges between corners. 2D: facets are edges of kind
/// `surface`; a vertex is a corner if the file says so (also: an end of a facet listed among `ridges`), if it has not
/// exactly two facets, if their references differ, or if they turn by more than the ridge angle. Patches and curves are
/// the same chains of facets between corners.
template <int D>
struct Features {
    Column<EdgeKind> edge_kinds;      ///< one a unique edge
    Column<VertexKind> vertex_kinds;  ///< one a vertex
    Column<std::uint32_t> patches;    ///< one a facet: its smooth patch, from 0
    Column<std::uint32_t> curves;     ///< one a unique edge: its curve, from 0, or no_feature
    std::size_t patch_count = 0, curve_count = 0;
    std::size_t surface_edges = 0, ridge_edges = 0, corners = 0;

    friend bool operator==(const Features&, const Features&) = default;
};

/// The vertices that are corners, rising.
template <int D>
[[nodiscard]] inline std::vector<VertexId> corners_of(const Features<D>& features) {
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < features.vertex_kinds.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    return corners;
}

/// Errors: `edges` is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<Features<D>> find_features(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const FeatureOptions<D>& options, const Execution& execution);

/// A patch that is part of a plane (2D: of a line); `normal` is zero for a patch that is not.
template <int D>
struct FlatPatch {
    Vec<D> point, normal;
    double tolerance = 0;  ///< a point nearer to the plane than this is on it
    int axis = -1;         ///< the axis that the normal lies along exactly: that coordinate is the same everywhere

    [[nodiscard]] inline bool is_flat() const { return norm_squared(normal) > 0; }
    /// Signed distance; 0 within the tolerance.
    [[nodiscard]] inline double height(const Vec<D>& p) const {
        const double h = axis >= 0 ? p[static_cast<std::size_t>(axis)] - point[static_cast<std::size_t>(axis)]
                                   : dot(p - point, normal);
        return std::fabs(h) <= tolerance ? 0 : h;
    }
    /// The closest point of the plane, to the last bit where the normal is along an axis.
    [[nodiscard]] inline Vec<D> snapped(Vec<D> p) const {
        if (axis < 0) return p - dot(p - point, normal) * normal;
        p[static_cast<std::size_t>(axis)] = point[static_cast<std::size_t>(axis)];
        return p;
    }
    friend bool operator==(const FlatPatch&, const FlatPatch&) = default;
};

/// The plane through the vertices of each patch, where they are in one. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                                         const Execution& execution);

}  // namespace camber

namespace camber {

/// Distances below this share of a set's size are none; coordinates themselves are known to a few ulps.
inline constexpr double flat_tolerance = 1e-12;
inline constexpr double coordinate_ulps = 1e-15;

/// The plane through points when they are coplanar within rounding: |height| ≤ 1e-12 size + 1e-15 |coordinates|.
template <int D>
[[nodiscard]] FlatPatch<D> plane_of(std::span<const Vec<D>> points);

/// A mesh with its edges, the features of its boundary, and the facets around each edge.
template <int D>
struct MeshBoundary {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    const Incidence<FacetId>& shells;
};

/// The smooth sides of each vertex: a fan is a set of facets around one vertex that are connected across edges which
/// are not ridges. A vertex inside a patch has one, a vertex of a ridge one a side, even where both sides are one
/// patch. A fan is pointed where no plane is tangent to it: at a corner, where a facet turns from the mean normal (by
/// angles) by more than 20°, or between two ridges by more than 40°. So are tips of cones, and their halves beside a
/// plane.
struct Fans {
    Column<std::array<std::uint32_t, 3>> of_facets;  ///< the fan of each corner of each facet
    Incidence<FacetId> facets;                       ///< of each fan
    Column<VertexId> vertices;                       ///< of each fan: its vertex
    Column<std::array<FacetId, 3>> neighbours;       ///< across the edge opposite each corner unless that is a ridge
    Column<std::int8_t> signs;                       ///< ±1: facets of a patch times their signs look to one side
    Column<std::uint8_t> pointed;                    ///< of each fan: whether it is the tip of a cone, see below

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
};

[[nodiscard]] Outcome<Fans> find_fans(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                                      const Incidence<FacetId>& shells, const Execution& execution);

/// The fans near a fan on the same smooth side, nearest rings first, without the fan itself: `min_rings`, and more
/// until `enough` are found or `max_rings` walked. Facets that turn away from `normal` are not entered, and nothing is
/// reached through a pointed fan.
struct RingOptions {
    std::size_t enough = 18, most = 80;
    int min_rings = 2, max_rings = 4;
};
[[nodiscard]] std::vector<std::uint32_t> rings(const LinearMesh<3>& mesh, const Fans& fans, std::uint32_t fan,
                                               const Vec<3>& normal, const RingOptions& options);

/// Twice the facet's area times its unit normal, turned to the patch's side.
[[nodiscard]] Vec<3> area_vector(const LinearMesh<3>& mesh, const Fans& fans, FacetId f);

/// Where v stands in the facet; 0 when it does not.
[[nodiscard]] std::size_t corner_of(const SimplexVertices<2>& facet, VertexId v);

}  // namespace camber

/// What the boundary of a mesh is, and where it is doubtful what it ought to be.
export namespace camber {

/// A smooth piece.
struct PatchFacts {
    std::vector<Reference> references;             ///< rising
    std::size_t facets = 0, interface_facets = 0;  ///< those with elements on both sides
    double area = 0, size = 0;  ///< of the straight facets, 2D their length; the diagonal of their box
    bool is_flat = false;       ///< in one plane, 2D on one line, to 1e-12 of the size
};

/// A chain of ridge edges between corners (3D).
struct CurveFacts {
    std::size_t edges = 0;
    double length = 0;
    double min_turn = 0, largest_turn = 0;  ///< degrees between its two facets, of edges that have two
    std::vector<Reference> references;      ///< of the facets beside it, rising
};

/// Facets turn by 0 degrees where they are in one plane, and by 180 where they lie on each other.
enum class Suspicion : std::uint8_t {
    near_ridge,      ///< an edge (2D: a vertex) that turns by nearly as much as a ridge
    mild_ridge,      ///< a ridge by its angle alone that turns by little more than is asked for
    knife_edge,      ///< facets that nearly lie on each other
    tip,             ///< all facets of a vertex are steep to its normal: the tip of a cone
    spread_normals,  ///< some are
    turned_facet,    ///< a facet's own normal is far from those of its vertices
};
inline constexpr std::size_t suspicion_count = 6;
[[nodiscard]] constexpr auto words(Suspicion) {
    return words_of(Word{Suspicion::near_ridge, "near_ridge"}, Word{Suspicion::mild_ridge, "mild_ridge"},
                    Word{Suspicion::knife_edge, "knife_edge"}, Word{Suspicion::tip, "tip"},
                    Word{Suspicion::spread_normals, "spread_normals"},
                    Word{Suspicion::turned_facet, "normal_deviation"});
}

/// One such place.
template <int D>
struct Suspect {
    Suspicion what = Suspicion::near_ridge;
    double degrees = 0;  ///< of the turn, or of the farthest normal
    Vec<D> point;
    std::vector<VertexId> vertices;  ///< of the edge, the vertex or the facet
    std::vector<FacetId> facets;     ///< beside or around it
};

/// When a place is suspicious; angles in degrees.
struct InspectionLimits {
    double ridge_angle = 40;
    double near = 0.75;       ///< a turn from this share of the ridge angle up is near it, and up to 1/near beyond
    double knife_edge = 150;  ///< a turn from here up
    double normals = 40;      ///< a normal farther than this from that of its vertex
};

template <int D>
struct BoundaryInspection {
    std::vector<PatchFacts> patches;  ///< by their numbers in Features
    std::vector<CurveFacts> curves;   ///< 3D
    std::vector<VertexId> corners;
    std::size_t smooth_listed_edges = 0;  ///< edges that the file lists and that are no ridges (3D)
    std::size_t interface_facets = 0;     ///< with elements on both sides
    std::size_t lone_facets = 0;          ///< with none, where there are elements
    /// Edges (2D: vertices, twice the same) of one facet, of more than two, and where two facets are turned to
    /// different sides, with these.
    std::vector<std::array<VertexId, 2>> open, crowded;
    struct Turned {
        std::array<VertexId, 2> edge;
        std::array<FacetId, 2> facets;
    };
    std::vector<Turned> turned;
    std::vector<Suspect<D>> suspects;  ///< the worst of a kind first
};

/// Errors: `edges` or `features` are not of this mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<BoundaryInspection<D>> inspect_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              const Features<D>& features,
                                                              const InspectionLimits& limits,
                                                              const Execution& execution);

}  // namespace camber
