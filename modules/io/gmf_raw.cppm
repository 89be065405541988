module;
#include <cstddef>
module camber.io:gmf_raw;
import camber.core;
import :any_mesh;
import :gmf_file;
import :listing;

namespace camber::gmf {

/// What the file lists, checked: every vertex exists and none occurs twice in a simplex. The file must outlive it: its
/// messages quote it.
template <int D>
[[nodiscard]] Outcome<listing::Mesh<D>> read_raw(const File& file, const Execution& execution);

/// Normals, tangents, and places on CAD entities, of a file with so many vertices.
template <int D>
[[nodiscard]] Outcome<GivenGeometry<D>> read_geometry(const File& file, std::size_t vertices,
                                                      const Execution& execution);

}  // namespace camber::gmf
