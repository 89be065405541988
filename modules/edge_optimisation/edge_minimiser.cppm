module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>
export module camber.edge_optimisation:edge_minimiser;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

/// Number of points that are sampled together.
inline constexpr std::size_t edge_pack = 12;

/// Calls sampled(points, hint, samples) for each pack of quadrature points, then use(q, sample) for each point q.
template <int D, class Sampled, class Use>
void each_along(const QuadraticEdge<D>& edge, const Quadrature& rule, ElementId hint, Sampled&& sampled, Use&& use) {
    std::array<Vec<D>, edge_pack> points;
    std::array<FieldSample<D>, edge_pack> samples;
    for (std::size_t begin = 0; begin < rule.size(); begin += edge_pack) {
        const std::size_t n = std::min(edge_pack, rule.size() - begin);
        for (std::size_t i = 0; i < n; ++i) points[i] = edge.point(rule.t[begin + i]);
        sampled(std::span<const Vec<D>>(points.data(), n), hint, std::span<FieldSample<D>>(samples.data(), n));
        hint = samples[n - 1].location.element;
        for (std::size_t i = 0; i < n; ++i) use(begin + i, samples[i]);
    }
}

template <int D, class Use>
void each_value_along(const BackMesh<D>& back, const QuadraticEdge<D>& edge, const Quadrature& rule, ElementId hint,
                      Use&& use) {
    each_along(
        edge, rule, hint, [&](auto points, ElementId from, auto out) { back->sample_values(points, from, out); }, use);
}

template <int D, class Use>
void each_gradient_along(const BackMesh<D>& back, const QuadraticEdge<D>& edge, const Quadrature& rule, ElementId hint,
                         Use&& use) {
    each_along(
        edge, rule, hint,
        [&](auto points, ElementId from, auto out) { back->sample_with_gradients(points, from, out); }, use);
}

}  // namespace camber

export namespace camber {

/// Length of an edge, and the number of its sample points outside the background mesh.
struct EdgeLength {
    double length = 0;
    int outside = 0;
    int lost = 0;
};

/// Length ∫ sqrt(l'ᵀ M(l) l') dt in the field of the back mesh. `hint`: an element near the first vertex.
template <int D>
[[nodiscard]] EdgeLength riemannian_length(const BackMesh<D>& back, const QuadraticEdge<D>& edge,
                                           const Quadrature& rule, ElementId hint);

/// Metric along an edge: log M(t) is the quadratic through log M_20, log M(P^l) and log M_02 (paper §2.1, eq. 3 and 4).
template <int D>
struct EdgeField {
    LogMetric<D> l20, mid, l02;

    [[nodiscard]] LogMetric<D> at(double t) const {
        return {(1 - t) * (1 - 2 * t) * l20.l + 4 * t * (1 - t) * mid.l + t * (2 * t - 1) * l02.l};
    }
    /// log M_11 = (4 log M(P^l) − log M_20 − log M_02)/2 (eq. 4).
    [[nodiscard]] LogMetric<D> virtual_mid() const { return {2.0 * mid.l - 0.5 * (l20.l + l02.l)}; }
};

template <int D>
[[nodiscard]] EdgeField<D> edge_field(const BackMesh<D>& back, const QuadraticEdge<D>& edge, ElementId hint);

/// ∫ sqrt(l'ᵀ M(t) l') dt with the field of the three nodes.
template <int D>
[[nodiscard]] double riemannian_length(const EdgeField<D>& field, const QuadraticEdge<D>& edge, const Quadrature& rule);

/// The energy ∫ l'ᵀ M l' dt has the same minimising curves as the length, at constant speed, and a regular Hessian. The
/// length does not depend on the parametrisation, so its Hessian is singular, and quadrature creates false minima.
enum class EdgeObjectiveKind : std::uint8_t { energy, length };
[[nodiscard]] constexpr auto words(EdgeObjectiveKind) {
    return words_of(Word{EdgeObjectiveKind::energy, "energy"}, Word{EdgeObjectiveKind::length, "length"});
}

enum class EdgeFieldKind : std::uint8_t {
    back,  ///< field of the back mesh at each quadrature point
    edge,  ///< quadratic through the three log-metrics (paper §2.2.1, eq. 7)
};
[[nodiscard]] constexpr auto words(EdgeFieldKind) {
    return words_of(Word{EdgeFieldKind::back, "background"}, Word{EdgeFieldKind::edge, "edge"});
}

template <int D>
struct ObjectiveSample {
    double value = 0;
    Vec<D> gradient;  ///< derivative by P^l, in physical coordinates
    Sym<D> hessian;   ///< positive definite, with the metric frozen (energy), or its Gauss–Newton analogue (length)
};

template <int D>
struct EdgeObjective {
    const BackMesh<D>* back = nullptr;
    const Quadrature* rule = nullptr;
    EdgeObjectiveKind kind = EdgeObjectiveKind::energy;
    EdgeFieldKind field = EdgeFieldKind::back;
    Vec<D> p20, p02;
    LogMetric<D> l20, l02;  ///< log M at the ends, for EdgeFieldKind::edge
    ElementId hint;

    [[nodiscard]] double value(const Vec<D>& node) const;
    /// The gradient is exact unless a sample lies on a face of the back mesh. Costs one eigendecomposition per
    /// quadrature point.
    [[nodiscard]] ObjectiveSample<D> evaluate(const Vec<D>& node) const;
};

template <int D>
struct Chord {
    Vec<D> p20, p02;
    ElementId hint;  ///< an element near p20
};

/// Creates the objective and locates the ends of the chord from its hint. `back` and `rule` must outlive the result.
template <int D>
[[nodiscard]] EdgeObjective<D> edge_objective(const BackMesh<D>& back, const Quadrature& rule, EdgeObjectiveKind kind,
                                              EdgeFieldKind field, const Chord<D>& chord);

struct EdgeMinimiserOptions {
    EdgeObjectiveKind objective = EdgeObjectiveKind::energy;
    EdgeFieldKind field = EdgeFieldKind::back;
    int quadrature_points = 4;
    int max_iterations = 30;
    /// The search ends if the predicted relative decrease is below this.
    double tolerance = 1e-7;
    double length_tolerance = 1e-3;     ///< the same, when the length is minimised
    double max_tangential_shift = 0.2;  ///< in chords; at 1/4 the edge folds (l' = 0 at an end)
    double max_offset = 4;              ///< in metric lengths; an edge of a unit mesh has length 1

    /// User options. Callers that offer `objective` add that option.
    [[nodiscard]] static constexpr auto options() {
        using S = EdgeMinimiserOptions;
        return std::tuple(
            option("field", &S::field,
                   "energy and length only: metric along an edge. background: interpolated in the background mesh at "
                   "each point; edge: interpolated from the edge's three values"),
            option("quadrature_points", &S::quadrature_points,
                   "energy and length only: number of Gauss points on an "
                   "edge")
                .at_least(2)
                .at_most(12),
            option("iterations", &S::max_iterations,
                   "energy and length only: largest number of quasi-Newton steps "
                   "for an edge")
                .at_least(0)
                .at_most(1000),
            option("length_tolerance", &S::length_tolerance,
                   "energy only: from the minimum of the energy, the length is reduced while its predicted relative "
                   "decrease exceeds this. 0: never")
                .at_least(0)
                .at_most(1),
            option("max_tangential_shift", &S::max_tangential_shift,
                   "energy and length only: largest shift of a node along its edge")
                .unit("chord lengths")
                .at_least(0)
                .below(0.25),
            option("max_offset", &S::max_offset,
                   "energy and length only: largest distance of a volume node from the middle of its chord")
                .unit("lengths in the metric")
                .above(0));
    }
    friend bool operator==(const EdgeMinimiserOptions&, const EdgeMinimiserOptions&) = default;
};

enum class EdgeSearch : std::uint8_t {
    converged,  ///< the predicted decrease is below the tolerance
    polished,   ///< the search stopped at a kink of the field and ended with pattern search
    exhausted,  ///< iteration limit
};

template <int D>
struct EdgeMinimum {
    LagrangeNode<D> node;
    double straight_length = 0;  ///< length of the chord by the rule of report_points
    double length = 0;           ///< length with `node`, never above straight_length
    EdgeSearch search = EdgeSearch::converged;
    bool shortened = false;  ///< the finer rule required a smaller offset
    bool outside = false;    ///< a sample was outside the back mesh
    bool lost = false;       ///< a sample was not located
};

struct EdgeRules {
    Quadrature objective, report;
};
[[nodiscard]] EdgeRules edge_rules(const EdgeMinimiserOptions& options);

/// Returns P^l = mid + Γ(e, e)/8, Γ(e, e) = M⁻¹[(∂_e M) e − ½ eᵀ(∂M) e]: the first Newton step of the energy (geodesic
/// equation x'' = −Γ(x', x')). Uses the recovered gradient, which does not depend on the back element.
template <int D>
[[nodiscard]] Vec<D> geodesic_start(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02, ElementId hint);

/// Minimises the length of an edge anywhere in the back mesh, from the better of the straight edge and geodesic_start.
/// Uses BFGS in the metric's frame, then pattern search at kinks of the field. The result is never longer than the
/// straight edge by the finer rule. `hint`: an element near p20.
template <int D>
[[nodiscard]] EdgeMinimum<D> minimise_edge(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02,
                                           ElementId hint, const EdgeRules& rules, const EdgeMinimiserOptions& options);

/// Minimises the length of an edge of the back mesh with a non-empty shell. Starts from the best closed-form minimum of
/// the shell's sectors, because the chord lies on kinks of the field, or from the present node if that is better. The
/// result is never longer than the present edge, and independent of the order of the shell.
template <int D>
[[nodiscard]] EdgeMinimum<D> minimise_back_edge(const BackMesh<D>& back, const BackEdge& edge,
                                                const LagrangeNode<D>& present, const EdgeRules& rules,
                                                const EdgeMinimiserOptions& options);

template <int D>
struct BackEdges {
    std::span<const BackEdge> edges;
    std::span<const LagrangeNode<D>> nodes;
};

struct EdgeSearchWork {
    std::size_t single = 0;          ///< edges searched individually
    std::size_t judged = 0;          ///< edges compared by the finer rule
    std::size_t decompositions = 0;  ///< eigendecompositions of M, in packs
    EdgeSearchWork& operator+=(const EdgeSearchWork& o) {
        single += o.single;
        judged += o.judged;
        decompositions += o.decompositions;
        return *this;
    }
};

/// Like minimise_back_edge, for many edges in packs; lengths are not computed (0). Results are bitwise independent of
/// other edges and of the instruction set.
template <int D>
EdgeSearchWork minimise_back_edges(const BackMesh<D>& back, const BackEdges<D>& edges, const EdgeRules& rules,
                                   const EdgeMinimiserOptions& options, std::span<EdgeMinimum<D>> minima,
                                   Instructions set = widest_instructions());

template <int D>
struct FreeEdge {
    BackVertex<D> a, b;
    ElementId hint;  ///< an element near vertex a
};

/// Like minimise_edge, for many edges in packs. Starts from the chord with the gradient of its elements. Edges are
/// searched individually if the field is curved or the chord leaves the mesh.
template <int D>
EdgeSearchWork minimise_edges(const BackMesh<D>& back, std::span<const FreeEdge<D>> edges, const EdgeRules& rules,
                              const EdgeMinimiserOptions& options, std::span<EdgeMinimum<D>> minima,
                              Instructions set = widest_instructions());

}  // namespace camber

namespace camber {

/// Frame of the metric at the chord midpoint, in which the frozen-metric Hessian is the identity: P = mid + S y.
template <int D>
struct UnitFrame {
    Vec<D> origin;
    Mat<D> s;  ///< columns (curvature · e^{λ_k})^{-1/2} r_k, for eigenvalues λ_k and eigenvectors r_k of log M
    Vec<D> metric_weight;  ///< |S y|²_M = Σ weight_k y_k²
    Vec<D> chord;
    double max_shift = 0, max_offset = 0;

    [[nodiscard]] Vec<D> node(const Vec<D>& y) const { return origin + s * y; }
    [[nodiscard]] Vec<D> gradient(const Vec<D>& g) const { return transposed_times(s, g); }

    [[nodiscard]] Vec<D> coordinates(const Vec<D>& node) const {
        Vec<D> y;
        const Vec<D> offset = node - origin;
        for (int k = 0; k < D; ++k) y[k] = dot(s.column[k], offset) / norm_squared(s.column[k]);
        return y;
    }

    [[nodiscard]] Vec<D> bounded(Vec<D> y) const {
        double length = 0;
        for (int k = 0; k < D; ++k) length += metric_weight[k] * y[k] * y[k];
        length = std::sqrt(length);
        if (length > max_offset) y *= max_offset / length;
        // The projection onto the slab |a·y| ≤ max_shift also reduces |y|, so both limits hold.
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
    // Curvature of the energy: ∫ 2·16(1−2t)² dt = 32/3. For the length, this is divided by 2 sqrt(q).
    double curvature = 32.0 / 3;
    if (objective.kind == EdgeObjectiveKind::length)
        curvature /= 2 * std::sqrt(std::max(metric.length_squared(frame.chord), 1e-300));
    for (int k = 0; k < D; ++k) {
        frame.s.column[k] = metric.vectors.column[k] / std::sqrt(curvature * metric.values[k]);
        frame.metric_weight[k] = 1 / curvature;
    }
    return frame;
}

/// A chord of the back mesh lies on kinks of the field. Each element of its shell has its own gradient, with a local
/// minimum in its sector (the wedge around the chord) or on a face of the sector. While the node stays in a sector, the
/// whole parabola does too. The model value + gᵀy + |y|²/2 in the unit frame is then exact to second order.

/// Gradient at the chord: ∂_i = common_i + ⟨adjoint, G_i⟩, where G is the field gradient in a sector.
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

/// Returns the point of the cone { y : a_k·y ≥ 0 } nearest to y.
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

/// Returns the minimum in the sector with the best model value; zero if no sector predicts a decrease. Independent of
/// the order of the shell.
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
        // At the projection y of −g, the model decreases by |y|²/2.
        const Vec<D> y = nearest_in_sector<D>(-frame.gradient(g), walls);
        // On a shared wall both sectors find the same point up to rounding; the comparison makes the choice unique.
        if (norm_squared(y) > norm_squared(best) || (norm_squared(y) == norm_squared(best) && y.c > best.c)) best = y;
    }
    return best;
}

}  // namespace camber

/// Common parts of the searches for an edge's node.
namespace camber {

template <int D>
struct Iterate {
    Vec<D> y;
    double value = 0;
    Vec<D> gradient;
    Sym<D> hessian;  ///< Hessian of the objective's model, in coordinates y
};

template <int D>
Iterate<D> evaluated(const EdgeObjective<D>& objective, const UnitFrame<D>& frame, const Vec<D>& y) {
    const ObjectiveSample<D> sample = objective.evaluate(frame.node(y));
    return {y, sample.value, frame.gradient(sample.gradient), congruence(transposed(frame.s), sample.hessian)};
}

/// Returns H⁻¹ if H is well-conditioned, else the identity.
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

/// BFGS update with step s and gradient change d; skipped if the curvature is not positive.
template <int D>
void update_inverse_hessian(Sym<D>& h, const Vec<D>& s, const Vec<D>& d) {
    const double sd = dot(s, d);
    if (!(sd > 1e-10 * norm(s) * norm(d))) return;
    const Vec<D> hd = h * d;
    const double factor = (1 + dot(d, hd) / sd) / sd;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) h(i, j) += factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) / sd;
}

/// Pattern search without gradients, so kinks do not stop it.
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
