module;
#include <cstddef>
export module camber.operation:near_geometry;
import camber.core;
import camber.cavity;
import camber.surface;
import :state;

export namespace camber {

/// How far facets are from the geometry, as the largest share of the longest edge of one: at its middle and those of
/// its edges. `is_near`: none farther than it may be.
struct FacetDistance {
    double largest = 0;
    bool is_near = true;
};

/// Of the new facets of a patch, of which none may be farther than `share`, or than the facets that the patch removes
/// were of theirs; likewise its new edges on embedded lines from their curves. 0 where there is no geometry.
template <int D>
[[nodiscard]] FacetDistance distance_from_geometry(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                   const Patch<D>& patch, double share);

}  // namespace camber
