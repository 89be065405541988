module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.surface:fans;
import camber.core;
import :features;

namespace camber {

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
