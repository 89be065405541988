module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
module camber.metric:edge_pack_probe;
import :back_mesh;
import :edge_minimiser;
import :quadrature;
import :packs;
import :edge_wedge;
import :edge_pack_objective;
import :edge_pack_location;
import :edge_pack_lanes;
import :edge_pack_begin;
import :edge_pack_shorten;
import camber.core;

/// Edges that do not resolve their field: the objective has many minima, each between kinks, and a descent ends in the
/// first. What pays there is to look at a few places that lie far apart, and to go on from the best of them.
namespace camber {

/// Places by where the node is off the middle: across the finest axis (along that the bounds leave nothing), in lengths
/// of the chord. `along`: in the direction nearest to the chord's, as far as the shift allows; `across` both.
struct ProbePlace {
    double along, across;
};
inline constexpr std::array probe_places{ProbePlace{1, -0.5}, ProbePlace{1, 1}, ProbePlace{-1, 0.5},
                                         ProbePlace{-1, -1}};
/// Then both ways along each axis from the best, by this share of the chord at first, and by half of that.
inline constexpr double first_radius = 0.5;
inline constexpr int compass_rounds = 2;

/// Steps of y by a length of the chord, orthogonal in space: the finest axis is the last; along that, if it is less, to
/// the bound.
template <int D>
struct ProbeAxes {
    std::array<VecPack<D>, D> axis;
    Pack max_along{};  ///< what the shift leaves of the first
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
    // To a chord along the finest axis no direction is nearest: any will do.
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

/// y moved into the bounds, as UnitFrame does.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> bounded(const ChordFrame<D>& f, VecPack<D> y,
                                                            const EdgeMinimiserOptions& options) {
    const double most = options.max_offset * unit_offset;
    const Pack length = norm(y);
    const Pack kept = select(length > most, most / length, packed(1));
    for (int i = 0; i < D; ++i) y[i] *= kept;
    const Pack shift = dot(f.shift, y);
    const Pack beyond = shift - copysign(packed(options.max_tangential_shift), shift);
    const Pack back = select(abs(shift) > options.max_tangential_shift, beyond / dot(f.shift, f.shift), packed(0));
    for (int i = 0; i < D; ++i) y[i] -= back * f.shift[i];
    return y;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> y_of(const ProbeAxes<D>& axes, const ProbePlace& place) {
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

/// The best y so far of some searches, which look at others.
template <int D>
struct Probing {
    VecPack<D> y;
    Pack value{};
    Mask found{};  ///< lower than where they began
};

template <int D>
[[gnu::always_inline]] inline void look(const PackedEdges<D>& all, const SearchPack<D>& s, Mask asked,
                                        const VecPack<D>& y, PointElements<D>& points, Probing<D>& best) {
    WalkMarks marks{.lost = ~asked};
    const Quadrature& rule = all.rules.objective;
    const EdgeValues<D> at = located_lengths_beside(all.back, s.frame, y, rule, points, marks);
    const Pack value = value_of(at, s.by_length != 0);
    const Mask lower = asked & ~marks.lost & ~marks.outside & (value < best.value);
    choose(lower, best.y, y);
    best.value = select(lower, value, best.value);
    best.found |= lower;
    all.work.decompositions += count_of(asked) * rule.size();
}

/// The best of the places and of the step that the search has before it; in lanes `near` then by a pattern search from
/// it.
template <int D>
[[nodiscard, gnu::always_inline]] inline Probing<D> probed(const PackedEdges<D>& all, const SearchPack<D>& s, Mask open,
                                                           Mask near, PointElements<D>& points) {
    const ProbeAxes<D> axes = probe_axes(s.frame, all.options);
    Probing<D> best{s.y, value_of(s.at, s.by_length != 0), {}};
    // One loop for all, since what looks is large.
    const int places = 1 + static_cast<int>(probe_places.size());
    const int looks = any(near) ? places + compass_rounds * D * 2 : places;
    for (int n = 0; n < looks; ++n) {
        Mask asked = open;
        VecPack<D> y;
        if (n == 0) {
            asked &= s.slope < 0;
            y = trial_of(s, all.options);
        } else if (n < places) {
            y = y_of(axes, probe_places[static_cast<std::size_t>(n - 1)]);
        } else {
            const int round = (n - places) / (2 * D);
            const double radius = first_radius / (1 << round);
            const double side = (n - places) % 2 == 0 ? -radius : radius;
            const VecPack<D>& axis = axes.axis[static_cast<std::size_t>((n - places) / 2 % D)];
            asked = near;
            y = best.y;
            for (int i = 0; i < D; ++i) y[i] += side * axis[i];
        }
        look(all, s, asked, bounded(s.frame, y, all.options), points, best);
    }
    return best;
}

/// A search of quasi-Newton from s.y, with the Hessian that it has with the metric frozen.
template <int D>
[[gnu::always_inline]] inline void start_there(const PackedEdges<D>& all, SearchPack<D>& s, Mask open,
                                               PointElements<D>& points) {
    const Mask by_length = s.by_length != 0;
    const Quadrature& rule = all.rules.objective;
    SymPack<D> hessian = multiple_of_identity<D>(packed(0));
    WalkMarks marks{.lost = ~open};
    s.at =
        located_values(all.back, s.frame, s.y, rule, points, marks,
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
