module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>
module camber.interpolation:straight_inside;
import camber.core;

namespace camber {

/// Elements of which a node is not exactly in the middle of its edge, by rising number.
template <int D>
[[nodiscard]] std::vector<std::uint32_t> bent_elements(const QuadraticMesh<D>& mesh);

/// Every node exactly in the middle of its edge.
template <int D>
[[nodiscard]] bool is_straight(const QuadraticMesh<D>& mesh, std::size_t e);

/// The mesh with straight edges wherever its boundary and its interfaces allow it: the edges of their facets keep
/// their nodes where the facet is not flat, all others go straight. In a flat facet a bent edge moves no boundary, so
/// it counts as an inner one. None where all of those facets are flat: the straight mesh has the same boundary then.
/// Needs the mesh's bent elements.
template <int D>
[[nodiscard]] std::optional<QuadraticMesh<D>> straight_inside(const QuadraticMesh<D>& mesh,
                                                              const std::vector<std::uint32_t>& bent);

}  // namespace camber
