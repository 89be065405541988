module;
#include <cstddef>
#include <tuple>
export module camber.remesh:to_metric;
import camber.core;
import camber.metric;
import camber.dynamic;
import :measures;
import :passes;
import :rounds;
import :state;

export namespace camber {

/// Rounds of collapse, split, swap and smooth.
struct ToMetricOptions {
    CollapseOptions collapse = {};
    SplitOptions split = {};
    SwapOptions swap = {};
    SmoothOptions smooth = {};
    int rounds = 6;
    double least_change = 0.002;

    [[nodiscard]] static constexpr auto options() {
        using S = ToMetricOptions;
        return std::tuple(
            option("rounds", &S::rounds, "rounds of collapse, split, swap and smooth").at_least(0).at_most(1000),
            option("least_change", &S::least_change,
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
    PassStatistics collapse, split, swap, smooth;
    UnitMeshStatistics before, after;
};

template <int D>
struct BroughtToMetric {
    Remeshing<D> state;
    ToMetricStatistics statistics;
};

/// A mesh brought to a metric, of degree 1. Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_to_metric(Remeshing<D> state, const RemeshingGoal<D>& goal,
                                                          const ToMetricOptions& options, const Execution& execution);

}  // namespace camber
