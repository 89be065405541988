module;
#include <cstddef>
#include <cstdint>
#include <span>
module camber.surface:normals;
import camber.core;
import :features;
import :fans;
import :flat;
import :junctions;
import :tangents;

namespace camber {

struct FanNormals {
    Column<Vec<3>> normals;           ///< one a fan: unit, or zero
    Column<std::uint8_t> prescribed;  ///< one a fan: whether its normal is that of the surface beyond a junction
};

/// The unit normal of each fan, turned to the patch's side; the zero vector of a pointed one. A flat patch gives its
/// plane's, a locally flat fan its own plane's; else that of the jet through the rings around (error O(h⁴), O(h³),
/// O(h²) by its degree), else the area-weighted one. The file's normals take precedence where they agree with the
/// area-weighted one within `max_degrees`. At a ridge the normal is made perpendicular to the ridge's tangents, which
/// are known better. At a junction that the boundary passes smoothly it is the prescribed surface's. Errors: stopped.
[[nodiscard]] Outcome<FanNormals> fan_normals(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                              const Features<3>& features, const Incidence<FacetId>& shells,
                                              const Fans& fans, std::span<const FlatPatch<3>> flats,
                                              const CurveTangents<3>& tangents, const Junctions<3>& junctions,
                                              double max_degrees, const Execution& execution);

}  // namespace camber
