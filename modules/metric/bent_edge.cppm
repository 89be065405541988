module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
export module camber.metric:bent_edge;
import camber.core;
import :spd;
import :unit_mesh;

export namespace camber {

/// A metric at an end of an edge, as it is given and ready to measure with.
template <int D>
struct BentEnd {
    const LogMetric<D>& log_metric;
    const MeasuringMetric<D>& measure;
};

/// The mean of two metrics whose axes may be turned against each other by an angle α: axes of the mean of both logs,
/// and of the log sizes the mean of both in their order. The mean of the logs alone damps unlike axes by cos α. Where
/// that is much (α above 0.6, or axes that are nearly alike and have no order), it is the mean of the logs again.
template <int D>
[[nodiscard]] EigenSystem<D> frame_mean(const LogMetric<D>& a, const Vec<D>& log_sizes_a, const LogMetric<D>& b,
                                        const Vec<D>& log_sizes_b) {
    EigenSystem<D> e = eigen_system(0.5 * (a.l + b.l));
    const auto unlikeness = [](const Vec<D>& sizes) {
        double sum = 0, squares = 0;
        for (const double x : sizes.c) sum += x, squares += x * x;
        return std::sqrt(std::max(squares - sum * sum / D, 0.0));
    };
    const double most = (unlikeness(log_sizes_a) + unlikeness(log_sizes_b)) / 2;
    if (!(most > 0)) return e;
    const double share = std::clamp((unlikeness(e.values) / most - 0.5) / 0.3, 0.0, 1.0);
    std::array<int, D> order{};
    for (int i = 0; i < D; ++i) order[i] = i;
    std::ranges::sort(order, {}, [&](int i) { return e.values[i]; });
    for (int i = 0; i < D; ++i)
        e.values[order[i]] += share * ((log_sizes_a[i] + log_sizes_b[i]) / 2 - e.values[order[i]]);
    return e;
}

/// The length of an edge of degree 2 whose node is `offset` from the middle of its chord, in a metric that is known at
/// its ends, where its axes may be turned against each other: by the speeds l_a = |e + 4d|_a, l_b = |e − 4d|_b at the
/// ends and l_m = |e|_m in the middle,
///
///   (l_a − l_b)/ln(l_a/l_b) + ⅔ (l_m − sqrt(l_a l_b)).
///
/// The first part is the length of a straight edge along common axes, for which l_m = sqrt(l_a l_b); the second what
/// Simpson's rule makes of a middle that is another.
template <int D>
[[nodiscard]] double bent_length(const BentEnd<D>& a, const BentEnd<D>& b, const Vec<D>& chord, const Vec<D>& offset) {
    const double l_a = std::sqrt(a.measure.length_squared(chord + 4.0 * offset));
    const double l_b = std::sqrt(b.measure.length_squared(chord - 4.0 * offset));
    const EigenSystem<D> middle = frame_mean(a.log_metric, a.measure.log_sizes, b.log_metric, b.measure.log_sizes);
    double l_m = 0;
    for (int i = 0; i < D; ++i) {
        const double along = dot(middle.vectors.column[i], chord);
        l_m += exp(middle.values[i]) * along * along;
    }
    l_m = std::sqrt(l_m);
    return logarithmic_mean(l_a, l_b) + 2.0 / 3.0 * (l_m - std::sqrt(l_a * l_b));
}

}  // namespace camber
