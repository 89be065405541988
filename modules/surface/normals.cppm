module;
#include <cstddef>
#include <span>
export module camber.surface:normals;
import camber.core;
import :features;
import :fans;
import :flat;
import :jet;
import :tangents;

namespace camber {

/// What is known of the surface at each fan: the unit normal (turned to the patch's side) and the jet, of degree 0 on planes
/// and where there are too few points.
struct FanShapes {
    Column<Vec<3>> normals;
    Column<Jet> jets;
};

/// A flat patch gives its plane's normal, a locally flat fan its own plane's; else the jet's, else the area-weighted one. The
/// file's normals take precedence where they agree with the area-weighted one within `most_degrees`. At a ridge the normal is
/// made perpendicular to the ridge's tangents, which are known better (order 4).
[[nodiscard]] Outcome<FanShapes> fan_shapes(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                            const Features<3>& features, const Fans& fans,
                                            std::span<const FlatPatch<3>> flats, const CurveTangents<3>& tangents,
                                            double most_degrees, const Execution& execution);

}  // namespace camber
