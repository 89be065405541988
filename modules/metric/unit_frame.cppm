module;
#include <algorithm>
#include <cmath>
module camber.metric:unit_frame;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_objective;
import :spd;

namespace camber {

/// The metric at the middle of the chord as a change of variables: P = mid + S y, in which the frozen-metric Hessian of
/// the objective is the identity.
template <int D>
struct UnitFrame {
    Vec<D> origin;
    Mat<D> s;              ///< columns r_k (H scale · e^{λ_k})^{-1/2}
    Vec<D> metric_weight;  ///< |S y|²_M = Σ weight_k y_k²
    Vec<D> chord;
    double max_shift = 0, max_offset = 0;

    [[nodiscard]] Vec<D> node(const Vec<D>& y) const { return origin + s * y; }
    [[nodiscard]] Vec<D> gradient(const Vec<D>& g) const { return transposed_times(s, g); }

    /// The coordinates of a node.
    [[nodiscard]] Vec<D> coordinates(const Vec<D>& node) const {
        Vec<D> y;
        const Vec<D> offset = node - origin;
        for (int k = 0; k < D; ++k) y[k] = dot(s.column[k], offset) / norm_squared(s.column[k]);
        return y;
    }

    /// y moved into the bounds on the tangential shift (in chords) and on the offset (in metric lengths).
    [[nodiscard]] Vec<D> bounded(Vec<D> y) const {
        double length = 0;
        for (int k = 0; k < D; ++k) length += metric_weight[k] * y[k] * y[k];
        length = std::sqrt(length);
        if (length > max_offset) y *= max_offset / length;
        // The shift a·y is linear: the nearest y of the slab |a·y| ≤ max_shift is nearer to 0 too, so both bounds hold.
        const Vec<D> a = transposed_times(s, chord) / norm_squared(chord);
        const double shift = dot(a, y);
        if (std::abs(shift) <= max_shift) return y;
        return y - (shift - std::copysign(max_shift, shift)) / norm_squared(a) * a;
    }
};

template <int D>
UnitFrame<D> unit_frame(const BackMesh<D>& back, const EdgeObjective<D>& objective, double max_tangential_shift,
                        double max_offset) {
    UnitFrame<D> frame;
    frame.origin = midpoint(objective.p20, objective.p02);
    frame.chord = objective.p02 - objective.p20;
    frame.max_shift = max_tangential_shift;
    frame.max_offset = max_offset;
    const SpectralMetric<D> metric(sample_value(back, frame.origin, objective.hint).log_metric);
    // ∫ 2·16(1−2t)² dt = 32/3 for the energy; the length's is that over 2 sqrt(q).
    double curvature = 32.0 / 3;
    if (objective.kind == EdgeObjectiveKind::length)
        curvature /= 2 * std::sqrt(std::max(metric.length_squared(frame.chord), 1e-300));
    for (int k = 0; k < D; ++k) {
        frame.s.column[k] = metric.vectors.column[k] / std::sqrt(curvature * metric.values[k]);
        frame.metric_weight[k] = 1 / curvature;
    }
    return frame;
}

}  // namespace camber
