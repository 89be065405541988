module;
#include <array>
#include <cstddef>
export module camber.metric:curved_length;
import camber.core;
import camber.bezier;
import :batches;
import :spd;

export namespace camber {

/// The Gauss–Lobatto rule of 8 points on [0, 1]: both ends, and all polynomials up to degree 13.
inline constexpr std::array<double, 8> lobatto_points{0,
                                                      0.06412992574519669,
                                                      0.20414990928342885,
                                                      0.3953503910487606,
                                                      0.6046496089512394,
                                                      0.7958500907165712,
                                                      0.9358700742548033,
                                                      1};
inline constexpr std::array<double, 4> lobatto_weights{1.0 / 56, 0.10535211357175302, 0.17056134624175218,
                                                       0.20622939732935194};  ///< of either half, from its end

/// The length of a P2 edge in a metric that is known at its ends: ∫ |l'(t)| dt by the rule above, log M linear in t
/// between them. For a straight edge along common axes of both it is logarithmic_mean, to 1e-14 where sizes differ by
/// up to 7, to 1e-9 up to 150.
template <int D>
[[nodiscard]] inline double edge_length(const LogMetric<D>& from, const LogMetric<D>& to, const QuadraticEdge<D>& edge,
                                        Instructions set = widest_instructions()) {
    std::array<LogMetric<D>, 8> metrics;
    std::array<Vec<D>, 8> velocities;
    std::array<double, 8> speeds{};
    for (std::size_t q = 0; q < 8; ++q) {
        const double t = lobatto_points[q];
        metrics[q].l = (1 - t) * from.l + t * to.l;
        velocities[q] = edge.derivative(t);
    }
    metric_norms<D>(metrics, velocities, speeds, set);
    double length = 0;
    for (std::size_t q = 0; q < 4; ++q) length += lobatto_weights[q] * (speeds[q] + speeds[7 - q]);
    return length;
}

}  // namespace camber
