module;
#include <cstdint>
#include <vector>
module camber.interpolation:volumes;
import camber.core;
import :error;

namespace camber {

/// What the straight mesh and the curved one cover. Needs the curved one's elements that are not straight.
template <int D>
[[nodiscard]] Volumes volumes_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent);

}  // namespace camber
