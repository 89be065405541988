module;
#include <array>
#include <cmath>
module camber.metric:edge_offset;
import :edge_accuracy;
import :edge_frame;
import :packs;
import camber.core;

/// The offset for accuracy of eight edges, by the axes and the sizes that they see.
namespace camber {

/// What changes by more than this within an edge is not resolved by it: the angle by which axes turn, in radians, and
/// the change of log M by sizes (a factor of 7 of a size).
inline constexpr double max_turn = 1;
inline constexpr double max_turn_of_ends = 1.2;
inline constexpr double max_resolved_change = 4;
/// The longest edge of a mesh that is unit for the metric has length √2; functions are not resolved by longer ones.
inline constexpr double unit_length_squared = 2;
/// The most that a node is shifted along its chord; at 1/4 the edge folds.
inline constexpr double max_shift = 0.2;

/// 1 where `change` is small beside `most`, 0 far beyond.
[[nodiscard, gnu::always_inline]] inline Pack resolved(Pack change, double most) {
    const Pack share = change / most;
    return 1 / (1 + share * share * share * share);
}

/// w(x): 1/|x| turns a change of L into an angle, where axis j is the finer one; nothing where both are alike, since
/// what turns there are no axes.
[[nodiscard, gnu::always_inline]] inline Pack turning(Pack x, Pack likeness) {
    const Pack unlike = 1 - likeness;
    return select(x == 0, packed(0), unlike * unlike / abs(x) * select(x > 0, likeness, packed(1)));
}

/// Level sets of the coordinates whose gradients the axes are: r_j·d = (change of r_j along e)·e/8. By both ends, whose
/// change is x tan α for axes that turn by α, as far as the tangents there ask for: (e/4) tan(α/2).
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_axes(const EdgeFrame<D>& f, ChangeAlong change) {
    VecPack<D> d;
    for (int j = 0; j < D; ++j) {
        d[j] = packed(0);
        for (int i = 0; i < D; ++i) {
            if (i == j) continue;
            Pack part = turning(f.x[i][j], f.likeness(i, j)) * f.along_chord(i, j) * f.chord[i] / 8;
            if (change == ChangeAlong::of_ends) {
                const Pack tangent = select(f.x[i][j] == 0, packed(0), f.along_chord(i, j) / f.x[i][j]);
                part *= 2 / (1 + sqrt(1 + tangent * tangent));
            }
            d[j] += part;
        }
    }
    // 8 |d|/|e| is the angle by which the axes turn. Where that is of both ends it is known as far as it is told from
    // one by which other axes came there.
    const Pack turn = 8 * sqrt(dot(d, d)) / sqrt(dot(f.chord, f.chord));
    const Pack kept = change == ChangeAlong::of_ends ? resolved(turn * turn, max_turn_of_ends * max_turn_of_ends)
                                                     : resolved(turn, max_turn);
    for (int j = 0; j < D; ++j) d[j] *= kept;
    return d;
}

/// Sizes of a Hessian, or of third derivatives: the geodesic's first step, [(∂_u L) u − ½ ∇(uᵀ L u)]/8, for each axis j
/// of what the chord has along axes that are like it, u = R K_j∘c: 8 d_j = r_jᵀ (∂_u L) u − ½ uᵀ (∂_{r_j} L) u.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_derivatives(const EdgeFrame<D>& f,
                                                                   const GradientPack<D>& gradient) {
    const MatPack<D>& r = f.log_metric.vectors;
    VecPack<D> d;
    for (int j = 0; j < D; ++j) {
        VecPack<D> like;
        for (int a = 0; a < D; ++a) like[a] = f.likeness(j, a) * f.chord[a];
        const VecPack<D> u = times(r, like);
        const Pack along = bilinear<D>(derivative<D>(gradient, u), r.column[j], u);
        const Pack across = bilinear<D>(derivative<D>(gradient, r.column[j]), u, u);
        d[j] = (along - across / 2) / 8;
    }
    return d;
}

/// Sizes that grow away from something: of u = f(φ), φ along the gradient γ of the mean log size of the axes that are
/// like axis j, as far as it is along such axes; 16 d_j = (γ·c)² γ_j/|γ|².
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_layers(const EdgeFrame<D>& f, const GradientPack<D>& gradient) {
    const MatPack<D>& r = f.log_metric.vectors;
    std::array<VecPack<D>, D> growth;  // growth[k][i]: of λ_i along axis k
    for (int k = 0; k < D; ++k) {
        const SymPack<D> along = derivative<D>(gradient, r.column[k]);
        for (int i = 0; i < D; ++i) growth[k][i] = bilinear<D>(along, r.column[i], r.column[i]);
    }
    VecPack<D> d;
    for (int j = 0; j < D; ++j) {
        Pack alike = packed(0), square = packed(0), along = packed(0), own = packed(0);
        for (int i = 0; i < D; ++i) alike += f.likeness(i, j);
        for (int k = 0; k < D; ++k) {
            Pack mean = packed(0);
            for (int i = 0; i < D; ++i) mean += f.likeness(i, j) * growth[k][i];
            mean *= f.likeness(j, k) / alike;
            square += mean * mean;
            along += mean * f.chord[k];
            if (k == j) own = mean;
        }
        d[j] = select(square > 0, along * along / square * own / 16, packed(0));
    }
    return d;
}

/// The part that sizes ask for, as far as it is resolved.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_sizes(const EdgeFrame<D>& f, const GradientPack<D>& gradient,
                                                             MetricKind kind) {
    VecPack<D> d = kind == MetricKind::natural ? by_layers<D>(f, gradient) : by_derivatives<D>(f, gradient);
    const Pack length = metric_length(f, f.chord);
    const Pack unit = min(unit_length_squared / (length * length), packed(1));
    // In one direction d = Δλ e/16.
    const Pack kept = unit * resolved(16 * metric_length(f, d) / length, max_resolved_change);
    for (int j = 0; j < D; ++j) d[j] *= kept;
    return d;
}

/// The recovered gradient, with the change along the chord that the ends tell: the least change of it, in the metric.
template <int D>
[[nodiscard, gnu::always_inline]] inline GradientPack<D> agreeing_with_ends(const EdgeFrame<D>& f,
                                                                            const EdgeSight<D>& middle,
                                                                            const VecPack<D>& chord) {
    VecPack<D> scaled;
    Pack square = packed(0);
    for (int j = 0; j < D; ++j) {
        scaled[j] = f.sizes[j] * f.chord[j];
        square += scaled[j] * f.chord[j];
    }
    const VecPack<D> covector = times(f.log_metric.vectors, scaled);
    const SymPack<D> along = derivative<D>(middle.gradient, chord);
    GradientPack<D> gradient = middle.gradient;
    for (int k = 0; k < sym_size<D>; ++k) {
        const Pack missing = (middle.change.c[k] - along.c[k]) / square;
        for (int i = 0; i < D; ++i) gradient[i].c[k] += missing * covector[i];
    }
    return gradient;
}

/// F R (by_axes + σ by_sizes), not further along the chord than `max_shift`; nothing where that is no number.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> accurate_offset(const EdgeFrame<D>& f, const VecPack<D>& chord,
                                                                    const EdgeSight<D>& middle,
                                                                    const EdgeAccuracyOptions& options) {
    const VecPack<D> axes = by_axes(f, options.change);
    const bool by_ends = options.change == ChangeAlong::of_ends;
    const VecPack<D> sizes =
        by_sizes<D>(f, by_ends ? agreeing_with_ends(f, middle, chord) : middle.gradient, options.metric_kind);
    const double share = share_of_sizes(options, D);
    VecPack<D> in_frame;
    for (int j = 0; j < D; ++j) in_frame[j] = axes[j] + share * sizes[j];
    VecPack<D> d = times(f.log_metric.vectors, in_frame);
    const Pack shift = abs(dot(d, chord)) / dot(chord, chord);
    const Pack kept = select(shift > max_shift, max_shift / shift, packed(1));
    Pack largest = packed(0);
    for (int j = 0; j < D; ++j) {
        d[j] *= kept;
        largest += abs(d[j]);
    }
    VecPack<D> offset = times(middle.jacobian, d);
    for (int j = 0; j < D; ++j) offset[j] = select(largest < 1e300, offset[j], packed(0));
    return offset;
}
}  // namespace camber
