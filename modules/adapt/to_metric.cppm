module;
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
export module camber.adapt:to_metric;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import :passes;

export namespace camber {

/// Rounds of collapse, split, swap and smooth; bad elements are mended at last. In all rounds but the last a collapse
/// may make edges that are longer than its options say: the split behind halves them, and where none may be longer than
/// √2 most short edges would stay. And splits leave edges somewhat longer than their options say: of those in between
/// most come to be shorter by what goes on around them, and halves of them would make the mean length less than 1. Nor
/// do splits make edges there that a collapse would have to remove.
struct ToMetricOptions {
    double loose_longest = 2;
    double loose_split = 1.55;
    double loose_shortest = 0.7;
    CollapseOptions collapse = {};
    SplitOptions split = {};
    SwapOptions swap = {};
    SmoothOptions smooth = {};
    MendOptions mend = {};
    int rounds = 4;
    double min_change = 0.002;

    [[nodiscard]] static constexpr auto options() {
        using S = ToMetricOptions;
        return std::tuple(
            option("loose_longest", &S::loose_longest,
                   "the longest edges that collapses may make in all rounds but the last, if collapse/longest is less")
                .unit("lengths in the metric")
                .at_least(0),
            option("loose_split", &S::loose_split,
                   "the longest edges that splits leave in all rounds but the last, if split/longest is less")
                .unit("lengths in the metric")
                .at_least(0),
            option("loose_shortest", &S::loose_shortest,
                   "the shortest edges that splits make in all rounds but the last, if split/shortest is less")
                .unit("lengths in the metric")
                .at_least(0),
            option("collapse", &S::collapse, "the options of the stage collapse"),
            option("split", &S::split, "the options of the stage split"),
            option("swap", &S::swap, "the options of the stage swap"),
            option("smooth", &S::smooth, "the options of the stage smooth"),
            option("mend", &S::mend, "the options of the stage mend, which comes last"),
            option("rounds", &S::rounds, "rounds of collapse, split, swap and smooth").at_least(0).at_most(1000),
            option("min_change", &S::min_change,
                   "ends where a round raises the share of unit edges by less and makes or removes a smaller share of "
                   "vertices")
                .at_least(0)
                .at_most(1));
    }
    friend bool operator==(const ToMetricOptions&, const ToMetricOptions&) = default;
};

/// What each kind of pass did, in all rounds.
struct ToMetricStatistics {
    int rounds = 0;
    PassStatistics collapse, split, swap, smooth, mend;
    UnitMeshStatistics before, after;
};

template <int D>
struct BroughtToMetric {
    Adaptation<D> state;
    ToMetricStatistics statistics;
};

/// A mesh brought to a metric, of degree 1. Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                          const ToMetricOptions& options, const Around& around);
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                          const ToMetricOptions& options, const Execution& execution) {
    return bring_to_metric(std::move(state), goal, options, plainly(execution));
}

/// Means by which bounds on distances are met: any; or as far as the mesh stays near to the metric, where edges are
/// halved once, and no element becomes worse than a fifth of the best quality.
enum class BoundaryEffort : std::uint8_t { any, near_metric };

/// Refines the boundary until every facet keeps the goal's `distance_bounds`, in rounds of splits and swaps of far
/// facets; swap, smooth and mend follow and keep the bounds. Ends early where a round changes nothing, or after
/// `max_bound_rounds`. `statistics` has no lengths. Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_within_bounds(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                              const ToMetricOptions& options, BoundaryEffort effort,
                                                              const Around& around);
inline constexpr int max_bound_rounds = 8;

/// Number of facets that exceed the goal's bounds, by `bound_shares`. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> count_far_facets(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                    const Execution& execution);

}  // namespace camber
