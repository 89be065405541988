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

/// The most that sizes move a node, as a share of the edge's metric length, along each axis in that axis's unit.
constexpr double most_pull = 0.2;
/// The most that a node is shifted along its chord; at 1/4 the edge folds.
constexpr double most_shift = 0.2;

/// What an edge sees in the frame of the axes at its middle.
template <int D>
struct EdgeFrame {
    SpectralMetric<D> metric;
    Vec<D> chord;                           ///< c
    std::array<Sym<D>, D> along_axes;       ///< D_k
    Sym<D> along_chord;                     ///< A
    std::array<std::array<double, D>, D> x; ///< x_ij = λ_i − λ_j
    Sym<D> likeness;                        ///< K_ij
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
    // 8 |d|/|e| is the angle by which the axes turn; the arc's sagitta where that is small, nothing where it says that
    // the edge does not see the turn.
    const double angle = 8 * norm(d) / norm(f.chord);
    return 1 / (1 + angle * angle * angle * angle) * d;
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
    return d;
}

template <int D>
Vec<D> limited(const EdgeFrame<D>& f, Vec<D> d) {
    double length = 0;
    for (int j = 0; j < D; ++j) length += f.metric.values[j] * f.chord[j] * f.chord[j];
    for (int j = 0; j < D; ++j) {
        const double most = most_pull * std::sqrt(length / f.metric.values[j]);
        d[j] = most * std::tanh(d[j] / most);
    }
    return d;
}

template <int D>
Vec<D> accurate_offset(const Vec<D>& chord, const FieldSample<D>& middle, double size_share) {
    const EdgeFrame<D> f = edge_frame(chord, middle);
    Vec<D> d = f.metric.vectors * (by_axes(f) + limited(f, size_share * by_sizes(f)));
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
