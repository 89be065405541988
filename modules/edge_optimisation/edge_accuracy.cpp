module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.edge_optimisation;
import camber.core;
import camber.metric;

namespace camber {

double share_of_sizes(const EdgeAccuracyOptions& options, int dimension) {
    if (options.size_share > 0) return options.size_share;
    const auto of_degree = [&](int degree) {
        const double p = options.metric_norm * (degree + 1);
        return (degree + 1) / 3.0 * (options.metric_norm > 0 ? (p + dimension) / p : 1);
    };
    switch (options.metric_kind) {
        case MetricKind::automatic: return 2.0 / 3;
        case MetricKind::hessian: return of_degree(1);
        case MetricKind::third_derivatives: return of_degree(2);
        case MetricKind::geometry: return 0;
        case MetricKind::natural: return 1;
    }
    return 0;
}

namespace {

// Metric samples of eight edges, in the frame of the metric axes at their midpoints.

template <int D>
using GradientPack = std::array<SymPack<D>, D>;

/// Metric field at an end or at the midpoint of a straight edge.
template <int D>
struct EdgeSample {
    SymPack<D> log_metric;     ///< logarithm of M̂ = Fᵀ M F
    GradientPack<D> gradient;  ///< derivatives by coordinates of the straight mesh
    MatPack<D> jacobian;       ///< F
    SymPack<D> change = {};    ///< at the midpoint: difference of log M̂ between the ends
};

template <int D>
[[gnu::always_inline]] inline void transform_by_map(EdgeSample<D>& sample, Mask bent) {
    const PulledBackPack<D> sampled = pull_back_pack<D>(sample.log_metric, sample.jacobian);
    GradientPack<D> turned;
    for (int j = 0; j < D; ++j) turned[j] = congruence_transposed(sampled.axes, sample.gradient[j]);
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < sym_size<D>; ++k) {
            Pack along = sample.jacobian(0, i) * turned[0].c[k];
            for (int j = 1; j < D; ++j) along += sample.jacobian(j, i) * turned[j].c[k];
            sample.gradient[i].c[k] = select(bent, along, sample.gradient[i].c[k]);
        }
    for (int k = 0; k < sym_size<D>; ++k)
        sample.log_metric.c[k] = select(bent, sampled.log_metric.c[k], sample.log_metric.c[k]);
}

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSample<D> sampled_at_end(std::span<const EdgeEnds<D>> edges,
                                                                      std::size_t begin,
                                                                      EdgeEnd<D> EdgeEnds<D>::* end) {
    using Ends = EdgeEnds<D>;
    EdgeSample<D> sampled{};
    sampled.log_metric = gathered_sym<D>(
        edges, begin,
        [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& { return (e.*end).log_metric.l; });
    for (int i = 0; i < D; ++i)
        sampled.gradient[i] = gathered_sym<D>(
            edges, begin,
            [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& { return (e.*end).gradient[i]; });
    sampled.jacobian = gathered_mat<D>(
        edges, begin, [&](const Ends& e) __attribute__((always_inline)) -> const Mat<D>& { return (e.*end).jacobian; });
    return sampled;
}
template <int D>
[[nodiscard]] inline bool is_one_end(std::span<const EndSamples<D>> edges, std::size_t begin, std::size_t end) {
    const std::size_t last = std::min<std::size_t>(begin + pack_size, edges.size());
    for (std::size_t lane = begin + 1; lane < last; ++lane)
        if (edges[lane][end].gradient != edges[begin][end].gradient ||
            edges[lane][end].log_metric != edges[begin][end].log_metric)
            return false;
    return true;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> in_all_lanes(const Sym<D>& one) {
    SymPack<D> all;
    for (int k = 0; k < sym_size<D>; ++k) all.c[k] = packed(one.c[k]);
    return all;
}
/// Without a curved back mesh F is the identity.
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSample<D> sampled_at_end(std::span<const EndSamples<D>> edges,
                                                                      std::size_t begin, std::size_t end) {
    using Ends = EndSamples<D>;
    EdgeSample<D> sampled{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) sampled.jacobian(i, j) = packed(i == j ? 1 : 0);
    if (is_one_end(edges, begin, end)) {
        const EndSample<D>& one = edges[begin][end];
        sampled.log_metric = in_all_lanes(one.log_metric->l);
        for (int i = 0; i < D; ++i) sampled.gradient[i] = in_all_lanes((*one.gradient)[i]);
        return sampled;
    }
    sampled.log_metric = gathered_sym<D>(
        edges, begin,
        [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& { return e[end].log_metric->l; });
    for (int i = 0; i < D; ++i)
        sampled.gradient[i] = gathered_sym<D>(
            edges, begin,
            [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& { return (*e[end].gradient)[i]; });
    return sampled;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSample<D> middle_of(EdgeSample<D> a, const EdgeSample<D>& b) {
    for (int k = 0; k < sym_size<D>; ++k) {
        a.change.c[k] = b.log_metric.c[k] - a.log_metric.c[k];
        a.log_metric.c[k] = (a.log_metric.c[k] + b.log_metric.c[k]) / 2;
        for (int i = 0; i < D; ++i) a.gradient[i].c[k] = (a.gradient[i].c[k] + b.gradient[i].c[k]) / 2;
    }
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) a.jacobian(i, j) = (a.jacobian(i, j) + b.jacobian(i, j)) / 2;
    return a;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSample<D> sampled_at_middle(std::span<const EdgeEnds<D>> edges,
                                                                         std::size_t begin) {
    using Ends = EdgeEnds<D>;
    const Pack bent =
        gathered(edges, begin, [](const Ends& e) __attribute__((always_inline)) { return e.is_curved ? 1.0 : 0.0; });
    EdgeSample<D> a = sampled_at_end(edges, begin, &Ends::a);
    EdgeSample<D> b = sampled_at_end(edges, begin, &Ends::b);
    if (any(bent != 0)) {
        transform_by_map(a, bent != 0);
        transform_by_map(b, bent != 0);
    }
    return middle_of(a, b);
}
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSample<D> sampled_at_middle(std::span<const EndSamples<D>> edges,
                                                                         std::size_t begin) {
    return middle_of(sampled_at_end(edges, begin, 0), sampled_at_end(edges, begin, 1));
}

template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> derivative(const GradientPack<D>& gradient, const VecPack<D>& v) {
    SymPack<D> along;
    for (int k = 0; k < sym_size<D>; ++k) {
        along.c[k] = v[0] * gradient[0].c[k];
        for (int a = 1; a < D; ++a) along.c[k] += v[a] * gradient[a].c[k];
    }
    return along;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack bilinear(const SymPack<D>& m, const VecPack<D>& a, const VecPack<D>& b) {
    Pack sum = packed(0);
    for (int i = 0; i < D; ++i) {
        Pack row = m(i, 0) * b[0];
        for (int j = 1; j < D; ++j) row += m(i, j) * b[j];
        sum += a[i] * row;
    }
    return sum;
}

/// Sampled metric, expressed in its axes at the midpoint. Symbols: see accurate_offsets.
template <int D>
struct EdgeFrame {
    EigenPack<D> log_metric;
    VecPack<D> sizes;                        ///< e^{λ_i}
    VecPack<D> chord;                        ///< c
    SymPack<D> along_chord;                  ///< A
    std::array<std::array<Pack, D>, D> x{};  ///< x_ij = λ_i − λ_j
    SymPack<D> axis_similarity;              ///< K_ij
};

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeFrame<D> edge_frame(const VecPack<D>& chord, const EdgeSample<D>& middle,
                                                                 ChangeSource change) {
    EdgeFrame<D> f{};
    f.log_metric = eigen_system<D>(middle.log_metric);
    f.chord = times_transposed(f.log_metric.vectors, chord);
    const SymPack<D> along = change == ChangeSource::of_ends ? middle.change : derivative<D>(middle.gradient, chord);
    f.along_chord = congruence_transposed(f.log_metric.vectors, along);
    for (int i = 0; i < D; ++i) {
        f.sizes[i] = exp(f.log_metric.values[i]);
        for (int j = 0; j < D; ++j) f.x[i][j] = f.log_metric.values[i] - f.log_metric.values[j];
        for (int j = 0; j < i; ++j) f.axis_similarity(i, j) = exp(-abs(f.x[i][j]));
        f.axis_similarity(i, i) = packed(1);
    }
    return f;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack metric_length(const EdgeFrame<D>& f, const VecPack<D>& v) {
    Pack q = f.sizes[0] * v[0] * v[0];
    for (int j = 1; j < D; ++j) q += f.sizes[j] * v[j] * v[j];
    return sqrt(q);
}

// Computes offsets for accuracy, for eight edges at a time, from the sampled axes and sizes.

/// Limits of an edge that resolves the metric: rotation of the axes (radians; a separate limit for differences of the
/// ends), and change of log M (a size factor of 7).
constexpr double max_turn = 1;
constexpr double max_turn_of_ends = 1.2;
constexpr double max_resolved_change = 4;
/// Squared length of the longest edge of a unit mesh, √2.
constexpr double unit_length_squared = 2;
/// Maximum shift along the chord, in chords; at 1/4 the edge folds.
constexpr double max_shift = 0.2;

[[nodiscard, gnu::always_inline]] inline Pack resolved(Pack change, double most) {
    const Pack share = change / most;
    return 1 / (1 + share * share * share * share);
}

/// Returns w(x) (see accurate_offsets). If axis j is the finer one, 1/|x| converts a change of the log-metric L into an
/// angle. w is 0 for equal sizes, whose axes are undefined.
[[nodiscard, gnu::always_inline]] inline Pack turning(Pack x, Pack axis_similarity) {
    const Pack unlike = 1 - axis_similarity;
    return select(x == 0, packed(0), unlike * unlike / abs(x) * select(x > 0, axis_similarity, packed(1)));
}

/// Offset d from the rotation of the axes r_j: r_j·d = (change of r_j along e)·e/8. With `of_ends`, axes that turn by α
/// change L by x tan α, and the tangents give (e/4) tan(α/2).
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_axes(const EdgeFrame<D>& f, ChangeSource change) {
    VecPack<D> d;
    for (int j = 0; j < D; ++j) {
        d[j] = packed(0);
        for (int i = 0; i < D; ++i) {
            if (i == j) continue;
            Pack part = turning(f.x[i][j], f.axis_similarity(i, j)) * f.along_chord(i, j) * f.chord[i] / 8;
            if (change == ChangeSource::of_ends) {
                const Pack tangent = select(f.x[i][j] == 0, packed(0), f.along_chord(i, j) / f.x[i][j]);
                part *= 2 / (1 + sqrt(1 + tangent * tangent));
            }
            d[j] += part;
        }
    }
    // The rotation angle is 8 |d|/|e|. The ends alone do not determine it, because axes may have exchanged places.
    const Pack turn = 8 * sqrt(dot(d, d)) / sqrt(dot(f.chord, f.chord));
    const Pack limited_share = change == ChangeSource::of_ends
                                   ? resolved(turn * turn, max_turn_of_ends * max_turn_of_ends)
                                   : resolved(turn, max_turn);
    for (int j = 0; j < D; ++j) d[j] *= limited_share;
    return d;
}

/// Offset d of the first geodesic step for the chord component along similar axes, u = R K_j∘c: 8 d_j = r_jᵀ (∂_u L) u
/// − ½ uᵀ (∂_{r_j} L) u.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_derivatives(const EdgeFrame<D>& f,
                                                                   const GradientPack<D>& gradient) {
    const MatPack<D>& r = f.log_metric.vectors;
    VecPack<D> d;
    for (int j = 0; j < D; ++j) {
        VecPack<D> like;
        for (int a = 0; a < D; ++a) like[a] = f.axis_similarity(j, a) * f.chord[a];
        const VecPack<D> u = times(r, like);
        const Pack along = bilinear<D>(derivative<D>(gradient, u), r.column[j], u);
        const Pack across = bilinear<D>(derivative<D>(gradient, r.column[j]), u, u);
        d[j] = (along - across / 2) / 8;
    }
    return d;
}

/// Offset d with 16 d_j = (γ·c)² γ_j/|γ|², where γ is the gradient of the mean log size of the axes similar to axis j,
/// within these axes.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_layers(const EdgeFrame<D>& f, const GradientPack<D>& gradient) {
    const MatPack<D>& r = f.log_metric.vectors;
    std::array<VecPack<D>, D> growth;  // derivative of λ_i along axis k
    for (int k = 0; k < D; ++k) {
        const SymPack<D> along = derivative<D>(gradient, r.column[k]);
        for (int i = 0; i < D; ++i) growth[k][i] = bilinear<D>(along, r.column[i], r.column[i]);
    }
    VecPack<D> d;
    for (int j = 0; j < D; ++j) {
        Pack alike = packed(0), square = packed(0), along = packed(0), own = packed(0);
        for (int i = 0; i < D; ++i) alike += f.axis_similarity(i, j);
        for (int k = 0; k < D; ++k) {
            Pack mean = packed(0);
            for (int i = 0; i < D; ++i) mean += f.axis_similarity(i, j) * growth[k][i];
            mean *= f.axis_similarity(j, k) / alike;
            square += mean * mean;
            along += mean * f.chord[k];
            if (k == j) own = mean;
        }
        d[j] = select(square > 0, along * along / square * own / 16, packed(0));
    }
    return d;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> by_sizes(const EdgeFrame<D>& f, const GradientPack<D>& gradient,
                                                             MetricKind kind) {
    VecPack<D> d = kind == MetricKind::natural ? by_layers<D>(f, gradient) : by_derivatives<D>(f, gradient);
    const Pack length = metric_length(f, f.chord);
    const Pack unit = min(unit_length_squared / (length * length), packed(1));
    // In one dimension d = Δλ e/16, so the argument of `resolved` is Δλ.
    const Pack limited_share = unit * resolved(16 * metric_length(f, d) / length, max_resolved_change);
    for (int j = 0; j < D; ++j) d[j] *= limited_share;
    return d;
}

/// Changes the gradient minimally, in the metric, so that it matches the difference of the ends along the chord.
template <int D>
[[nodiscard, gnu::always_inline]] inline GradientPack<D> agreeing_with_ends(const EdgeFrame<D>& f,
                                                                            const EdgeSample<D>& middle,
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

/// Returns by_axes + σ by_sizes, mapped to space by F R (symbols: see accurate_offsets), or 0 if this is not finite.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> accurate_offset(const EdgeFrame<D>& f, const VecPack<D>& chord,
                                                                    const EdgeSample<D>& middle,
                                                                    const EdgeAccuracyOptions& options) {
    const VecPack<D> axes = by_axes(f, options.change);
    const bool by_ends = options.change == ChangeSource::of_ends;
    const VecPack<D> sizes =
        by_sizes<D>(f, by_ends ? agreeing_with_ends(f, middle, chord) : middle.gradient, options.metric_kind);
    const double share = share_of_sizes(options, D);
    VecPack<D> in_frame;
    for (int j = 0; j < D; ++j) in_frame[j] = axes[j] + share * sizes[j];
    VecPack<D> d = times(f.log_metric.vectors, in_frame);
    const Pack shift = abs(dot(d, chord)) / dot(chord, chord);
    const Pack limited_share = select(shift > max_shift, max_shift / shift, packed(1));
    Pack largest = packed(0);
    for (int j = 0; j < D; ++j) {
        d[j] *= limited_share;
        largest += abs(d[j]);
    }
    VecPack<D> offset = times(middle.jacobian, d);
    for (int j = 0; j < D; ++j) offset[j] = select(largest < 1e300, offset[j], packed(0));
    return offset;
}

/// Spread of log sizes x: sqrt(Σ (x − mean)²), see frame_mean.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack anisotropy_spread(const VecPack<D>& sizes) {
    Pack sum = sizes[0], squares = sizes[0] * sizes[0];
    for (int i = 1; i < D; ++i) {
        sum += sizes[i];
        squares += sizes[i] * sizes[i];
    }
    return sqrt(max(squares - sum * sum / D, packed(0)));
}

/// Length of e in the frame_mean of the ends' metrics; log sizes ascend.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack middle_speed(const EdgeFrame<D>& f, const VecPack<D>& a,
                                                           const VecPack<D>& b) {
    const VecPack<D>& values = f.log_metric.values;
    const Pack most = (anisotropy_spread<D>(a) + anisotropy_spread<D>(b)) / 2;
    const Pack ratio = select(most > 0, anisotropy_spread<D>(values) / most, packed(0));
    const Pack share = min(max((ratio - 0.5) / 0.3, packed(0)), packed(1));
    Pack sum = packed(0);
    for (int i = 0; i < D; ++i) {
        Pack rank = packed(0);
        for (int k = 0; k < D; ++k)
            if (k != i) rank += select(k < i ? values[k] <= values[i] : values[k] < values[i], packed(1), packed(0));
        Pack mean = packed(0);
        for (int k = 0; k < D; ++k) mean = select(rank == packed(k), (a[k] + b[k]) / 2, mean);
        sum += exp(values[i] + share * (mean - values[i])) * f.chord[i] * f.chord[i];
    }
    return sqrt(sum);
}

[[nodiscard, gnu::always_inline]] inline Pack mean_of_speeds(Pack a, Pack b) {
    const Pack sum = a + b, d = (a - b) / sum;
    const Pack near = sum / 2 * (1 - d * d / 3);
    return select(sum > 0, select(abs(d) < 1e-3, near, (a - b) / log(a / b)), packed(0));
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack speed_at(std::span<const EndSamples<D>> ends, std::size_t begin,
                                                       std::size_t end, const VecPack<D>& v) {
    Pack sum = packed(0);
    for (int k = 0; k < D; ++k) {
        const VecPack<D> row =
            gathered_vec<D>(ends, begin, [&](const EndSamples<D>& e) __attribute__((always_inline)) -> const Vec<D>& {
                return e[end].measure->rows[static_cast<std::size_t>(k)];
            });
        const Pack w = dot(row, v);
        sum += w * w;
    }
    return sqrt(sum);
}

/// True if the metric is constant within rounding: the node would leave the chord midpoint by less than 1e-13 of the
/// length.
template <int D>
[[nodiscard]] bool is_metric_constant(const EndSamples<D>& ends, const Vec<D>& chord) {
    constexpr double rounding = 1e-12;  // bound on the change of log M within the edge
    const auto changes = [](double change) { return !(std::abs(change) <= rounding); };
    for (int k = 0; k < sym_size<D>; ++k)
        if (changes(ends[0].log_metric->l.c[k] - ends[1].log_metric->l.c[k])) return false;
    const double length = norm(chord);
    for (const EndSample<D>& end : ends)
        for (const Sym<D>& along : *end.gradient)
            if (std::ranges::any_of(along.c, [&](double slope) { return changes(slope * length); })) return false;
    return true;
}

}  // namespace

template <int D>
void accurate_offsets(std::span<const Vec<D>> chords, std::span<const EdgeEnds<D>> ends,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets, Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        for (std::size_t begin = 0; begin < offsets.size(); begin += pack_size) {
            const VecPack<D> chord = gathered_vec<D>(
                chords, begin, [](const Vec<D>& v) __attribute__((always_inline)) -> const Vec<D>& { return v; });
            const EdgeSample<D> middle = sampled_at_middle<D>(ends, begin);
            scatter<D>(accurate_offset<D>(edge_frame(chord, middle, options.change), chord, middle, options), begin,
                       offsets);
        }
    });
}

template <int D>
void bent_edges(std::span<const Vec<D>> chords, std::span<const EndSamples<D>> ends, const EdgeAccuracyOptions& options,
                std::span<Vec<D>> offsets, std::span<double> lengths, Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        for (std::size_t begin = 0; begin < offsets.size(); begin += pack_size) {
            const std::size_t n = std::min<std::size_t>(pack_size, offsets.size() - begin);
            std::array<bool, pack_size> is_straight{};
            for (std::size_t lane = 0; lane < n; ++lane)
                is_straight[lane] = is_metric_constant<D>(ends[begin + lane], chords[begin + lane]);
            const auto straighten = [&] {
                for (std::size_t lane = 0; lane < n; ++lane) {
                    if (!is_straight[lane]) continue;
                    offsets[begin + lane] = {};
                    lengths[begin + lane] =
                        std::sqrt(ends[begin + lane][0].measure->length_squared(chords[begin + lane]));
                }
            };
            if (std::all_of(is_straight.begin(), is_straight.begin() + n, [](bool is) { return is; })) {
                straighten();
                continue;
            }
            const VecPack<D> chord = gathered_vec<D>(
                chords, begin, [](const Vec<D>& v) __attribute__((always_inline)) -> const Vec<D>& { return v; });
            const EdgeSample<D> middle = sampled_at_middle<D>(ends, begin);
            const EdgeFrame<D> f = edge_frame(chord, middle, options.change);
            const VecPack<D> offset = accurate_offset<D>(f, chord, middle, options);
            scatter<D>(offset, begin, offsets);
            VecPack<D> leaving, arriving;
            for (int k = 0; k < D; ++k) {
                leaving[k] = chord[k] + 4 * offset[k];
                arriving[k] = chord[k] - 4 * offset[k];
            }
            const auto sizes_at = [&](std::size_t end) __attribute__((always_inline)) {
                return gathered_vec<D>(ends, begin,
                                       [&](const EndSamples<D>& e) __attribute__((always_inline)) -> const Vec<D>& {
                                           return e[end].measure->log_sizes;
                                       });
            };
            const Pack l_a = speed_at<D>(ends, begin, 0, leaving), l_b = speed_at<D>(ends, begin, 1, arriving);
            const Pack l_m = middle_speed<D>(f, sizes_at(0), sizes_at(1));
            const Pack length = mean_of_speeds(l_a, l_b) + 2.0 / 3.0 * (l_m - sqrt(l_a * l_b));
            for (std::size_t lane = 0; lane < n; ++lane) lengths[begin + lane] = length[lane];
            straighten();
        }
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template void accurate_offsets<D>(std::span<const Vec<D>>, std::span<const EdgeEnds<D>>,                         \
                                      const EdgeAccuracyOptions&, std::span<Vec<D>>, Instructions);                  \
    template void bent_edges<D>(std::span<const Vec<D>>, std::span<const EndSamples<D>>, const EdgeAccuracyOptions&, \
                                std::span<Vec<D>>, std::span<double>, Instructions);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
