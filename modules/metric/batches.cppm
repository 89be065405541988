module;
#include <array>
#include <span>
export module camber.metric:batches;
import camber.core;
import :spd;

/// Closed forms for many points or elements at a time, in packs (core:pack). Spans are of one size; each item has the
/// same bytes in any company and with any instructions.
export namespace camber {

/// sqrt(vᵀ M v) of each vector in its own metric.
template <int D>
void metric_norms(std::span<const LogMetric<D>> metrics, std::span<const Vec<D>> vectors, std::span<double> norms,
                  Instructions set = widest_instructions());

/// natural_log_metric of each simplex.
template <int D>
void natural_log_metrics(std::span<const std::array<Vec<D>, D + 1>> simplices, std::span<LogMetric<D>> metrics,
                         Instructions set = widest_instructions());

/// A metric as it is seen through a map: from the map's domain.
template <int D>
struct SeenMetric {
    LogMetric<D> log_metric;           ///< log M̂, M̂ = Fᵀ M F
    Mat<D> axes = Mat<D>::identity();  ///< O = M^{1/2} F M̂^{-1/2}, orthogonal: M̂'s frame to M's
    friend bool operator==(const SeenMetric&, const SeenMetric&) = default;
};
/// Each metric through its Jacobian F; M itself through one that is singular. By singular values, so that needles keep
/// their digits.
template <int D>
void see_through(std::span<const LogMetric<D>> metrics, std::span<const Mat<D>> jacobians,
                 std::span<SeenMetric<D>> seen, Instructions set = widest_instructions());

}  // namespace camber
