module;
#include <array>
#include <cmath>
#include <cstddef>
export module camber.metric:unit_mesh;
import camber.core;
import :spd;

/// How near to unit the edges and elements of a straight mesh are, in a metric that is known at its vertices.
export namespace camber {

/// A metric ready to measure with: M = rowsᵀ rows, rows sqrt(λ_i) r_iᵀ, so that lengths keep their digits at any
/// anisotropy (see SpectralMetric).
template <int D>
struct MeasuringMetric {
    std::array<Vec<D>, D> rows{};
    double density = 0;  ///< sqrt(det M): volume in the metric by volume

    MeasuringMetric() = default;
    explicit MeasuringMetric(const LogMetric<D>& log_metric) {
        const EigenSystem<D> e = eigen_system(log_metric.l);
        double trace = 0;
        for (int i = 0; i < D; ++i) {
            rows[i] = std::exp(e.values[i] / 2) * e.vectors.column[i];
            trace += e.values[i];
        }
        density = std::exp(trace / 2);
    }
    /// vᵀ M v.
    [[nodiscard]] double length_squared(const Vec<D>& v) const {
        double sum = 0;
        for (const Vec<D>& row : rows) {
            const double w = dot(row, v);
            sum += w * w;
        }
        return sum;
    }
    friend bool operator==(const MeasuringMetric&, const MeasuringMetric&) = default;
};

/// The length of a straight edge whose ends have lengths a and b of it: ∫ a^(1−t) b^t dt = (a − b)/ln(a/b), sizes
/// between the ends being geometric means (Alauzet).
[[nodiscard]] inline double logarithmic_mean(double a, double b) {
    const double sum = a + b;
    const double d = (a - b) / sum;
    // (a + b)/2 · d/artanh d, with its series where that cancels.
    if (std::abs(d) < 1e-3) return sum / 2 * (1 - d * d / 3);
    return (a - b) / std::log(a / b);
}
template <int D>
[[nodiscard]] double edge_length(const MeasuringMetric<D>& from, const MeasuringMetric<D>& to, const Vec<D>& edge) {
    return logarithmic_mean(std::sqrt(from.length_squared(edge)), std::sqrt(to.length_squared(edge)));
}

/// Mean ratio in the metric, with the sign of the volume: 12 (3V)^(2/3) / Σ l², in 2D 4 √3 A / Σ l²; 1 for the regular
/// simplex. V is the volume by the geometric mean of the vertices' densities, l² of an edge the mean of its ends'; in a
/// constant metric both are exact.
template <int D>
[[nodiscard]] double metric_quality(const std::array<Vec<D>, D + 1>& corners,
                                    const std::array<const MeasuringMetric<D>*, D + 1>& metrics) {
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = corners[i + 1] - corners[0];
    double density = 1;
    for (const auto* m : metrics) density *= m->density;
    double squares = 0;
    for (const auto& [a, b] : local_edges<D>) {
        const Vec<D> edge = corners[b] - corners[a];
        squares += metrics[a]->length_squared(edge) + metrics[b]->length_squared(edge);
    }
    squares /= 2;
    if (!(squares > 0)) return 0;
    if constexpr (D == 2) {
        const double area = det(sides) / 2 * std::cbrt(density);
        return 4 * std::sqrt(3.0) * area / squares;
    } else {
        const double volume = det(sides) / 6 * std::sqrt(std::sqrt(density));
        const double root = std::cbrt(3 * std::abs(volume));
        return std::copysign(12 * root * root / squares, volume);
    }
}

}  // namespace camber
