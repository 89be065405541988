module;
#include <algorithm>
#include <array>
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

/// The distances of a facet from its surface, at its edges and at its middle, as shares of the goal's bound for it
/// (`distance_bounds`): above 1 the facet is too far. Of degree 2 an edge is sampled at two points, where the error of
/// a parabola is largest. 0 where the facet has no surface or no bound.
template <int D>
struct BoundShares {
    std::array<double, edges_per_simplex<D - 1>> edges{};  ///< in the order of local_edges
    double middle = 0;

    [[nodiscard]] double largest() const { return std::max(middle, *std::ranges::max_element(edges)); }
};
template <int D>
[[nodiscard]] BoundShares<D> bound_shares(const Adaptation<D>& r, const AdaptationGoal<D>& goal, FacetId f);

/// The edge of a facet that its shares have at this place; the facet has an element.
template <int D>
[[nodiscard]] EdgeId local_facet_edge(const DynamicMesh<D>& mesh, FacetId f, int e);

/// Whether the new facets of a patch keep the goal's bounds, or exceed them by no more than those that it removes.
template <int D>
[[nodiscard]] bool keeps_distance_bounds(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch);

}  // namespace camber
