module;
#include <cstddef>
#include <vector>
module camber.io:gmf_raw;
import camber.core;
import :any_mesh;
import :gmf_file;
import :listing;
import :notice;

namespace camber::gmf {

/// What the file lists, checked: every vertex exists and none occurs twice in a simplex. The file must outlive it: its
/// messages quote it.
template <int D>
[[nodiscard]] Outcome<listing::Mesh<D>> read_raw(const File& file, std::vector<Notice>& notices,
                                                 const Execution& execution);

/// What a file of one degree says beside its rows.
template <int D, int Degree>
[[nodiscard]] Outcome<LinearMesh<D>> read_lists(const File& file);

/// Normals, tangents, and places on CAD entities, of a file with so many vertices. Normals or tangents that are not
/// right (an index without its vertex or direction, a direction without a length) are left out as a whole, with a
/// notice: the others may be wrong as well.
template <int D>
[[nodiscard]] Outcome<GivenGeometry<D>> read_geometry(const File& file, std::size_t vertices,
                                                      std::vector<Notice>& notices, const Execution& execution);

}  // namespace camber::gmf
