module;
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
module camber.metric:edge_sectors;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_objective;
import :spd;
import :unit_frame;

namespace camber {

/// When the chord is an edge of the back mesh, it lies on kinks of the field: each element of its shell has a gradient
/// of its own, and the objective a local minimum of its own in the sector (the wedge of that element around the chord)
/// or on a face between two. As long as the node stays in one sector the whole parabola does, so there the objective is
/// smooth, and its model from the chord, value + gᵀy + |y|²/2 in the unit frame, is exact to second order.
///
/// best_sector_start: of the minimisers y of each element's model over its sector, the lowest.

/// The gradient at the chord, split in what all sectors share and what the field's gradient of each adds:
/// ∂_i = common_i + ⟨adjoint, G_i⟩.
template <int D>
struct ChordGradient {
    Vec<D> common;
    Sym<D> adjoint;
};

template <int D>
ChordGradient<D> chord_gradient(const BackMesh<D>& back, const EdgeObjective<D>& objective, VertexId a, VertexId b) {
    ChordGradient<D> out;
    const Vec<D> chord = objective.p02 - objective.p20;
    const LogMetric<D> at_a = back->vertex(a).log_metric, at_b = back->vertex(b).log_metric;
    for (std::size_t k = 0; k < objective.rule->size(); ++k) {
        const double t = objective.rule->t[k];
        const SpectralMetric<D> metric(LogMetric<D>{(1 - t) * at_a.l + t * at_b.l});
        double w = objective.rule->w[k];
        if (objective.kind == EdgeObjectiveKind::length) w *= 0.5 / std::sqrt(metric.length_squared(chord));
        out.common += w * 8 * (1 - 2 * t) * metric.times(chord);
        out.adjoint += w * 4 * t * (1 - t) * length_squared_adjoint(metric, chord);
    }
    return out;
}

/// The point of the cone { y : a_k·y ≥ 0 } nearest to y: inside, on one wall, or on the line where two meet.
template <int D>
Vec<D> nearest_in_sector(const Vec<D>& y, const std::array<Vec<D>, D - 1>& walls) {
    const auto onto = [](const Vec<D>& p, const Vec<D>& wall) { return p - dot(p, wall) / norm_squared(wall) * wall; };
    const auto behind = [](const Vec<D>& p, const Vec<D>& wall) {
        return dot(p, wall) < -1e-12 * norm(p) * norm(wall);
    };
    if constexpr (D == 2) {
        return behind(y, walls[0]) ? onto(y, walls[0]) : y;
    } else {
        const bool hidden0 = behind(y, walls[0]);
        const bool hidden1 = behind(y, walls[1]);
        if (!hidden0 && !hidden1) return y;
        if (hidden0)
            if (const Vec<D> p = onto(y, walls[0]); !behind(p, walls[1])) return p;
        if (hidden1)
            if (const Vec<D> p = onto(y, walls[1]); !behind(p, walls[0])) return p;
        const Vec<D> line = cross(walls[0], walls[1]);
        return dot(y, line) / norm_squared(line) * line;
    }
}

/// The start of the sector whose model promises most; the zero vector where none promises anything. The result depends
/// on the shell as a set, not on its order.
template <int D>
Vec<D> best_sector_start(const BackMesh<D>& back, const EdgeObjective<D>& objective, const UnitFrame<D>& frame,
                         VertexId a, VertexId b, std::span<const ElementId> shell) {
    const ChordGradient<D> chord = chord_gradient(back, objective, a, b);
    Vec<D> best;
    for (const ElementId e : shell) {
        auto [field, walls] = back->sector(e, a, b);
        Vec<D> g = chord.common;
        for (int i = 0; i < D; ++i) g[i] += inner(chord.adjoint, field[i]);
        for (Vec<D>& wall : walls) wall = frame.gradient(wall);
        // The model's decrease at the projection y of −g onto the cone is |y|²/2.
        const Vec<D> y = nearest_in_sector<D>(-frame.gradient(g), walls);
        // On the wall between two sectors both find the same point, but for its last bits.
        if (norm_squared(y) > norm_squared(best) || (norm_squared(y) == norm_squared(best) && y.c > best.c)) best = y;
    }
    return best;
}

}  // namespace camber
