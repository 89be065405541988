module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
export module camber.metric:unit_mesh;
import camber.core;
import :spd;

/// How near to unit the edges and elements of a straight mesh are, in a metric that is known at its vertices.
export namespace camber {

/// The edges of a unit mesh are between 1/√2 and √2.
inline constexpr double shortest_unit_edge = 0.70710678118654752;
inline constexpr double longest_unit_edge = 1.4142135623730951;

/// A metric ready to measure with: M = rowsᵀ rows, rows sqrt(λ_i) r_iᵀ, so that lengths keep their digits at any
/// anisotropy (see SpectralMetric).
template <int D>
struct MeasuringMetric {
    std::array<Vec<D>, D> rows{};
    Vec<D> log_sizes;         ///< eigenvalues of log M, rising
    double density_root = 0;  ///< (sqrt(det M))^(1/(D + 1)): their product over an element is the volume's factor

    MeasuringMetric() = default;
    explicit MeasuringMetric(const LogMetric<D>& log_metric) {
        const EigenSystem<D> e = eigen_system(log_metric.l);
        double trace = 0;
        for (int i = 0; i < D; ++i) {
            rows[i] = exp(e.values[i] / 2) * e.vectors.column[i];
            trace += e.values[i];
        }
        density_root = exp(trace / (2 * (D + 1)));
        log_sizes = e.values;
        std::ranges::sort(log_sizes.c);
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
    if (!(sum > 0)) return 0;
    const double d = (a - b) / sum;
    // (a + b)/2 · d/artanh d, with its series where that cancels.
    if (std::abs(d) < 1e-3) return sum / 2 * (1 - d * d / 3);
    return (a - b) / log(a / b);
}
template <int D>
[[nodiscard]] double edge_length(const MeasuringMetric<D>& from, const MeasuringMetric<D>& to, const Vec<D>& edge) {
    return logarithmic_mean(std::sqrt(from.length_squared(edge)), std::sqrt(to.length_squared(edge)));
}

/// How far an element is from the regular simplex in the metric, with the sign of its volume: the power D/2 of
/// metric_quality, which needs no root of the volume: 36 √12 V/(Σ l²)^(3/2), in 2D 4 √3 A / Σ l². V is the volume by
/// the geometric mean of the vertices' densities, l² of an edge the mean of its ends'; in a constant metric both are
/// exact.
template <int D>
[[nodiscard]] double metric_shape(const std::array<Vec<D>, D + 1>& corners,
                                  const std::array<const MeasuringMetric<D>*, D + 1>& metrics) {
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = corners[i + 1] - corners[0];
    double density = 1;
    for (const auto* m : metrics) density *= m->density_root;
    double squares = 0;
    for (const auto& [a, b] : local_edges<D>) {
        const Vec<D> edge = corners[b] - corners[a];
        squares += metrics[a]->length_squared(edge) + metrics[b]->length_squared(edge);
    }
    squares /= 2;
    if (!(squares > 0)) return 0;
    const double measure = det(sides) * density;
    if constexpr (D == 2) return 2 * std::sqrt(3.0) * measure / squares;
    // 12 (3V)^(2/3) to the power 3/2, V a sixth of the determinant.
    return 6 * std::sqrt(12.0) * measure / (squares * std::sqrt(squares));
}

/// Mean ratio in the metric, with the sign of the volume: 12 (3V)^(2/3) / Σ l², in 2D 4 √3 A / Σ l²; 1 for the regular
/// simplex. See metric_shape.
[[nodiscard]] inline double quality_of_shape(double shape, int dimension) {
    return dimension == 2 ? shape : std::copysign(cbrt(shape * shape), shape);
}
[[nodiscard]] inline double shape_of_quality(double quality, int dimension) {
    return dimension == 2 ? quality : std::copysign(std::abs(quality) * std::sqrt(std::abs(quality)), quality);
}
/// Of a triangle in space, in the metric on its plane, as metric_shape of a tetrahedron: the power 3/2 of its mean
/// ratio 4 √3 A / Σ l²; the area is the geometric mean of those in the metrics of its vertices.
[[nodiscard]] inline double triangle_shape(const std::array<Vec<3>, 3>& corners,
                                           const std::array<const MeasuringMetric<3>*, 3>& metrics) {
    double areas = 1, squares = 0;
    for (const auto* m : metrics) {
        std::array<Vec<3>, 2> sides{};
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 3; ++k) sides[i][k] = dot(m->rows[k], corners[i + 1] - corners[0]);
        areas *= norm(cross(sides[0], sides[1]));
    }
    for (const auto& [a, b] : local_edges<2>) {
        const Vec<3> edge = corners[b] - corners[a];
        squares += metrics[a]->length_squared(edge) + metrics[b]->length_squared(edge);
    }
    squares /= 2;
    return squares > 0 ? shape_of_quality(2 * std::sqrt(3.0) * cbrt(areas) / squares, 3) : 0;
}
template <int D>
[[nodiscard]] double metric_quality(const std::array<Vec<D>, D + 1>& corners,
                                    const std::array<const MeasuringMetric<D>*, D + 1>& metrics) {
    return quality_of_shape(metric_shape<D>(corners, metrics), D);
}

}  // namespace camber
