module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>
module camber.edge_optimisation:edge_pack_step;
import camber.core;
import camber.bezier;
import camber.metric;
import :edge_minimiser;
import :edge_pack_lanes;
import :edge_pack_location;
import :edge_pack_objective;

/// Length minimisation from near the energy's minimum. The Hessian is almost singular along the edge. It is therefore
/// not approximated from gradients, but computed at the quadrature points of q = l'ᵀ M l': ∂²√q = ∂²q/(2√q) − ∂q ∂qᵀ/(4
/// q^{3/2}), the first term with the metric frozen.
namespace camber {

/// Regularisation of the Hessian, as a share of its first term.
inline constexpr double length_stiffness = 0.01;
/// Maximum product of the diagonals of a matrix and its inverse.
inline constexpr double max_length_condition = 1e4;

/// Computes H⁻¹ by Cholesky factors, because H is as ill-conditioned as a metric.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> inverse_of(const SymPack<D>& h) {
    MatPack<D> root;      // H = root rootᵀ
    MatPack<D> inverted;  // root⁻¹
    for (int j = 0; j < D; ++j) {
        Pack pivot = h(j, j);
        for (int k = 0; k < j; ++k) pivot -= root(j, k) * root(j, k);
        root(j, j) = sqrt(max(pivot, 1e-15 * h(j, j)));
        for (int i = j + 1; i < D; ++i) {
            Pack sum = h(i, j);
            for (int k = 0; k < j; ++k) sum -= root(i, k) * root(j, k);
            root(i, j) = sum / root(j, j);
        }
    }
    for (int j = 0; j < D; ++j) {
        inverted(j, j) = 1 / root(j, j);
        for (int i = j + 1; i < D; ++i) {
            Pack sum = packed(0);
            for (int k = j; k < i; ++k) sum -= root(i, k) * inverted(k, j);
            inverted(i, j) = sum / root(i, i);
        }
    }
    SymPack<D> out;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) {
            out(i, j) = packed(0);
            for (int k = i; k < D; ++k) out(i, j) += inverted(k, i) * inverted(k, j);
        }
    return out;
}

template <int D>
struct LengthHessian {
    SymPack<D> frozen{}, spread{};

    [[gnu::always_inline]] inline void add(const ChordFrame<D>& f, const PointPack<D>& point, double weight, double t,
                                           const VecPack<D>& slope) {
        const Pack root = sqrt(point.squared);
        const Pack half = select(root > 0, 0.5 / root, packed(0));
        const Pack by_slope = (2 * weight) * half * half * half;
        const double c = 4 * (1 - 2 * t);
        const Pack by_metric = (2 * c * c * weight) * half;
        const SymPack<D> metric = composed(point.log_metric.vectors, point.values);
        for (int i = 0; i < D; ++i) {
            const Pack metric_row = by_metric * f.scale[i];
            const Pack slope_row = by_slope * slope[i];
            for (int j = 0; j <= i; ++j) {
                frozen(i, j) += metric_row * f.scale[j] * metric(i, j);
                spread(i, j) += slope_row * slope[j];
            }
        }
    }

    /// Inverse of the Hessian. If the Hessian is not positive, uses the energy of a curve with this length and constant
    /// speed.
    [[nodiscard, gnu::always_inline]] inline SymPack<D> inverse(Pack length) const {
        SymPack<D> h;
        for (int k = 0; k < sym_size<D>; ++k) h.c[k] = (1 + length_stiffness) * frozen.c[k] - spread.c[k];
        SymPack<D> out = inverse_of(h);
        Mask positive(-1);
        for (int i = 0; i < D; ++i) positive &= (h(i, i) > 0) & (h(i, i) * out(i, i) < max_length_condition);
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) out(i, j) = select(positive, out(i, j), i == j ? 2 * length : packed(0));
        return out;
    }
};

}  // namespace camber

/// One evaluation of eight searches.
namespace camber {

template <int D>
[[nodiscard]] ElementId across(const PackedEdges<D>& all, std::uint32_t edge, ElementId element, int wall) {
    const auto& [a, b, shell] = all.edges[edge];
    VertexId other_vertex;
    int n = 0;
    for (const VertexId v : all.back.mesh.elements.vertices[element]) {
        if (v == a || v == b) continue;
        if (n++ != wall) other_vertex = v;
    }
    for (const ElementId e : shell) {
        if (e == element) continue;
        const auto& v = all.back.mesh.elements.vertices[e];
        if (D == 2 || std::ranges::find(v, other_vertex) != v.end()) return e;
    }
    return {};
}

/// In lanes with one active wall, moves to the element across it if that predicts a decrease. Returns these lanes.
template <int D>
[[nodiscard, gnu::always_inline]] inline Mask crossed(const PackedEdges<D>& all, SearchLanes<D>& lanes,
                                                      const WallStep<D>& walls, Mask ended) {
    SearchPack<D>& s = lanes.pack;
    Mask crossing_lanes = ended & (s.crossings < max_crossings);
    if constexpr (D == 2)
        crossing_lanes &= walls.active[0];
    else
        crossing_lanes &= walls.active[0] ^ walls.active[1];
    if (!any(crossing_lanes)) return crossing_lanes;
    std::array<ElementId, pack_size> elements = lanes.element;
    std::array<VertexId, pack_size> a;
    std::array<VertexId, pack_size> b;
    for (int lane = 0; lane < pack_size; ++lane) {
        a[lane] = all.edges[lanes.edge[lane]].a;
        b[lane] = all.edges[lanes.edge[lane]].b;
        if (crossing_lanes[lane] == 0) continue;
        const ElementId next = across(all, lanes.edge[lane], elements[lane], walls.active[0][lane] != 0 ? 0 : 1);
        if (next.valid())
            elements[lane] = next;
        else
            crossing_lanes[lane] = 0;
    }
    const ChordPack<D> chords = chords_of(all.back, a, b);
    const WedgePack<D> wedge = wedge_of(s.frame, shell_elements(all.back, chords, elements));
    const Mask by_length = s.by_length != 0;
    const EdgeValues<D> at = values_in(s.frame, wedge, s.sums);
    const VecPack<D> gradient = gradient_of(at, by_length);
    SymPack<D> inverse_hessian = multiple_of_identity<D>(2 * s.at.length);
    choose(~by_length, inverse_hessian, inverse_hessian_at_chord(s.frame, wedge));
    const WallStep<D> step =
        step_within(wedge.rise, free_part(s, inverse_hessian, gradient, all.options), gradient, s.y);
    crossing_lanes &= -step.slope > all.options.tolerance * value_of(s.at, by_length);
    choose(crossing_lanes, s.wedge, wedge);
    choose(crossing_lanes, s.at, at);
    choose(crossing_lanes, s.inverse_hessian, inverse_hessian);
    choose(crossing_lanes, s.direction, step.step);
    s.slope = select(crossing_lanes, step.slope, s.slope);
    s.crossings += select(crossing_lanes, packed(1), packed(0));
    for (int lane = 0; lane < pack_size; ++lane)
        if (crossing_lanes[lane] != 0) lanes.element[lane] = elements[lane];
    return crossing_lanes;
}

template <int D>
struct WithinWedge {
    EdgeSums<D> sums;
    LengthHessian<D> length_hessian;  ///< Hessian at the last curve, for the length objective

    [[nodiscard, gnu::always_inline]] inline EdgeValues<D> values(const PackedEdges<D>& all,
                                                                  const SearchLanes<D>& lanes, const VecPack<D>& y,
                                                                  WalkMarks&) {
        const SearchPack<D>& s = lanes.pack;
        const Quadrature& rule = all.rules.objective;
        const bool is_length = all.options.objective == EdgeObjectiveKind::length;
        sums = sums_along(
            s.frame, parabola(s.frame, s.wedge, y), rule,
            [&](std::size_t q, const auto& point, auto moved, auto adjoint) __attribute__((always_inline)) {
                if (!is_length) return;
                const double t = rule.t[q];
                for (int i = 0; i < D; ++i) moved[i] *= 8 * (1 - 2 * t);
                for (int k = 0; k < sym_size<D>; ++k) adjoint.c[k] *= 4 * t * (1 - t);
                length_hessian.add(s.frame, point, rule.w[q], t, gradient_in(s.frame, s.wedge, moved, adjoint));
            });
        return values_in(s.frame, s.wedge, sums);
    }
    [[gnu::always_inline]] inline void keep(SearchLanes<D>& lanes, Mask accepted) const {
        choose(accepted, lanes.pack.sums.energy, sums.energy);
        choose(accepted, lanes.pack.sums.length, sums.length);
        lanes.pack.sums.second = select(accepted, sums.second, lanes.pack.sums.second);
        lanes.pack.sums.third = select(accepted, sums.third, lanes.pack.sums.third);
    }
    [[nodiscard, gnu::always_inline]] static inline Pack bulge(const SearchLanes<D>& lanes) {
        const SymPack<D> change = parabola(lanes.pack.frame, lanes.pack.wedge, lanes.pack.y).change;
        return sqrt(inner(change, change));
    }
    /// Minimum gain, computed with the quadrature rule of the search, that is certain for any finer rule.
    [[nodiscard, gnu::always_inline]] static inline Pack sure_gain(const PackedEdges<D>& all,
                                                                   const SearchLanes<D>& lanes) {
        const SearchPack<D>& s = lanes.pack;
        if (all.rules.objective.size() < min_points) return packed(1e300);
        return min_gain * s.chord_length + s.chord_unsure + unsure_share(s.sums) * s.at.length;
    }
    [[nodiscard, gnu::always_inline]] static inline Mask continues(const PackedEdges<D>& all, SearchLanes<D>& lanes,
                                                                   const WallStep<D>& walls, Mask ended) {
        return crossed(all, lanes, walls, ended);
    }
    [[nodiscard, gnu::always_inline]] static inline Mask extrapolates(const SearchPack<D>& s) {
        return beyond_ends(s, s.y) > 0;
    }
};

template <int D>
struct ThroughElements {
    PointElements<D>& points;
    LengthHessian<D> length_hessian{};

    [[nodiscard, gnu::always_inline]] inline EdgeValues<D> values(const PackedEdges<D>& all, SearchLanes<D>& lanes,
                                                                  const VecPack<D>& y, WalkMarks& marks) {
        const Quadrature& rule = all.rules.objective;
        const bool is_length = all.options.objective == EdgeObjectiveKind::length;
        return located_values(all.back, {lanes.pack.frame, y}, rule, points, marks,
                              [&](std::size_t q, const auto& point, auto slope) __attribute__((always_inline)) {
                                  if (!is_length) return;
                                  for (int i = 0; i < D; ++i) slope[i] *= 1 / rule.w[q];
                                  length_hessian.add(lanes.pack.frame, point, rule.w[q], rule.t[q], slope);
                              });
    }
    [[gnu::always_inline]] static inline void keep(SearchLanes<D>&, Mask) {}
    [[nodiscard, gnu::always_inline]] static inline Pack bulge(const SearchLanes<D>& lanes) {
        return sqrt(lanes.pack.at.bulge);
    }
    [[nodiscard, gnu::always_inline]] static inline Pack sure_gain(const PackedEdges<D>& all,
                                                                   const SearchLanes<D>& lanes) {
        if (all.rules.objective.size() < min_points) return packed(1e300);
        const Pack change = lanes.pack.along;
        return sure_share_with_kinks * max(packed(1), change * change) * lanes.pack.chord_length;
    }
    [[nodiscard, gnu::always_inline]] static inline Mask continues(const PackedEdges<D>&, SearchLanes<D>&,
                                                                   const WallStep<D>&, Mask) {
        return {};
    }
    [[nodiscard, gnu::always_inline]] static inline Mask extrapolates(const SearchPack<D>&) { return {}; }
};

template <int D>
[[gnu::always_inline]] inline void take_last_step(SearchPack<D>& s, Mask lanes, const VecPack<D>& direction,
                                                  const EdgeMinimiserOptions& options) {
    if (!any(lanes)) return;
    choose(lanes, s.direction, direction);
    s.step = select(lanes, reach(s, options), s.step);
    choose(lanes & ~leaves(s, options), s.y, trial_of(s, options));
}

template <int D>
[[gnu::always_inline]] inline void restart_towards(SearchPack<D>& s, Mask lanes) {
    choose(lanes, s.direction, s.y);
    choose(lanes, s.y, VecPack<D>{});
    choose(lanes, s.at, s.on_chord);
    s.slope = select(lanes, dot(gradient_of(s.at, s.by_length != 0), s.direction), s.slope);
    s.step = select(lanes, packed(1), s.step);
    s.attempts = select(lanes, packed(0), s.attempts);
}

struct Ended {
    Mask ended{}, exhausted{}, kinked{};
    Mask leaves{};  ///< the search continues in another queue
};

template <int D, class Where>
[[nodiscard, gnu::always_inline]] inline Ended stepped(const PackedEdges<D>& all, SearchLanes<D>& lanes, Where where) {
    SearchPack<D>& s = lanes.pack;
    const EdgeMinimiserOptions& o = all.options;
    const bool is_length = o.objective == EdgeObjectiveKind::length;
    const bool shortens = is_length || o.length_tolerance > 0;
    const Mask by_length = s.by_length != 0;
    const VecPack<D> trial = trial_of(s, o);
    Ended out;
    WalkMarks marks{.lost = s.running == 0};
    const EdgeValues<D> at = where.values(all, lanes, trial, marks);
    const Mask running = (s.running != 0) & ~marks.lost;
    const Pack from = value_of(s.at, by_length);
    const Pack value = value_of(at, by_length);
    VecPack<D> moved;
    VecPack<D> change;
    for (int i = 0; i < D; ++i) {
        moved[i] = trial[i] - s.y[i];
        change[i] = select(by_length, at.length_gradient[i] - s.at.length_gradient[i],
                           at.energy_gradient[i] - s.at.energy_gradient[i]);
    }
    const Mask bounded = norm(moved) < 0.9 * s.step * norm(s.direction);
    const Mask accepted = running & ((value < from + 1e-4 * s.step * s.slope) | (bounded & (value < from)));
    const Mask rejected = (s.running != 0) & ~accepted;
    // Rejected trials also give curvature information.
    const Mask has_curvature = rejected & running & (dot(moved, change) > 0);
    update_inverse_hessian(s.inverse_hessian, accepted | has_curvature, moved, change);
    choose(accepted, s.y, trial);
    choose(accepted, s.at, at);
    where.keep(lanes, accepted);
    const VecPack<D> gradient = gradient_of(s.at, by_length);
    const WallStep<D> next = step_within(s.wedge.rise, free_part(s, s.inverse_hessian, gradient, o), gradient, s.y);
    const Mask last_phase = by_length & Mask(is_length ? 0 : -1);
    // The last step must not make a certain gain uncertain, and far from the minimum the Hessian of the length is not
    // usable.
    const Pack gain = s.chord_length - s.at.length;
    const Pack sure = where.sure_gain(all, lanes);
    const Mask ambiguous = (gain > sure) & (gain < sure + 2 * last_step * s.chord_length);
    const auto is_near = [&](const VecPack<D>& step) __attribute__((always_inline)) {
        const Pack share = dot(step, step) / s.at.energy;
        return (share < max_blind_step) & ((gain <= sure) | (share * s.chord_length < 2 * (gain - sure)));
    };
    const Mask by_near_length = (is_length ? s.probed == 0 : Mask(0)) & is_near(next.step);
    const Mask accepts_length = ~ambiguous & (~by_length | by_near_length);
    const Pack last = packed(is_length ? last_step_of_length : last_step);
    const Mask rough = where.extrapolates(s);
    const Pack least = select(rough, packed(std::max(o.tolerance, extrapolated_last_step)),
                              select(accepts_length, max(packed(o.tolerance), last), packed(o.tolerance)));
    const Pack tolerance = select(last_phase, packed(o.length_tolerance), least) * value_of(s.at, by_length);
    const Mask minimal = ~(-next.slope > tolerance);
    const Mask converged = accepted & (minimal | (from - value < 0.1 * tolerance));
    s.steps += select(accepted, packed(1), packed(0));
    const Pack most = select(last_phase, packed(max_length_steps), packed(o.max_iterations));
    out.exhausted = accepted & ~converged & (s.steps >= most);
    s.attempts = select(accepted, packed(0), s.attempts + 1);
    const Mask stuck = rejected & ((s.attempts >= max_attempts) | (has_curvature & minimal));
    const Mask back = rejected & ~has_curvature;
    s.step = select(back, 0.3 * s.step, s.step);
    const Mask turned = accepted | has_curvature;
    choose(turned, s.direction, next.step);
    s.slope = select(turned, next.slope, s.slope);

    out.ended = converged | out.exhausted | stuck;
    Mask at_wall = next.active[0];
    if constexpr (D == 3) at_wall |= next.active[1];
    const Mask on = where.continues(all, lanes, next, (converged | stuck) & ~last_phase);
    out.ended &= ~on;
    Mask renewed = (turned & ~out.ended) | on;
    const Mask afresh = accepted | on;
    VecPack<D> last_way = next.step;
    if (shortens && any(out.ended & ~by_length)) {
        SymPack<D> inverse_hessian = multiple_of_identity<D>(2 * s.at.length);
        if (is_length) choose(accepted, inverse_hessian, where.length_hessian.inverse(s.at.length));
        const WallStep<D> step = step_within(s.wedge.rise, free_part(s, inverse_hessian, s.at.length_gradient, o),
                                             s.at.length_gradient, s.y);
        const Mask turns = out.ended & ~by_length & ~where.extrapolates(s);
        const Mask blind = accepts_length & is_near(step.step);
        const Pack enough = is_length ? select(blind, least, packed(o.tolerance)) : packed(o.length_tolerance);
        const Mask advances = turns & (-step.slope > enough * s.at.length);
        choose(advances, s.direction, step.step);
        choose(advances, s.inverse_hessian, inverse_hessian);
        s.slope = select(advances, step.slope, s.slope);
        s.steps = select(advances, packed(0), s.steps);
        s.by_length = select(advances, packed(1), s.by_length);
        if (is_length) choose(turns & blind & ~advances, last_way, step.step);
        out.ended &= ~advances;
        renewed |= advances;
        s.attempts = select(advances, packed(0), s.attempts);
    }
    s.attempts = select(afresh, packed(0), s.attempts);
    const Pack share = reach(s, o);
    s.step = select(renewed, share, s.step);
    const Mask blocked = renewed & (share < blocked_step);
    out.kinked = (out.ended & (stuck | at_wall)) | blocked;
    out.ended |= blocked;
    out.leaves = renewed & ~out.ended & leaves(s, o);
    take_last_step(s, converged & out.ended & (accepts_length | rough), last_way, o);
    const Mask away = (out.ended | out.leaves) & where.extrapolates(s);
    if (any(away)) {
        restart_towards(s, away);
        out.leaves |= away;
        out.ended &= ~away;
    }
    return out;
}

}  // namespace camber

/// If an edge does not resolve the field, there are many local minima between kinks, where descent ends. A few distant
/// positions are therefore probed first.
namespace camber {

/// Probed offsets of the node across the finest axis (the bounds exclude others), in chord lengths. `along`: direction
/// nearest to the chord, within the shift bound. `across`: direction orthogonal to the finest axis and to `along`.
struct ProbePosition {
    double along, across;
};
inline constexpr std::array probe_positions{ProbePosition{1, -0.5}, ProbePosition{1, 1}, ProbePosition{-1, 0.5},
                                            ProbePosition{-1, -1}};
/// Initial radius of the pattern search, as a share of the chord; halved once.
inline constexpr double first_radius = 0.5;
inline constexpr int pattern_search_iterations = 2;

/// Steps of y by one chord length, orthogonal in space. The last is along the finest axis, limited by its bound.
template <int D>
struct ProbeAxes {
    std::array<VecPack<D>, D> axis;
    Pack max_along{};
};

template <int D>
[[nodiscard, gnu::always_inline]] inline ProbeAxes<D> probe_axes(const ChordFrame<D>& f,
                                                                 const EdgeMinimiserOptions& options) {
    Pack least = f.scale[0];
    for (int i = 1; i < D; ++i) least = min(f.scale[i], least);
    VecPack<D> finest;
    Mask found{};
    for (int i = 0; i < D; ++i) {
        const Mask is = ~found & (f.scale[i] == least);
        finest[i] = select(is, packed(1), packed(0));
        found |= is;
    }
    const Pack chord = norm(f.chord);
    VecPack<D> along;
    for (int i = 0; i < D; ++i) along[i] = f.chord[i] * (1 - finest[i]);
    const Pack within = norm(along);
    // If the chord is along the finest axis, all directions are equally near.
    const Mask none = ~(within > 1e-6 * chord);
    for (int i = 0; i < D; ++i) along[i] = select(none, finest[(i + 1) % D], along[i] / within);
    ProbeAxes<D> out;
    out.max_along = select(none, packed(1), options.max_tangential_shift * chord / within);
    const Pack bound = options.max_offset * unit_offset * least;
    std::array<VecPack<D>, D> directions{};
    directions[0] = along;
    if constexpr (D == 3) directions[1] = cross(finest, along);
    directions[D - 1] = finest;
    for (int k = 0; k < D; ++k)
        for (int i = 0; i < D; ++i)
            out.axis[k][i] = (k == D - 1 ? min(bound, chord) : chord) * directions[k][i] / f.scale[i];
    return out;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> bounded(const ChordFrame<D>& f, VecPack<D> y,
                                                            const EdgeMinimiserOptions& options) {
    const double most = options.max_offset * unit_offset;
    const Pack length = norm(y);
    const Pack step_scale = select(length > most, most / length, packed(1));
    for (int i = 0; i < D; ++i) y[i] *= step_scale;
    const Pack shift = dot(f.shift, y);
    const Pack beyond = shift - copysign(packed(options.max_tangential_shift), shift);
    const Pack back = select(abs(shift) > options.max_tangential_shift, beyond / dot(f.shift, f.shift), packed(0));
    for (int i = 0; i < D; ++i) y[i] -= back * f.shift[i];
    return y;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> y_of(const ProbeAxes<D>& axes, const ProbePosition& place) {
    VecPack<D> y;
    const Pack along = copysign(min(packed(std::abs(place.along)), axes.max_along), packed(place.along));
    for (int i = 0; i < D; ++i) {
        if constexpr (D == 3)
            y[i] = along * axes.axis[0][i] + place.across * axes.axis[1][i];
        else
            y[i] = along * std::abs(place.across) * axes.axis[0][i];
    }
    return y;
}

template <int D>
struct Probing {
    VecPack<D> y;
    Pack value{};
    Mask found{};
};

template <int D>
[[gnu::always_inline]] inline void look(const PackedEdges<D>& all, const SearchPack<D>& s, Mask requested,
                                        const VecPack<D>& y, PointElements<D>& points, Probing<D>& best) {
    WalkMarks marks{.lost = ~requested};
    const Quadrature& rule = all.rules.objective;
    const EdgeValues<D> at = located_lengths_beside(all.back, {s.frame, y}, rule, points, marks);
    const Pack value = value_of(at, s.by_length != 0);
    const Mask lower = requested & ~marks.lost & ~marks.outside & (value < best.value);
    choose(lower, best.y, y);
    best.value = select(lower, value, best.value);
    best.found |= lower;
    all.work.decompositions += count_of(requested) * rule.size();
}

/// Returns the best of the probed positions and the next step; pattern search refines it in lanes `near`.
template <int D>
[[nodiscard, gnu::always_inline]] inline Probing<D> probed(const PackedEdges<D>& all, const SearchPack<D>& s, Mask open,
                                                           Mask near, PointElements<D>& points) {
    const ProbeAxes<D> axes = probe_axes(s.frame, all.options);
    Probing<D> best{s.y, value_of(s.at, s.by_length != 0), {}};
    // All positions are evaluated in one loop, because the inlined evaluation is large.
    const int places = 1 + static_cast<int>(probe_positions.size());
    const int probe_count = any(near) ? places + pattern_search_iterations * D * 2 : places;
    for (int n = 0; n < probe_count; ++n) {
        Mask requested = open;
        VecPack<D> y;
        if (n == 0) {
            requested &= s.slope < 0;
            y = trial_of(s, all.options);
        } else if (n < places) {
            y = y_of(axes, probe_positions[static_cast<std::size_t>(n - 1)]);
        } else {
            const int round = (n - places) / (2 * D);
            const double radius = first_radius / (1 << round);
            const double side = (n - places) % 2 == 0 ? -radius : radius;
            const VecPack<D>& axis = axes.axis[static_cast<std::size_t>((n - places) / 2 % D)];
            requested = near;
            y = best.y;
            for (int i = 0; i < D; ++i) y[i] += side * axis[i];
        }
        look(all, s, requested, bounded(s.frame, y, all.options), points, best);
    }
    return best;
}

template <int D>
[[gnu::always_inline]] inline void start_search(const PackedEdges<D>& all, SearchPack<D>& s, Mask open,
                                                PointElements<D>& points) {
    const Mask by_length = s.by_length != 0;
    const Quadrature& rule = all.rules.objective;
    SymPack<D> hessian = multiple_of_identity<D>(packed(0));
    WalkMarks marks{.lost = ~open};
    s.at =
        located_values(all.back, {s.frame, s.y}, rule, points, marks,
                       [&](std::size_t q, const PointPack<D>& point, const VecPack<D>&) __attribute__((always_inline)) {
                           const double c = 4 * (1 - 2 * rule.t[q]);
                           const Pack root = sqrt(point.squared);
                           const Pack half = select(root > 0, 0.5 / root, packed(0));
                           const Pack weight = 2 * c * c * rule.w[q] * select(by_length, half, packed(1));
                           const MatPack<D>& r = point.log_metric.vectors;
                           for (int i = 0; i < D; ++i)
                               for (int j = 0; j <= i; ++j) {
                                   Pack m = packed(0);
                                   for (int k = 0; k < D; ++k) m += point.values[k] * r(i, k) * r(j, k);
                                   hessian(i, j) += weight * s.frame.scale[i] * s.frame.scale[j] * m;
                               }
                       });
    all.work.decompositions += count_of(open) * rule.size();
    s.inverse_hessian = inverse_of(hessian);
    const VecPack<D> gradient = gradient_of(s.at, by_length);
    const WallStep<D> step =
        step_within(s.wedge.rise, free_part(s, s.inverse_hessian, gradient, all.options), gradient, s.y);
    s.direction = step.step;
    s.slope = step.slope;
    s.step = reach(s, all.options);
    s.attempts = s.steps = packed(0);
}

}  // namespace camber
