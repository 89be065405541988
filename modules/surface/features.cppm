module;
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>
export module camber.surface:features;
import camber.core;

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

}  // namespace camber
