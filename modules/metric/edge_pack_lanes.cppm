module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>
module camber.metric:edge_pack_lanes;
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
import camber.core;
import camber.bezier;

/// Eight searches for an edge's node under way, and a step of quasi-Newton in each lane.
namespace camber {

/// A bound that leaves no more of a step holds the node.
inline constexpr double blocked_step = 1e-3;
/// |y| of an offset of a unit of length: sqrt(energy_curvature).
inline constexpr double unit_offset = 3.2659863237109041;
inline constexpr int max_attempts = 8;
/// Lengths that differ by less are the same.
inline constexpr double length_rounding = 1e-11;
inline constexpr int max_crossings = 6;
inline constexpr int max_length_steps = 5;
/// A step of the energy that promises less than this share is the last, and taken unmeasured: by then the model is
/// near enough that what it leaves is a small part of that (docs/algorithms/edge-minimisation.md).
inline constexpr double last_step = 3e-4;
/// The same where the length is asked for, on the way from the energy's minimum to the length's.
inline constexpr double last_step_of_length = 2e-4;
/// And only where it is short, by |y|² as a share of the energy, and by what the edge has gained: along the edge the
/// model of the length tells little.
inline constexpr double max_blind_step = 0.02;
/// The same where the field is only that of an element as it goes on beyond its ends: it is measured then.
inline constexpr double rough_last_step = 1e-1;

/// A parabola that leaves its element near an end by less than this, in chords, is searched in the field of that
/// element as it goes on beyond, and then from there in that of the mesh.
inline constexpr double max_beyond = 8;

/// What is searched from its chord: edges within which log M, along the chord, to the vertices of the shell and out to
/// the node, changes by less. Others are full of kinks and false minima, which the mesh does not resolve: they look at
/// other places first.
inline constexpr double max_change = 3;
/// Where log M changes by more than this, sizes by a factor of 50, slopes tell nothing of what is a step away.
inline constexpr double max_change_for_slopes = 8;
/// Gains below this share of the length are not asked for. Others are believed by a rule of as many points where they
/// are above what is not sure of the length, too, or, of curves with kinks, above that share times the square of what
/// log M changes by, if that is more than 1: of 100 000 curves in fields from smooth to random none was wrong by as
/// much (docs/algorithms/edge-minimisation.md).
inline constexpr double min_gain = 1e-6;
inline constexpr std::size_t min_points = 4;
inline constexpr double sure_share_with_kinks = 0.03;

/// Eight searches under way.
template <int D>
struct SearchPack {
    ChordFrame<D> frame;
    Pack chord_length{}, chord_unsure{};
    VecPack<D> y;
    EdgeValues<D> at;  ///< y
    VecPack<D> direction;
    SymPack<D> inverse_hessian;
    Pack slope{}, step{}, attempts{}, steps{}, crossings{};
    Pack by_length{}, busy{};  ///< 1 or 0
    Pack change{};             ///< the most that log M does within the shell
    Pack along{};              ///< what log M changes by along the chord
    Pack probed{};             ///< 1: has looked elsewhere
    // While the field is that of one element:
    WedgePack<D> wedge;
    EdgeSums<D> sums;        ///< `at` is of these
    EdgeValues<D> on_chord;  ///< where the search began
};
template <int D>
struct SearchLanes {
    SearchPack<D> pack{};
    std::array<std::uint32_t, pack_size> edge{};
    std::array<ElementId, pack_size> element{};

    /// Lanes without an edge look at some element too.
    [[gnu::always_inline]] inline void look_anywhere() { element.fill(ElementId(std::size_t{0})); }
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
/// Of a search that leaves its element, without what is of that.
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

/// The objective under way.
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

/// The inverse Hessian of those directions that the bounds leave free: on a bound that is pressed, tangent to it.
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

/// The share of a step by which the node stays within its shift.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack reach(const SearchPack<D>& s, const EdgeMinimiserOptions& options) {
    const Pack shift = dot(s.frame.shift, s.y);
    const Pack change = dot(s.frame.shift, s.direction);
    const Pack share = (copysign(packed(options.max_tangential_shift), change) - shift) / change;
    return max(select((change != 0) & (share < 1), share, packed(1)), packed(0));
}

/// y + step · direction, shortened to the largest offset.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> trial_of(const SearchPack<D>& s,
                                                             const EdgeMinimiserOptions& options) {
    VecPack<D> y;
    for (int i = 0; i < D; ++i) y[i] = s.y[i] + s.step * s.direction[i];
    const double most = options.max_offset * unit_offset;
    const Pack length = norm(y);
    const Pack kept = select(length > most, most / length, packed(1));
    for (int i = 0; i < D; ++i) y[i] *= kept;
    return y;
}

/// How far a parabola leaves its element near an end: 0 where that one's coordinate moves by −1/4 at most, as a share
/// of the chord beyond.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack beyond_ends(const SearchPack<D>& s, const VecPack<D>& y) {
    const Pack b = dot(s.wedge.rise_b, y);
    Pack a = -b;
    for (int n = 0; n < D - 1; ++n) a -= dot(s.wedge.rise[n], y);
    return max(-min(a, b) - 0.25, packed(0));
}

/// Whether the next trial's parabola leaves its element so far that the field there tells nothing of it.
template <int D>
[[nodiscard, gnu::always_inline]] inline Mask leaves(const SearchPack<D>& s, const EdgeMinimiserOptions& options) {
    return beyond_ends(s, trial_of(s, options)) > max_beyond;
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
/// Whether a is after b in the order of vectors.
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
