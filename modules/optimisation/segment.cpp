module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
module camber.optimisation;

namespace camber {

namespace {

double slope(const AffineConstraint& c) { return c.at_1 - c.at_0; }
double excess(const AffineConstraint& c, double theta) { return (c.at_0 - c.floor) + theta * slope(c); }

const AffineConstraint& lowest(std::span<const AffineConstraint> constraints, double theta) {
    return *std::min_element(constraints.begin(), constraints.end(),
                             [&](const auto& a, const auto& b) { return excess(a, theta) < excess(b, theta); });
}

}  // namespace

std::optional<SegmentInterval> feasible(std::span<const AffineConstraint> constraints) {
    SegmentInterval interval;
    for (const AffineConstraint& c : constraints) {
        const double s = slope(c);
        const double start = c.at_0 - c.floor;
        const double end = c.at_1 - c.floor;
        if (!(start >= 0 || end >= 0)) return {};
        // The ends are judged by their own values, so that rounding of the crossing cannot cut them off.
        if (start < 0) interval.low = std::max(interval.low, -start / s);
        if (end < 0) interval.high = std::min(interval.high, -start / s);
    }
    if (!(interval.low <= interval.high)) return {};
    return interval;
}

double highest_minimum(std::span<const AffineConstraint> constraints, SegmentInterval within) {
    if (constraints.empty()) return within.high;
    // The top lies where a rising and a falling line cross: cutting with the lowest line at each crossing found so far.
    const AffineConstraint* rising = &lowest(constraints, within.low);
    const AffineConstraint* falling = &lowest(constraints, within.high);
    if (slope(*falling) >= 0) return within.high;
    if (slope(*rising) <= 0) return within.low;
    double theta = within.low;
    for (std::size_t i = 0; i <= constraints.size(); ++i) {
        theta = (excess(*rising, 0) - excess(*falling, 0)) / (slope(*falling) - slope(*rising));
        theta = std::clamp(theta, within.low, within.high);
        const AffineConstraint& next = lowest(constraints, theta);
        if (excess(next, theta) >= excess(*rising, theta) || &next == rising || &next == falling) break;
        (slope(next) > 0 ? rising : falling) = &next;
    }
    return theta;
}

}  // namespace camber
