module;
#include <algorithm>
#include <cmath>
module camber.metric:edge_search;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_length;
import :edge_minimiser;
import :edge_objective;
import :quadrature;
import :spd;
import :unit_frame;

/// What the searches for an edge's node share, whatever their unknowns are.
namespace camber {

template <int D>
struct Iterate {
    Vec<D> y;
    double value = 0;
    Vec<D> gradient;  ///< in the frame
    Sym<D> hessian;   ///< the model, in the frame
};

template <int D>
Iterate<D> evaluated(const EdgeObjective<D>& objective, const UnitFrame<D>& frame, const Vec<D>& y) {
    const ObjectiveSample<D> sample = objective.evaluate(frame.node(y));
    return {y, sample.value, frame.gradient(sample.gradient), congruence(transposed(frame.s), sample.hessian)};
}

/// H⁻¹ of a well-conditioned symmetric matrix, as those of the unit frame are; the identity where it is not.
template <int D>
Sym<D> inverse_of(const Sym<D>& h) {
    Mat<D> m;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) m(i, j) = h(i, j);
    const Mat<D> r = inverse(m);
    Sym<D> out;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) out(i, j) = 0.5 * (r(i, j) + r(j, i));
    return out;
}

/// The BFGS update of an inverse Hessian by a step s and a change of gradient d; skipped where curvature is not
/// positive.
template <int D>
void update_inverse_hessian(Sym<D>& h, const Vec<D>& s, const Vec<D>& d) {
    const double sd = dot(s, d);
    if (!(sd > 1e-10 * norm(s) * norm(d))) return;
    const Vec<D> hd = h * d;
    const double factor = (1 + dot(d, hd) / sd) / sd;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) h(i, j) += factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) / sd;
}

/// A pattern search along the frame's axes with falling radius: it needs no gradient, so a kink does not stop it.
template <int D>
void polish(const EdgeObjective<D>& objective, const UnitFrame<D>& frame, Iterate<D>& best) {
    const double scale = std::sqrt(std::max(best.value, 0.0));
    double radius = 0.05 * scale;
    for (int round = 0; round < 12 && radius > 1e-3 * scale; ++round) {
        bool moved = false;
        for (int k = 0; k < D; ++k)
            for (const double side : {-1.0, 1.0}) {
                Vec<D> y = best.y;
                y[k] += side * radius;
                y = frame.bounded(y);
                const double value = objective.value(frame.node(y));
                if (!(value < best.value)) continue;
                best.y = y;
                best.value = value;
                moved = true;
            }
        if (!moved) radius *= 0.3;
    }
}

/// The predicted node, halved until it beats the straight edge; the straight edge itself where it never does.
template <int D>
Iterate<D> start(const EdgeObjective<D>& objective, const UnitFrame<D>& frame, const Vec<D>& predicted) {
    const Iterate<D> straight = evaluated(objective, frame, Vec<D>{});
    Vec<D> y = frame.bounded(predicted);
    for (int halving = 0; halving < 4 && norm(y) > 1e-6; ++halving, y *= 0.5) {
        const Iterate<D> trial = evaluated(objective, frame, y);
        if (trial.value < straight.value) return trial;
    }
    return straight;
}

/// Lengths by the finer rule; the offset is halved until the edge is no longer than its chord.
template <int D>
void judge(const BackMesh<D>& back, const EdgeObjective<D>& objective, const Quadrature& rule,
           EdgeMinimum<D>& minimum) {
    const auto measure = [&](const Vec<D>& node) {
        const EdgeLength measured =
            riemannian_length(back, QuadraticEdge<D>{objective.p20, {node}, objective.p02}, rule, objective.hint);
        minimum.outside = measured.outside > 0;
        minimum.lost = measured.lost > 0;
        return measured.length;
    };
    const Vec<D> middle = midpoint(objective.p20, objective.p02);
    minimum.straight_length = minimum.length = measure(middle);
    if (minimum.node.point == middle) return;
    for (int halving = 0; halving < 6; ++halving) {
        minimum.length = measure(minimum.node.point);
        if (minimum.length < minimum.straight_length) return;
        minimum.shortened = true;
        minimum.node.point = midpoint(minimum.node.point, middle);
    }
    minimum.node.point = middle;
    minimum.length = measure(middle);
}

}  // namespace camber
