module;
#include <cstddef>
export module camber.remesh:near_geometry;
import camber.core;
import camber.dynamic;
import camber.surface;
import :state;

export namespace camber {

/// Whether each new facet is near the geometry: at its middle and those of its edges no farther from its surface than
/// this share of its longest edge, or than the facets that the patch removes were of theirs. So where there is no
/// geometry.
template <int D>
[[nodiscard]] bool is_near_geometry(const Remeshing<D>& r, const RemeshingGoal<D>& goal, const TopologyPatch<D>& patch,
                                    double share);

}  // namespace camber
