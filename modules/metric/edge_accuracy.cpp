module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.metric;
import :edge_frame;
import :edge_offset;
import :packs;
import camber.core;

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

template <int D>
void accurate_offsets(std::span<const Vec<D>> chords, std::span<const EdgeEnds<D>> ends,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets, Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        for (std::size_t begin = 0; begin < offsets.size(); begin += pack_size) {
            const VecPack<D> chord = gathered_vec<D>(
                chords, begin, [](const Vec<D>& v) __attribute__((always_inline)) -> const Vec<D>& { return v; });
            const EdgeSight<D> middle = seen_from_middle<D>(ends, begin);
            scatter<D>(accurate_offset<D>(edge_frame(chord, middle, options.change), chord, middle, options), begin,
                       offsets);
        }
    });
}

namespace {

/// sqrt(n Σ(x − mean)²/n) of the log sizes of a metric, see frame_mean.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack unlikeness(const VecPack<D>& sizes) {
    Pack sum = sizes[0], squares = sizes[0] * sizes[0];
    for (int i = 1; i < D; ++i) {
        sum += sizes[i];
        squares += sizes[i] * sizes[i];
    }
    return sqrt(max(squares - sum * sum / D, packed(0)));
}

/// |e| in frame_mean of the ends' metrics, whose log sizes rise.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack middle_speed(const EdgeFrame<D>& f, const VecPack<D>& a,
                                                           const VecPack<D>& b) {
    const VecPack<D>& values = f.log_metric.values;
    const Pack most = (unlikeness<D>(a) + unlikeness<D>(b)) / 2;
    const Pack ratio = select(most > 0, unlikeness<D>(values) / most, packed(0));
    const Pack share = min(max((ratio - 0.5) / 0.3, packed(0)), packed(1));
    Pack sum = packed(0);
    for (int i = 0; i < D; ++i) {
        Pack rank = packed(0);  // among the values
        for (int k = 0; k < D; ++k)
            if (k != i) rank += select(k < i ? values[k] <= values[i] : values[k] < values[i], packed(1), packed(0));
        Pack mean = packed(0);
        for (int k = 0; k < D; ++k) mean = select(rank == packed(k), (a[k] + b[k]) / 2, mean);
        sum += exp(values[i] + share * (mean - values[i])) * f.chord[i] * f.chord[i];
    }
    return sqrt(sum);
}

/// logarithmic_mean.
[[nodiscard, gnu::always_inline]] inline Pack mean_of_speeds(Pack a, Pack b) {
    const Pack sum = a + b, d = (a - b) / sum;
    const Pack near = sum / 2 * (1 - d * d / 3);
    return select(sum > 0, select(abs(d) < 1e-3, near, (a - b) / log(a / b)), packed(0));
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack speed_at(std::span<const EndSights<D>> ends, std::size_t begin,
                                                       std::size_t end, const VecPack<D>& v) {
    Pack sum = packed(0);
    for (int k = 0; k < D; ++k) {
        const VecPack<D> row =
            gathered_vec<D>(ends, begin, [&](const EndSights<D>& e) __attribute__((always_inline)) -> const Vec<D>& {
                return e[end].measure->rows[static_cast<std::size_t>(k)];
            });
        const Pack w = dot(row, v);
        sum += w * w;
    }
    return sqrt(sum);
}

/// Whether the ends tell of one metric all along but for rounding, in which the edge is straight and as long as that
/// says: its node would leave the chord's middle by less than 1e-13 of that.
template <int D>
[[nodiscard]] bool sees_one_metric(const EndSights<D>& ends, const Vec<D>& chord) {
    constexpr double rounding = 1e-12;  // of log M, within the edge
    const auto changes = [](double change) { return !(std::abs(change) <= rounding); };
    for (int k = 0; k < sym_size<D>; ++k)
        if (changes(ends[0].log_metric->l.c[k] - ends[1].log_metric->l.c[k])) return false;
    const double length = norm(chord);
    for (const EndSight<D>& end : ends)
        for (const Sym<D>& along : *end.gradient)
            if (std::ranges::any_of(along.c, [&](double slope) { return changes(slope * length); })) return false;
    return true;
}

}  // namespace

template <int D>
void bent_edges(std::span<const Vec<D>> chords, std::span<const EndSights<D>> ends, const EdgeAccuracyOptions& options,
                std::span<Vec<D>> offsets, std::span<double> lengths, Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        for (std::size_t begin = 0; begin < offsets.size(); begin += pack_size) {
            const std::size_t n = std::min<std::size_t>(pack_size, offsets.size() - begin);
            std::array<bool, pack_size> is_straight{};
            for (std::size_t lane = 0; lane < n; ++lane)
                is_straight[lane] = sees_one_metric<D>(ends[begin + lane], chords[begin + lane]);
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
            const EdgeSight<D> middle = seen_from_middle<D>(ends, begin);
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
                                       [&](const EndSights<D>& e) __attribute__((always_inline)) -> const Vec<D>& {
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

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template void accurate_offsets<D>(std::span<const Vec<D>>, std::span<const EdgeEnds<D>>,                        \
                                      const EdgeAccuracyOptions&, std::span<Vec<D>>, Instructions);                 \
    template void bent_edges<D>(std::span<const Vec<D>>, std::span<const EndSights<D>>, const EdgeAccuracyOptions&, \
                                std::span<Vec<D>>, std::span<double>, Instructions);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
