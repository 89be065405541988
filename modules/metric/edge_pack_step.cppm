module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>
module camber.metric:edge_pack_step;
import :back_mesh;
import :edge_minimiser;
import :edge_objective;
import :quadrature;
import :straight_back;
import :packs;
import :edge_wedge;
import :edge_pack_objective;
import :edge_pack_location;
import :edge_pack_search;
import :edge_pack_lanes;
import :edge_pack_curvature;
import :edge_pack_begin;
import :edge_pack_shorten;
import camber.core;
import camber.bezier;

/// One evaluation of eight searches, within an element of the shell or anywhere in the mesh.
namespace camber {

/// The element of the shell across the wall that holds a lane, from its other vertex off the edge; none at the
/// boundary.
template <int D>
[[nodiscard]] ElementId across(const PackedEdges<D>& all, std::uint32_t edge, ElementId element, int wall) {
    const auto& [a, b, shell] = all.edges[edge];
    VertexId kept;
    int n = 0;
    for (const VertexId v : all.back.mesh.elements.vertices[element]) {
        if (v == a || v == b) continue;
        if (n++ != wall) kept = v;
    }
    for (const ElementId e : shell) {
        if (e == element) continue;
        const auto& v = all.back.mesh.elements.vertices[e];
        if (D == 2 || std::ranges::find(v, kept) != v.end()) return e;
    }
    return {};
}

/// Lanes that ended on one wall go on beyond it where that promises something; those that do.
template <int D>
[[nodiscard, gnu::always_inline]] inline Mask crossed(const PackedEdges<D>& all, SearchLanes<D>& lanes,
                                                      const WallStep<D>& held, Mask ended) {
    SearchPack<D>& s = lanes.pack;
    Mask wanted = ended & (s.crossings < max_crossings);
    if constexpr (D == 2)
        wanted &= held.held[0];
    else
        wanted &= held.held[0] ^ held.held[1];
    if (!any(wanted)) return wanted;
    std::array<ElementId, pack_size> elements = lanes.element;
    std::array<VertexId, pack_size> a;
    std::array<VertexId, pack_size> b;
    for (int lane = 0; lane < pack_size; ++lane) {
        a[lane] = all.edges[lanes.edge[lane]].a;
        b[lane] = all.edges[lanes.edge[lane]].b;
        if (wanted[lane] == 0) continue;
        const ElementId next = across(all, lanes.edge[lane], elements[lane], held.held[0][lane] != 0 ? 0 : 1);
        if (next.valid())
            elements[lane] = next;
        else
            wanted[lane] = 0;
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
    wanted &= -step.slope > all.options.tolerance * value_of(s.at, by_length);
    choose(wanted, s.wedge, wedge);
    choose(wanted, s.at, at);
    choose(wanted, s.inverse_hessian, inverse_hessian);
    choose(wanted, s.direction, step.step);
    s.slope = select(wanted, step.slope, s.slope);
    s.crossings += select(wanted, packed(1), packed(0));
    for (int lane = 0; lane < pack_size; ++lane)
        if (wanted[lane] != 0) lanes.element[lane] = elements[lane];
    return wanted;
}

/// The parabola in one element of the shell: nothing is located.
template <int D>
struct WithinWedge {
    EdgeSums<D> sums;
    LengthHessian<D> length_hessian;  ///< of the curve that was looked at, where the length is asked for

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
    /// How far the parabola's bulge changes log M.
    [[nodiscard, gnu::always_inline]] static inline Pack bulge(const SearchLanes<D>& lanes) {
        const SymPack<D> change = parabola(lanes.pack.frame, lanes.pack.wedge, lanes.pack.y).change;
        return sqrt(inner(change, change));
    }
    /// A gain by the search's own rule above this is one by any finer rule.
    [[nodiscard, gnu::always_inline]] static inline Pack sure_gain(const PackedEdges<D>& all,
                                                                   const SearchLanes<D>& lanes) {
        const SearchPack<D>& s = lanes.pack;
        if (all.rules.objective.size() < min_points) return packed(1e300);
        return min_gain * s.chord_length + s.chord_unsure + unsure_share(s.sums) * s.at.length;
    }
    [[nodiscard, gnu::always_inline]] static inline Mask goes_on(const PackedEdges<D>& all, SearchLanes<D>& lanes,
                                                                 const WallStep<D>& held, Mask ended) {
        return crossed(all, lanes, held, ended);
    }
    /// Lanes whose values are not those of the field.
    [[nodiscard, gnu::always_inline]] static inline Mask extrapolates(const SearchPack<D>& s) {
        return beyond_ends(s, s.y) > 0;
    }
};

/// Anywhere in the mesh, point by point.
template <int D>
struct ThroughElements {
    PointElements<D>& points;
    LengthHessian<D> length_hessian{};

    [[nodiscard, gnu::always_inline]] inline EdgeValues<D> values(const PackedEdges<D>& all, SearchLanes<D>& lanes,
                                                                  const VecPack<D>& y, WalkMarks& marks) {
        const Quadrature& rule = all.rules.objective;
        const bool is_length = all.options.objective == EdgeObjectiveKind::length;
        return located_values(all.back, lanes.pack.frame, y, rule, points, marks,
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
    [[nodiscard, gnu::always_inline]] static inline Mask goes_on(const PackedEdges<D>&, SearchLanes<D>&,
                                                                 const WallStep<D>&, Mask) {
        return {};
    }
    [[nodiscard, gnu::always_inline]] static inline Mask extrapolates(const SearchPack<D>&) { return {}; }
};

/// y of the lanes whose last step does not leave their element.
template <int D>
[[gnu::always_inline]] inline void take_last_step(SearchPack<D>& s, Mask lanes, const VecPack<D>& direction,
                                                  const EdgeMinimiserOptions& options) {
    if (!any(lanes)) return;
    choose(lanes, s.direction, direction);
    s.step = select(lanes, reach(s, options), s.step);
    choose(lanes & ~leaves(s, options), s.y, trial_of(s, options));
}

/// The way from the chord to y as the next step, with the curvature that is known by now.
template <int D>
[[gnu::always_inline]] inline void begin_again_towards(SearchPack<D>& s, Mask lanes) {
    choose(lanes, s.direction, s.y);
    choose(lanes, s.y, VecPack<D>{});
    choose(lanes, s.at, s.on_chord);
    s.slope = select(lanes, dot(gradient_of(s.at, s.by_length != 0), s.direction), s.slope);
    s.step = select(lanes, packed(1), s.step);
    s.attempts = select(lanes, packed(0), s.attempts);
}

struct Ended {
    Mask ended{}, exhausted{}, kinked{};
    Mask leaves{};  ///< not ended: to go on another way
};

/// One evaluation of each search.
template <int D, class Where>
[[nodiscard, gnu::always_inline]] inline Ended stepped(const PackedEdges<D>& all, SearchLanes<D>& lanes, Where where) {
    SearchPack<D>& s = lanes.pack;
    const EdgeMinimiserOptions& o = all.options;
    const bool is_length = o.objective == EdgeObjectiveKind::length;
    const bool shortens = is_length || o.length_tolerance > 0;
    const Mask by_length = s.by_length != 0;
    const VecPack<D> trial = trial_of(s, o);
    Ended out;
    WalkMarks marks{.lost = s.busy == 0};
    const EdgeValues<D> at = where.values(all, lanes, trial, marks);
    const Mask busy = (s.busy != 0) & ~marks.lost;
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
    const Mask accepted = busy & ((value < from + 1e-4 * s.step * s.slope) | (bounded & (value < from)));
    const Mask rejected = (s.busy != 0) & ~accepted;
    // A trial that was too far, or beyond a kink, tells of the curvature on the way as well as one that was taken.
    const Mask told = rejected & busy & (dot(moved, change) > 0);
    update_inverse_hessian(s.inverse_hessian, accepted | told, moved, change);
    choose(accepted, s.y, trial);
    choose(accepted, s.at, at);
    where.keep(lanes, accepted);
    const VecPack<D> gradient = gradient_of(s.at, by_length);
    const WallStep<D> next = step_within(s.wedge.rise, free_part(s, s.inverse_hessian, gradient, o), gradient, s.y);
    const Mask last_phase = by_length & Mask(is_length ? 0 : -1);
    // What is shorter beyond doubt has to stay so; and the length from afar has no Hessian that would tell.
    const Pack gain = s.chord_length - s.at.length;
    const Pack sure = where.sure_gain(all, lanes);
    const Mask doubtful = (gain > sure) & (gain < sure + 2 * last_step * s.chord_length);
    const auto is_near = [&](const VecPack<D>& step) __attribute__((always_inline)) {
        const Pack share = dot(step, step) / s.at.energy;
        return (share < max_blind_step) & ((gain <= sure) | (share * s.chord_length < 2 * (gain - sure)));
    };
    const Mask by_near_length = (is_length ? s.probed == 0 : Mask(0)) & is_near(next.step);
    const Mask loose = ~doubtful & (~by_length | by_near_length);
    const Pack last = packed(is_length ? last_step_of_length : last_step);
    const Mask rough = where.extrapolates(s);
    const Pack least = select(rough, packed(std::max(o.tolerance, rough_last_step)),
                              select(loose, max(packed(o.tolerance), last), packed(o.tolerance)));
    const Pack tolerance = select(last_phase, packed(o.length_tolerance), least) * value_of(s.at, by_length);
    const Mask minimal = ~(-next.slope > tolerance);
    const Mask converged = accepted & (minimal | (from - value < 0.1 * tolerance));
    s.steps += select(accepted, packed(1), packed(0));
    const Pack most = select(last_phase, packed(max_length_steps), packed(o.max_iterations));
    out.exhausted = accepted & ~converged & (s.steps >= most);
    s.attempts = select(accepted, packed(0), s.attempts + 1);
    const Mask stuck = rejected & ((s.attempts >= max_attempts) | (told & minimal));
    const Mask back = rejected & ~told;
    s.step = select(back, 0.3 * s.step, s.step);
    const Mask turned = accepted | told;
    choose(turned, s.direction, next.step);
    s.slope = select(turned, next.slope, s.slope);

    out.ended = converged | out.exhausted | stuck;
    Mask held = next.held[0];
    if constexpr (D == 3) held |= next.held[1];
    const Mask on = where.goes_on(all, lanes, next, (converged | stuck) & ~last_phase);
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
        const Mask blind = loose & is_near(step.step);
        const Pack enough = is_length ? select(blind, least, packed(o.tolerance)) : packed(o.length_tolerance);
        const Mask go = turns & (-step.slope > enough * s.at.length);
        choose(go, s.direction, step.step);
        choose(go, s.inverse_hessian, inverse_hessian);
        s.slope = select(go, step.slope, s.slope);
        s.steps = select(go, packed(0), s.steps);
        s.by_length = select(go, packed(1), s.by_length);
        if (is_length) choose(turns & blind & ~go, last_way, step.step);
        out.ended &= ~go;
        renewed |= go;
        s.attempts = select(go, packed(0), s.attempts);
    }
    s.attempts = select(afresh, packed(0), s.attempts);
    const Pack share = reach(s, o);
    s.step = select(renewed, share, s.step);
    const Mask blocked = renewed & (share < blocked_step);
    out.kinked = (out.ended & (stuck | held)) | blocked;
    out.ended |= blocked;
    out.leaves = renewed & ~out.ended & leaves(s, o);
    take_last_step(s, converged & out.ended & (loose | rough), last_way, o);
    const Mask away = (out.ended | out.leaves) & where.extrapolates(s);
    if (any(away)) {
        begin_again_towards(s, away);
        out.leaves |= away;
        out.ended &= ~away;
    }
    return out;
}

}  // namespace camber
