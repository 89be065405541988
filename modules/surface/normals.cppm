module;
#include <cstddef>
#include <span>
export module camber.surface:normals;
import camber.core;
import :features;
import :fans;
import :flat;
import :tangents;

namespace camber {

/// The unit normal of each fan, turned to the patch's side; the zero vector of a pointed one. A flat patch gives its
/// plane's, a locally flat fan its own plane's; else that of the jet through the rings around (error O(h⁴), O(h³),
/// O(h²) by its degree), else the area-weighted one. The file's normals take precedence where they agree with the
/// area-weighted one within `most_degrees`. At a ridge the normal is made perpendicular to the ridge's tangents, which
/// are known better. Errors: stopped.
[[nodiscard]] Outcome<Buffer<Vec<3>>> fan_normals(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                  const Features<3>& features, const Fans& fans,
                                                  std::span<const FlatPatch<3>> flats, const CurveTangents<3>& tangents,
                                                  double most_degrees, const Execution& execution);

}  // namespace camber
