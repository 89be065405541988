module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.metric;
import camber.core;

namespace camber {

namespace {

/// What changes by more than this within an edge is not resolved by it: the angle by which axes turn, in radians, and
/// the change of log M by sizes (a factor of 7 of a size).
constexpr double most_turn = 1;
constexpr double most_change = 4;
/// The longest edge of a mesh that is unit for the metric has length √2; functions are not resolved by longer ones.
constexpr double unit_length_squared = 2;
/// The most that a node is shifted along its chord; at 1/4 the edge folds.
constexpr double most_shift = 0.2;

/// 1 where `change` is small beside `most`, 0 far beyond.
double resolved(double change, double most) {
    const double share = change / most;
    return 1 / (1 + share * share * share * share);
}

/// What an edge sees in the frame of the axes at its middle.
template <int D>
struct EdgeFrame {
    SpectralMetric<D> metric;
    Vec<D> chord;                            ///< c
    std::array<Sym<D>, D> along_axes;        ///< D_k
    Sym<D> along_chord;                      ///< A
    std::array<std::array<double, D>, D> x;  ///< x_ij = λ_i − λ_j
    Sym<D> likeness;                         ///< K_ij
};

template <int D>
EdgeFrame<D> edge_frame(const Vec<D>& chord, const FieldSample<D>& middle) {
    EdgeFrame<D> f{SpectralMetric<D>(middle.log_metric), {}, {}, {}, {}, {}};
    const Mat<D> to_axes = transposed(f.metric.vectors);
    f.chord = to_axes * chord;
    LogGradient<D> turned;
    for (int a = 0; a < D; ++a) turned[a] = congruence(to_axes, middle.gradient[a]);
    for (int k = 0; k < D; ++k) {
        for (int a = 0; a < D; ++a) f.along_axes[k] += f.metric.vectors(a, k) * turned[a];
        f.along_chord += f.chord[k] * f.along_axes[k];
    }
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) {
            f.x[i][j] = f.metric.log_values[i] - f.metric.log_values[j];
            if (j <= i) f.likeness(i, j) = std::exp(-std::abs(f.x[i][j]));
        }
    return f;
}

/// w(x): 1/|x| turns a change of L into an angle, where axis j is the finer one; nothing where both are alike, since
/// what turns there are no axes.
double turning(double x, double likeness) {
    if (x == 0) return 0;
    const double unlike = 1 - likeness;
    return unlike * unlike / std::abs(x) * (x > 0 ? likeness : 1);
}

/// Level sets of the coordinates whose gradients the axes are: r_j·d = (change of r_j along e)·e/8.
template <int D>
Vec<D> by_axes(const EdgeFrame<D>& f) {
    Vec<D> d;
    for (int j = 0; j < D; ++j)
        for (int i = 0; i < D; ++i)
            if (i != j) d[j] += turning(f.x[i][j], f.likeness(i, j)) * f.along_chord(i, j) * f.chord[i] / 8;
    // 8 |d|/|e| is the angle by which the axes turn.
    return resolved(8 * norm(d) / norm(f.chord), most_turn) * d;
}

template <int D>
double metric_length(const EdgeFrame<D>& f, const Vec<D>& v) {
    double q = 0;
    for (int j = 0; j < D; ++j) q += f.metric.values[j] * v[j] * v[j];
    return std::sqrt(q);
}

/// The first Newton step of the energy, (∂_e L) e − ½ ∇(eᵀ L e), among axes that are alike.
template <int D>
Vec<D> by_sizes(const EdgeFrame<D>& f) {
    Vec<D> d;
    for (int j = 0; j < D; ++j) {
        double across = 0;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b)
                across += f.likeness(a, b) * std::sqrt(f.likeness(j, a) * f.likeness(j, b)) * f.along_axes[j](a, b) *
                          f.chord[a] * f.chord[b];
        d[j] = -across / 16;
        for (int i = 0; i < D; ++i) d[j] += f.likeness(i, j) * f.along_chord(i, j) * f.chord[i] / 8;
    }
    const double length = metric_length(f, f.chord);
    const double unit = std::min(1.0, unit_length_squared / (length * length));
    // In one direction d = Δλ e/16.
    return unit * resolved(16 * metric_length(f, d) / length, most_change) * d;
}

template <int D>
Vec<D> accurate_offset(const Vec<D>& chord, const FieldSample<D>& middle, double size_share) {
    const EdgeFrame<D> f = edge_frame(chord, middle);
    Vec<D> d = f.metric.vectors * (by_axes(f) + size_share * by_sizes(f));
    const double shift = std::abs(dot(d, chord)) / norm_squared(chord);
    if (shift > most_shift) d *= most_shift / shift;
    for (int k = 0; k < D; ++k)
        if (!std::isfinite(d[k])) return {};
    return d;
}

}  // namespace

template <int D>
void accurate_offsets(std::span<const Vec<D>> chords, std::span<const FieldSample<D>> middles,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets) {
    for (std::size_t i = 0; i < offsets.size(); ++i)
        offsets[i] = accurate_offset(chords[i], middles[i], options.size_share);
}

template void accurate_offsets<2>(std::span<const Vec<2>>, std::span<const FieldSample<2>>, const EdgeAccuracyOptions&,
                                  std::span<Vec<2>>);
template void accurate_offsets<3>(std::span<const Vec<3>>, std::span<const FieldSample<3>>, const EdgeAccuracyOptions&,
                                  std::span<Vec<3>>);

}  // namespace camber
