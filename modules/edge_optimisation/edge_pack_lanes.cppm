module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>
module camber.edge_optimisation:edge_pack_lanes;
import camber.core;
import camber.bezier;
import camber.metric;
import :edge_minimiser;
import :edge_pack_location;
import :edge_pack_objective;

/// Eight simultaneous searches, and quasi-Newton steps in each lane.
namespace camber {

/// A search counts as blocked if a bound shortens its step to less than this share.
inline constexpr double blocked_step = 1e-3;
/// |y| of an offset of metric length 1: sqrt(energy_curvature).
inline constexpr double unit_offset = 3.2659863237109041;
inline constexpr int max_attempts = 8;
/// Relative tolerance of equal lengths.
inline constexpr double length_rounding = 1e-11;
inline constexpr int max_crossings = 6;
inline constexpr int max_length_steps = 5;
/// An energy step with a smaller predicted relative decrease is the last and is not evaluated
/// (docs/algorithms/edge-minimisation.md).
inline constexpr double last_step = 3e-4;
/// The same for steps from the energy's minimum to the length's.
inline constexpr double last_step_of_length = 2e-4;
/// Maximum |y|² of a step that is not evaluated, as a share of the energy. The gain limits it too, because the length
/// model is inaccurate along the edge.
inline constexpr double max_blind_step = 0.02;
/// The value of `last_step` in an extrapolated field, where the step is evaluated.
inline constexpr double extrapolated_last_step = 1e-1;

/// Parabolas that leave their element near an end by less than this (in chords) are first searched in the extrapolated
/// field of the element.
inline constexpr double max_extrapolation = 8;

/// A search starts from the chord if log M changes by at most this along the chord, to the shell's vertices and to the
/// node. Other edges do not resolve the field, so other positions are probed first.
inline constexpr double max_change = 3;
/// Above this change of log M (a size factor of 50), slopes do not predict steps.
inline constexpr double max_change_for_slopes = 8;
/// Smaller relative gains are ignored. Larger gains are accepted if the rule has at least `min_points` points and the
/// gain exceeds the uncertainty of the length or, with kinks, `sure_share_with_kinks` times max(1, change of log M
/// squared) (docs/algorithms/edge-minimisation.md).
inline constexpr double min_gain = 1e-6;
inline constexpr std::size_t min_points = 4;
inline constexpr double sure_share_with_kinks = 0.03;

template <int D>
struct SearchPack {
    ChordFrame<D> frame;
    Pack chord_length{}, chord_unsure{};
    VecPack<D> y;
    EdgeValues<D> at;  ///< energy, length and gradients at y
    VecPack<D> direction;
    SymPack<D> inverse_hessian;
    Pack slope{}, step{}, attempts{}, steps{}, crossings{};
    Pack by_length{}, running{};  ///< 1: true, 0: false
    Pack change{};
    Pack along{};
    Pack probed{};  ///< 1: positions were probed
    // The next two members are valid while the search uses the field of one element.
    WedgePack<D> wedge;
    EdgeSums<D> sums;
    EdgeValues<D> on_chord;
};
template <int D>
struct SearchLanes {
    SearchPack<D> pack{};
    std::array<std::uint32_t, pack_size> edge{};
    std::array<ElementId, pack_size> element{};

    [[gnu::always_inline]] inline void set_default_elements() { element.fill(ElementId(std::size_t{0})); }
};

template <int D>
[[gnu::always_inline]] inline void copy_packs(SearchLanes<D>& to, std::size_t to_lane, const SearchLanes<D>& from,
                                              std::size_t from_lane, std::size_t size) {
    auto* const out = reinterpret_cast<std::byte*>(&to.pack);
    const auto* const in = reinterpret_cast<const std::byte*>(&from.pack);
    for (std::size_t at = 0; at < size; at += sizeof(Pack))
        std::memcpy(out + at + to_lane * sizeof(double), in + at + from_lane * sizeof(double), sizeof(double));
    to.edge[to_lane] = from.edge[from_lane];
    to.element[to_lane] = from.element[from_lane];
}
template <int D>
[[gnu::always_inline]] inline void copy_lane(SearchLanes<D>& to, std::size_t to_lane, const SearchLanes<D>& from,
                                             std::size_t from_lane) {
    copy_packs(to, to_lane, from, from_lane, sizeof(SearchPack<D>));
}
template <int D>
[[gnu::always_inline]] inline void copy_leaving(SearchLanes<D>& to, std::size_t to_lane, const SearchLanes<D>& from,
                                                std::size_t from_lane) {
    copy_packs(to, to_lane, from, from_lane, offsetof(SearchPack<D>, wedge));
}

template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> multiple_of_identity(Pack x) {
    SymPack<D> s;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) s(i, j) = i == j ? x : packed(0);
    return s;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack value_of(const EdgeValues<D>& at, Mask by_length) {
    return select(by_length, at.length, at.energy);
}
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> gradient_of(const EdgeValues<D>& at, Mask by_length) {
    VecPack<D> g;
    for (int i = 0; i < D; ++i) g[i] = select(by_length, at.length_gradient[i], at.energy_gradient[i]);
    return g;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack norm(const VecPack<D>& v) {
    return sqrt(dot(v, v));
}

/// Inverse Hessian in the free directions, which are tangential to active bounds.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> free_part(const SearchPack<D>& s, SymPack<D> h,
                                                              const VecPack<D>& gradient,
                                                              const EdgeMinimiserOptions& options) {
    const auto hold = [&](Mask on, const VecPack<D>& outwards) __attribute__((always_inline)) {
        if (!any(on)) return;
        const VecPack<D> moved = times(h, outwards);
        const Mask pressed = on & (dot(moved, gradient) < 0);
        const Pack scale = select(pressed, 1 / dot(outwards, moved), packed(0));
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) h(i, j) -= select(pressed, scale * moved[i] * moved[j], packed(0));
    };
    hold(norm(s.y) >= options.max_offset * unit_offset * (1 - 1e-9), s.y);
    const Pack shift = dot(s.frame.shift, s.y);
    VecPack<D> outwards;
    for (int i = 0; i < D; ++i) outwards[i] = copysign(packed(1), shift) * s.frame.shift[i];
    hold(abs(shift) >= options.max_tangential_shift * (1 - 1e-9), outwards);
    return h;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack reach(const SearchPack<D>& s, const EdgeMinimiserOptions& options) {
    const Pack shift = dot(s.frame.shift, s.y);
    const Pack change = dot(s.frame.shift, s.direction);
    const Pack share = (copysign(packed(options.max_tangential_shift), change) - shift) / change;
    return max(select((change != 0) & (share < 1), share, packed(1)), packed(0));
}

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> trial_of(const SearchPack<D>& s,
                                                             const EdgeMinimiserOptions& options) {
    VecPack<D> y;
    for (int i = 0; i < D; ++i) y[i] = s.y[i] + s.step * s.direction[i];
    const double most = options.max_offset * unit_offset;
    const Pack length = norm(y);
    const Pack step_scale = select(length > most, most / length, packed(1));
    for (int i = 0; i < D; ++i) y[i] *= step_scale;
    return y;
}

/// Distance, in chords, by which a parabola leaves its element near an end: 0 if the end's coordinate changes by at
/// least −1/4.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack beyond_ends(const SearchPack<D>& s, const VecPack<D>& y) {
    const Pack b = dot(s.wedge.rise_b, y);
    Pack a = -b;
    for (int n = 0; n < D - 1; ++n) a -= dot(s.wedge.rise[n], y);
    return max(-min(a, b) - 0.25, packed(0));
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Mask leaves(const SearchPack<D>& s, const EdgeMinimiserOptions& options) {
    return beyond_ends(s, trial_of(s, options)) > max_extrapolation;
}

template <int D>
[[gnu::always_inline]] inline void update_inverse_hessian(SymPack<D>& h, Mask lanes, const VecPack<D>& s,
                                                          const VecPack<D>& d) {
    const Pack sd = dot(s, d);
    const Mask update = lanes & (sd > 1e-10 * sqrt(dot(s, s) * dot(d, d)));
    const VecPack<D> hd = times(h, d);
    const Pack scale = 1 / sd;
    const Pack factor = (1 + dot(d, hd) * scale) * scale;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            h(i, j) = select(update, h(i, j) + (factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) * scale), h(i, j));
}

template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, ObjectiveSums<D>& to, const ObjectiveSums<D>& from) {
    to.value = select(mask, from.value, to.value);
    choose(mask, to.common, from.common);
    choose(mask, to.adjoint, from.adjoint);
}
template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, EdgeValues<D>& to, const EdgeValues<D>& from) {
    to.energy = select(mask, from.energy, to.energy);
    to.length = select(mask, from.length, to.length);
    to.bulge = select(mask, from.bulge, to.bulge);
    choose(mask, to.energy_gradient, from.energy_gradient);
    choose(mask, to.length_gradient, from.length_gradient);
}
template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, ShellElementPack<D>& to, const ShellElementPack<D>& from) {
    for (int n = 0; n < D - 1; ++n) {
        choose(mask, to.rise[n], from.rise[n]);
        to.along[n] = select(mask, from.along[n], to.along[n]);
        choose(mask, to.change[n], from.change[n]);
    }
}
template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, WedgePack<D>& to, const WedgePack<D>& from) {
    for (int n = 0; n < D - 1; ++n) {
        choose(mask, to.rise[n], from.rise[n]);
        choose(mask, to.change[n], from.change[n]);
    }
    choose(mask, to.rise_b, from.rise_b);
}
template <int D>
[[nodiscard, gnu::always_inline]] inline Mask after(const VecPack<D>& a, const VecPack<D>& b) {
    Mask equal = a[0] == b[0];
    Mask greater = a[0] > b[0];
    for (int i = 1; i < D; ++i) {
        greater |= equal & (a[i] > b[i]);
        equal &= a[i] == b[i];
    }
    return greater;
}

}  // namespace camber

/// Initial Hessian of the energy ∫ |r|², r = exp(L/2) l'. The identity (frozen metric) gives far too long steps if log
/// M changes much; the Gauss–Newton term 2 ∫ ∂rᵀ ∂r includes this change. At the chord midpoint L is diagonal and l'
/// constant: ∂r = 4t(1−t) J, J_km = ½ Σ_i F_ki (∂_m L)_ki c_i, with divided differences F of exp(x/2).
namespace camber {

/// 2 ∫ (4t(1−t))² dt = 16/15, doubled because the omitted term r·∂²r is as large for constant axes.
inline constexpr double bulge_curvature = 2 * 16.0 / 15;

/// F_ij = (e^{λ_i/2} − e^{λ_j/2})/(λ_i/2 − λ_j/2) at the midpoint.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> divided_roots(const ChordFrame<D>& f) {
    VecPack<D> root;
    VecPack<D> half;
    for (int i = 0; i < D; ++i) {
        root[i] = 1 / (unit_offset * f.scale[i]);
        half[i] = 0.5 * f.log_metric(i, i) + 0.25 * f.change(i, i);
    }
    SymPack<D> divided;
    for (int i = 0; i < D; ++i) {
        divided(i, i) = root[i];
        for (int j = 0; j < i; ++j) {
            const Pack x = half[i] - half[j];
            const Mask near = abs(x) < 1e-3;
            const Pack apart = (root[i] - root[j]) / select(near, packed(1), x);
            divided(i, j) = select(near, 0.5 * (root[i] + root[j]), apart);
        }
    }
    return divided;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> bulge_jacobian(const ChordFrame<D>& f, const WedgePack<D>& w) {
    const SymPack<D> divided = divided_roots(f);
    MatPack<D> jacobian;
    const auto add = [&](const SymPack<D>& change, const VecPack<D>& rise) __attribute__((always_inline)) {
        for (int k = 0; k < D; ++k) {
            Pack sum = divided(k, 0) * change(k, 0) * f.chord[0];
            for (int i = 1; i < D; ++i) sum += divided(k, i) * change(k, i) * f.chord[i];
            for (int m = 0; m < D; ++m) jacobian(k, m) += 0.5 * sum * rise[m];
        }
    };
    add(f.change, w.rise_b);
    for (int n = 0; n < D - 1; ++n) add(w.change[n], w.rise[n]);
    return jacobian;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> inverse_by_cofactors(const SymPack<D>& h) {
    SymPack<D> out;
    Pack determinant;
    if constexpr (D == 2) {
        out(0, 0) = h(1, 1);
        out(1, 0) = -h(1, 0);
        out(1, 1) = h(0, 0);
        determinant = h(0, 0) * h(1, 1) - h(1, 0) * h(1, 0);
    } else {
        out(0, 0) = h(1, 1) * h(2, 2) - h(2, 1) * h(2, 1);
        out(1, 0) = h(2, 1) * h(2, 0) - h(1, 0) * h(2, 2);
        out(2, 0) = h(1, 0) * h(2, 1) - h(1, 1) * h(2, 0);
        out(1, 1) = h(0, 0) * h(2, 2) - h(2, 0) * h(2, 0);
        out(2, 1) = h(1, 0) * h(2, 0) - h(0, 0) * h(2, 1);
        out(2, 2) = h(0, 0) * h(1, 1) - h(1, 0) * h(1, 0);
        determinant = h(0, 0) * out(0, 0) + h(1, 0) * out(1, 0) + h(2, 0) * out(2, 0);
    }
    const Pack scale = 1 / determinant;
    for (int k = 0; k < sym_size<D>; ++k) out.c[k] *= scale;
    return out;
}

/// For a higher curvature cofactors lose too many digits, and steps start with the identity.
inline constexpr double max_bulge_curvature = 1e6;

template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> inverse_hessian_at_chord(const ChordFrame<D>& f,
                                                                             const WedgePack<D>& w) {
    const MatPack<D> jacobian = bulge_jacobian(f, w);
    SymPack<D> h;
    Pack trace = packed(0);
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j < i; ++j) h(i, j) = bulge_curvature * dot(jacobian.column[i], jacobian.column[j]);
        h(i, i) = 1 + bulge_curvature * dot(jacobian.column[i], jacobian.column[i]);
        trace += h(i, i);
    }
    SymPack<D> inverse = multiple_of_identity<D>(packed(1));
    choose(trace < max_bulge_curvature, inverse, inverse_by_cofactors(h));
    return inverse;
}

}  // namespace camber

/// Start of eight searches in the best sectors.
namespace camber {

template <int D>
struct PackedEdges {
    const StraightBack<D>& back;
    std::span<const BackEdge> edges;
    std::span<const FreeEdge<D>> free;
    const CurvedBack<D>* curved;
    std::span<const std::uint32_t> order;
    const EdgeRules& rules;
    const EdgeMinimiserOptions& options;
    std::span<EdgeMinimum<D>> minima;
    std::span<std::uint8_t> alone;  ///< 1: individual search; 2: individual final test
    EdgeSearchWork& work;
};

template <int D>
struct BestSector {
    ShellElementPack<D> element;
    VecPack<D> step;
    Pack slope{};
    Pack slot{};
    Pack change{};
};

template <int D>
[[nodiscard, gnu::always_inline]] inline BestSector<D> best_sector(const PackedEdges<D>& all,
                                                                   const std::array<std::uint32_t, pack_size>& lanes,
                                                                   const ChordPack<D>& chords, const ChordFrame<D>& f,
                                                                   const ObjectiveSums<D>& sums, Pack curvature) {
    // R A Rᵀ.
    MatPack<D> transposed;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) transposed(i, j) = f.axes(j, i);
    const SymPack<D> adjoint = congruence_transposed(transposed, sums.adjoint);
    const Pack by_b = inner(adjoint, chords.change);
    VecPack<D> common;
    for (int i = 0; i < D; ++i) common[i] = f.scale[i] * sums.common[i] + f.shift[i] * by_b;
    std::size_t most = 0;
    for (const std::uint32_t e : lanes) most = std::max(most, all.edges[e].shell.size());
    const SymPack<D> inverse_hessian = multiple_of_identity<D>(curvature);
    BestSector<D> best{};
    for (std::size_t slot = 0; slot < most; ++slot) {
        std::array<ElementId, pack_size> elements;
        for (int lane = 0; lane < pack_size; ++lane) {
            const auto& shell = all.edges[lanes[lane]].shell;
            elements[lane] = shell[std::min(slot, shell.size() - 1)];
        }
        const ShellElementPack<D> element = shell_elements(all.back, chords, elements);
        std::array<VecPack<D>, D - 1> rise;
        VecPack<D> gradient = common;
        for (int n = 0; n < D - 1; ++n) {
            rise[n] = in_frame(f, element.rise[n]);
            best.change = max(best.change, inner(element.change[n], element.change[n]));
            const Pack by_n = inner(adjoint, element.change[n]) - element.along[n] * by_b;
            for (int i = 0; i < D; ++i) gradient[i] += by_n * rise[n][i];
        }
        const WallStep<D> step = step_within<D>(rise, inverse_hessian, gradient, {});
        const Mask better = (step.slope < best.slope) | ((step.slope == best.slope) & after(step.step, best.step));
        choose(better, best.element, element);
        choose(better, best.step, step.step);
        best.slope = select(better, step.slope, best.slope);
        best.slot = select(better, packed(static_cast<double>(slot)), best.slot);
    }
    best.change = sqrt(best.change);
    return best;
}

template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, BestSector<D>& to, const BestSector<D>& from) {
    choose(mask, to.element, from.element);
    choose(mask, to.step, from.step);
    to.slope = select(mask, from.slope, to.slope);
    to.slot = select(mask, from.slot, to.slot);
    to.change = select(mask, from.change, to.change);
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack change_of(const SearchPack<D>& s) {
    return sqrt(inner(s.frame.change, s.frame.change));
}

/// Prepares the searches. Edges that do not resolve the field are not busy, because other positions are probed first.
template <int D>
[[gnu::always_inline]] inline void begin(const PackedEdges<D>& all, const std::array<std::uint32_t, pack_size>& lanes,
                                         int count, SearchLanes<D>& out) {
    SearchPack<D>& s = out.pack;
    s.y = {};
    s.attempts = s.steps = s.crossings = s.by_length = s.probed = packed(0);
    out.edge = lanes;
    std::array<VertexId, pack_size> a;
    std::array<VertexId, pack_size> b;
    for (int lane = 0; lane < pack_size; ++lane) {
        a[lane] = all.edges[lanes[lane]].a;
        b[lane] = all.edges[lanes[lane]].b;
    }
    const ChordPack<D> chords = chords_of(all.back, a, b);
    s.frame = chord_frame(chords);
    s.sums = sums_along(s.frame, ParabolaPack<D>{}, all.rules.objective);
    s.chord_length = s.sums.length.value;
    s.chord_unsure = unsure_share(s.sums) * s.chord_length;
    s.along = change_of(s);
    s.inverse_hessian = multiple_of_identity<D>(packed(1));
    BestSector<D> best = best_sector(all, lanes, chords, s.frame, s.sums.energy, packed(1));
    s.change = max(s.along, best.change);
    const Mask unresolved = ~(s.change < max_change);
    if (all.options.objective == EdgeObjectiveKind::length && any(unresolved)) {
        // Edges that do not resolve the field start with the length.
        const Pack curvature = 2 * s.chord_length;
        choose(unresolved, best, best_sector(all, lanes, chords, s.frame, s.sums.length, curvature));
        choose(unresolved, s.inverse_hessian, multiple_of_identity<D>(curvature));
        s.by_length = select(unresolved, packed(1), packed(0));
    }
    s.wedge = wedge_of(s.frame, best.element);
    s.at = s.on_chord = values_in(s.frame, s.wedge, s.sums);
    s.direction = best.step;
    s.slope = best.slope;
    // The sector is selected with the identity; the first step uses the actual curvature.
    choose(~unresolved, s.inverse_hessian, inverse_hessian_at_chord(s.frame, s.wedge));
    const WallStep<D> first = step_within<D>(s.wedge.rise, s.inverse_hessian, s.at.energy_gradient, s.y);
    choose(~unresolved, s.direction, first.step);
    s.slope = select(~unresolved, first.slope, s.slope);
    s.step = reach(s, all.options);
    const Mask promising = -s.slope > all.options.tolerance * value_of(s.at, s.by_length != 0);
    for (int lane = 0; lane < pack_size; ++lane) {
        out.element[lane] = all.edges[lanes[lane]].shell[static_cast<std::size_t>(best.slot[lane])];
        const bool regular = s.chord_length[lane] > 0 && s.chord_length[lane] < 1e300 && s.change[lane] < 1e300;
        if (!regular) all.alone[lanes[lane]] = 1;
        if (!regular || lane >= count) s.change[lane] = 0;
        const bool resolved = s.change[lane] < max_change;
        s.running[lane] = promising[lane] != 0 && regular && resolved && lane < count ? 1 : 0;
    }
    all.work.decompositions += static_cast<std::size_t>(count) * (1 + all.rules.objective.size());
}

}  // namespace camber

/// Start of eight searches for edges that are not in the back mesh, at located points of the chord. The first step is
/// minus the gradient, because the frozen-metric Hessian is the identity. This is the first geodesic step.
namespace camber {

template <int D>
[[nodiscard, gnu::always_inline]] inline ChordPack<D> chords_of(const PackedEdges<D>& all,
                                                                const std::array<std::uint32_t, pack_size>& lanes) {
    ChordPack<D> c{};
    for (int lane = 0; lane < pack_size; ++lane) {
        const FreeEdge<D>& edge = all.free[lanes[lane]];
        put(c.origin, lane, edge.a.point);
        put(c.chord, lane, edge.b.point - edge.a.point);
        put(c.log_metric, lane, edge.a.log_metric.l);
        put(c.change, lane, edge.b.log_metric.l - edge.a.log_metric.l);
    }
    return c;
}

template <int D>
[[nodiscard]] bool is_curved(const PackedEdges<D>& all, const PointElements<D>& points, int lane) {
    return all.curved != nullptr &&
           std::ranges::any_of(points, [&](const auto& at) { return all.curved->is_curved(at.element[lane]); });
}

/// The change of log M is known only at the points of the chord.
template <int D>
[[nodiscard, gnu::always_inline]] inline SearchLanes<D> started_at_chords(
    const PackedEdges<D>& all, const std::array<std::uint32_t, pack_size>& lanes, int count) {
    SearchLanes<D> out{};
    SearchPack<D>& s = out.pack;
    out.edge = lanes;
    for (int lane = 0; lane < pack_size; ++lane) out.element[lane] = all.free[lanes[lane]].hint;
    s.frame = chord_frame(chords_of(all, lanes));
    const std::size_t n_points = all.rules.objective.size();
    const ElementsPack<D> at = entered<D>(all.back, out.element);
    PointElements<D> points{};
    for (std::size_t q = 0; q < max_points; ++q) points[q] = at;
    WalkMarks marks{};
    s.at = located_values(all.back, {s.frame, s.y}, all.rules.objective, points, marks);
    s.chord_length = s.at.length;
    s.change = change_of(s) + sqrt(s.at.bulge);
    for (std::size_t q = 0; q < n_points; ++q)
        for (const SymPack<D>& change : points[q].change) s.change = max(s.change, sqrt(inner(change, change)));
    s.along = s.change;
    // Edges that do not resolve the field start with the length if that is the objective.
    const Mask by_length = ~(s.change < max_change) & Mask(all.options.objective == EdgeObjectiveKind::length ? -1 : 0);
    s.by_length = select(by_length, packed(1), packed(0));
    s.inverse_hessian = multiple_of_identity<D>(select(by_length, 2 * s.chord_length, packed(1)));
    const VecPack<D> gradient = gradient_of(s.at, by_length);
    s.direction = times(s.inverse_hessian, gradient);
    for (int i = 0; i < D; ++i) s.direction[i] = -s.direction[i];
    s.slope = dot(gradient, s.direction);
    s.step = reach(s, all.options);
    const Mask promising = -s.slope > all.options.tolerance * value_of(s.at, by_length);
    const Mask found =
        ~(marks.lost | marks.outside) & (s.chord_length > 0) & (s.chord_length < 1e300) & (s.change < 1e300);
    for (int lane = 0; lane < pack_size; ++lane) {
        const bool regular = found[lane] != 0 && !is_curved(all, points, lane);
        if (!regular) all.alone[lanes[lane]] = 1;
        if (!regular || lane >= count) s.change[lane] = 0;
        s.running[lane] = promising[lane] != 0 && regular && s.change[lane] < max_change && lane < count ? 1 : 0;
    }
    all.work.decompositions += static_cast<std::size_t>(count) * (1 + n_points);
    return out;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack chord_length(const PackedEdges<D>& all, const SearchLanes<D>& lanes,
                                                           WalkMarks& marks) {
    const ChordFrame<D>& f = lanes.pack.frame;
    if (all.free.empty()) return length_along(f, ParabolaPack<D>{}, all.rules.report);
    ElementsPack<D> elements = entered<D>(all.back, lanes.element);
    return located_lengths(all.back, {f, VecPack<D>{}}, all.rules.report, elements, marks).length;
}

}  // namespace camber
