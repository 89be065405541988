module;
#include <cstddef>
export module camber.adapt:near_surfaces;
import camber.core;
import camber.cavity;
import camber.operation;
import :to_metric;

export namespace camber {

/// Refines the boundary until every facet keeps the goal's `distance_bounds`, in rounds of splits and swaps of far
/// facets; swap, smooth and mend follow and keep the bounds. Ends early where a round changes nothing, or after
/// `max_bound_rounds`. `statistics` has no lengths. Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_within_bounds(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                              const ToMetricOptions& options, const Around& around);
inline constexpr int max_bound_rounds = 8;

/// Number of facets that exceed the goal's bounds, by `bound_shares`. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> count_far_facets(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                    const Execution& execution);

}  // namespace camber
