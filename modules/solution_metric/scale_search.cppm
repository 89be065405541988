module;
#include <algorithm>
#include <cmath>
#include <limits>
module camber.solution_metric:scale_search;
import camber.core;

namespace camber {

/// Where a search for a complexity ended.
struct ScaleFound {
    double at = 0, log_complexity = 0;
    int evaluations = 0;
    bool reached = false;
};

/// t with evaluate(t) = target, for a function that rises, with about `slope` where nothing bounds it: the secant,
/// within what is known to be too little and too much, by halves where it would leave that. Begins at `from`. Errors:
/// those of `evaluate`, an Outcome<double>.
[[nodiscard]] Outcome<ScaleFound> search_scale(double from, double target, double slope, double tolerance,
                                               int most_evaluations, const auto& evaluate) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double low = -infinity, high = infinity, at = from, before = 0, value_before = 0;
    ScaleFound best;
    double best_miss = infinity;
    for (int i = 1; i <= most_evaluations; ++i) {
        const auto value = evaluate(at);
        if (!value) return fail(value.error());
        const double miss = *value - target;
        if (std::abs(miss) < best_miss) {
            best_miss = std::abs(miss);
            best = {at, *value, i, false};
        }
        best.evaluations = i;
        if (std::abs(miss) <= tolerance) {
            best.reached = true;
            return best;
        }
        (miss < 0 ? low : high) = at;
        // A slope of next to nothing, where all is at its bounds, would lead far off.
        double steepness = i == 1 ? slope : (*value - value_before) / (at - before);
        if (!(steepness > 0.05 * slope)) steepness = std::max(0.25 * slope, 1e-6);
        before = at;
        value_before = *value;
        at -= miss / std::min(steepness, 4 * slope);
        if (!(at > low && at < high)) at = std::isfinite(low) && std::isfinite(high) ? (low + high) / 2 : before - miss;
    }
    return best;
}

}  // namespace camber
