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

template <int D>
struct FeatureOptions {
    double ridge_angle_degrees = 40;  ///< in 2D, larger turns make a vertex a corner
    /// Larger turns of a ridge curve (degrees) make a vertex a corner (3D).
    double corner_angle_degrees = 40;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("ridge_angle", &FeatureOptions::ridge_angle_degrees,
                                 "an edge at which facets meet at more than this angle is a ridge")
                              .unit("degrees")
                              .above(0)
                              .at_most(180));
    }
};

/// Ridge curves pass through ridge vertices and break at corners. In 2D boundary vertices are `surface` or `corner`.
enum class VertexKind : std::uint8_t { volume, surface, ridge, corner };

inline constexpr std::uint32_t no_feature = 0xffffffffU;

/// Features of a mesh's boundary, including interfaces between materials.
///
/// 3D. Ridges are edges of facets in any of these cases:
/// - The file lists the edge among `ridges`.
/// - It does not have exactly two facets.
/// - Its facets have different references.
/// - Its facets turn by more than the ridge angle. At an edge that is not listed, a turn below 1.5 times this angle
///   does not count if a facet has three such edges, or if the edge meets no other ridge.
///
/// Other listed edges are of kind `surface`. Corners are vertices in any of these cases:
/// - The file lists the vertex.
/// - It has ridges, but not exactly two, or its two ridges turn by more than the corner angle.
/// - It has no ridge and is the tip of a cone. All its edges deviate from the plane perpendicular to their mean
///   direction by more than the ridge angle, to the same side.
/// - Surfaces touch there, as at the end of a baffle's rim on a wall. Some sheet (facets connected across edges other
///   than ridges) is then not bounded by both ridges, or there are several sheets and no ridge.
///
/// Patches are sets of facets connected across edges other than ridges. Curves are chains of ridges between corners.
///
/// 2D. Facets are edges of kind `surface`. Corners are vertices in any of these cases:
/// - The file lists the vertex, or one of its facets among `ridges`.
/// - It does not have exactly two facets, or their references differ, or they turn by more than the ridge angle.
///
/// Patches and curves are the chains of facets between corners.
template <int D>
struct Features {
    Column<EdgeKind> edge_kinds;      ///< one per unique edge
    Column<VertexKind> vertex_kinds;  ///< one per vertex
    Column<std::uint32_t> patches;    ///< one per facet, from 0
    Column<std::uint32_t> curves;     ///< one per unique edge, from 0; or `no_feature`
    std::size_t patch_count = 0, curve_count = 0;
    std::size_t surface_edges = 0, ridge_edges = 0, corners = 0;

    friend bool operator==(const Features&, const Features&) = default;
};

template <int D>
[[nodiscard]] inline std::vector<VertexId> corners_of(const Features<D>& features) {
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < features.vertex_kinds.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    return corners;
}

/// Errors: `edges` of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Features<D>> find_features(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const FeatureOptions<D>& options, const Execution& execution);

/// Plane (2D: line) of a patch; `normal` is zero if the patch is curved.
template <int D>
struct FlatPatch {
    Vec<D> point, normal;
    double tolerance = 0;  ///< points nearer to the plane are on it
    int axis = -1;         ///< axis of an exactly axis-aligned normal, or −1

    [[nodiscard]] inline bool is_flat() const { return norm_squared(normal) > 0; }
    /// Signed distance from the plane; 0 within the tolerance.
    [[nodiscard]] inline double height(const Vec<D>& p) const {
        const double h = axis >= 0 ? p[static_cast<std::size_t>(axis)] - point[static_cast<std::size_t>(axis)]
                                   : dot(p - point, normal);
        return std::fabs(h) <= tolerance ? 0 : h;
    }
    /// Closest point of the plane; exact for normals along an axis.
    [[nodiscard]] inline Vec<D> snapped(Vec<D> p) const {
        if (axis < 0) return p - dot(p - point, normal) * normal;
        p[static_cast<std::size_t>(axis)] = point[static_cast<std::size_t>(axis)];
        return p;
    }
    friend bool operator==(const FlatPatch&, const FlatPatch&) = default;
};

/// Finds the plane of each patch. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                                         const Execution& execution);

}  // namespace camber

namespace camber {

/// Distances below this share of a point set's size count as zero, because coordinates have errors of a few ulps.
inline constexpr double flat_tolerance = 1e-12;
inline constexpr double coordinate_ulps = 1e-15;

/// Plane through points that are coplanar within rounding: |height| ≤ 1e-12 size + 1e-15 |coordinates|.
template <int D>
[[nodiscard]] FlatPatch<D> plane_of(std::span<const Vec<D>> points);

template <int D>
struct MeshBoundary {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    const Incidence<FacetId>& shells;
};

/// Fans of the boundary at its vertices. A fan is a set of facets around a vertex that are connected across edges other
/// than ridges. A vertex inside a patch has one fan. A ridge vertex has one fan per side, even within one patch. A fan
/// is pointed if it has no tangent plane, as at a cone's tip. The normal of some facet then deviates from the fan's
/// angle-weighted mean normal by more than 20° (between two ridges 40°).
struct Fans {
    Column<std::array<std::uint32_t, 3>> of_facets;  ///< fan of each facet corner
    Incidence<FacetId> facets;
    Column<VertexId> vertices;
    Column<std::array<FacetId, 3>> neighbours;  ///< facets across the edge opposite each corner; invalid at ridges
    Column<std::int8_t> signs;                  ///< ±1: orientation relative to the patch
    Column<std::uint8_t> pointed;               ///< one per fan; 1: no tangent plane

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
};

[[nodiscard]] Outcome<Fans> find_fans(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                                      const Incidence<FacetId>& shells, const Execution& execution);

/// Limits of a search for fans around a fan, ring by ring. The search takes at least `min_rings` rings, then up to
/// `max_rings` until `enough` fans are found. It does not enter facets that turn away from `normal`, nor pass through
/// pointed fans.
struct RingOptions {
    std::size_t enough = 18, most = 80;
    int min_rings = 2, max_rings = 4;
};
[[nodiscard]] std::vector<std::uint32_t> rings(const LinearMesh<3>& mesh, const Fans& fans, std::uint32_t fan,
                                               const Vec<3>& normal, const RingOptions& options);

/// Twice the facet's area times its unit normal, oriented like its patch.
[[nodiscard]] Vec<3> area_vector(const LinearMesh<3>& mesh, const Fans& fans, FacetId f);

/// Index of v in the facet; 0 if absent.
[[nodiscard]] std::size_t corner_of(const SimplexVertices<2>& facet, VertexId v);

}  // namespace camber

export namespace camber {

struct PatchFacts {
    std::vector<Reference> references;             ///< ascending
    std::size_t facets = 0, interface_facets = 0;  ///< interface facets have elements on both sides
    double area = 0, size = 0;                     ///< area of the straight facets; diagonal of their box
    bool is_flat = false;                          ///< planar (2D: straight) to 1e-12 of the size
};

struct CurveFacts {
    std::size_t edges = 0;
    double length = 0;
    double min_turn = 0, largest_turn = 0;  ///< degrees, over edges with two facets
    std::vector<Reference> references;      ///< of adjacent facets, ascending
};

/// Kind of a suspicious place. Coplanar facets turn by 0, folded facets by 180 degrees.
enum class GeometryWarning : std::uint8_t {
    near_ridge,      ///< an edge (2D: vertex) that turns slightly less than a ridge
    mild_ridge,      ///< a ridge by angle alone, slightly above the limit
    knife_edge,      ///< facets nearly folded onto each other
    tip,             ///< cone tip: the normals of all facets are far from the vertex normal
    spread_normals,  ///< the normals of some facets are far from the vertex normal
    turned_facet,    ///< the facet's normal is far from the normals of its vertices
};
inline constexpr std::size_t geometry_warning_count = 6;
[[nodiscard]] constexpr auto words(GeometryWarning) {
    return words_of(Word{GeometryWarning::near_ridge, "near_ridge"}, Word{GeometryWarning::mild_ridge, "mild_ridge"},
                    Word{GeometryWarning::knife_edge, "knife_edge"}, Word{GeometryWarning::tip, "tip"},
                    Word{GeometryWarning::spread_normals, "spread_normals"},
                    Word{GeometryWarning::turned_facet, "normal_deviation"});
}

template <int D>
struct LocatedWarning {
    GeometryWarning what = GeometryWarning::near_ridge;
    double degrees = 0;  ///< turn, or deviation of the normal
    Vec<D> point;
    std::vector<VertexId> vertices;
    std::vector<FacetId> facets;
};

/// Limits in degrees.
struct InspectionLimits {
    double ridge_angle = 40;
    double near = 0.75;       ///< edges that turn by `near` to 1/`near` times the ridge angle are reported as near this
                              ///< angle
    double knife_edge = 150;  ///< smallest turn of a knife edge
    double normals = 40;      ///< largest accepted angle between facet normal and vertex normal
};

template <int D>
struct BoundaryInspection {
    std::vector<PatchFacts> patches;  ///< numbered as in Features
    std::vector<CurveFacts> curves;   ///< 3D
    std::vector<VertexId> corners;
    std::size_t smooth_listed_edges = 0;  ///< listed edges other than ridges (3D)
    std::size_t interface_facets = 0;     ///< facets with elements on both sides
    std::size_t isolated_facets = 0;      ///< facets without elements, if the mesh has elements
    /// Ends of edges (2D: a vertex, twice). `open`: edges with one facet; `crowded`: with more than two; `turned`: with
    /// two facets of opposite orientation.
    std::vector<std::array<VertexId, 2>> open, crowded;
    struct Turned {
        std::array<VertexId, 2> edge;
        std::array<FacetId, 2> facets;
    };
    std::vector<Turned> turned;
    std::vector<LocatedWarning<D>> located_warnings;  ///< the worst of each kind first
};

/// Errors: `edges` or `features` of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<BoundaryInspection<D>> inspect_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              const Features<D>& features,
                                                              const InspectionLimits& limits,
                                                              const Execution& execution);

}  // namespace camber
