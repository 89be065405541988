module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
module camber.recovery:whitening;
import camber.core;

namespace camber {

/// Σ y yᵀ / n of the points y = B x.
template <int D>
[[nodiscard]] inline Sym<D> covariance(const Mat<D>& b, std::span<const Vec<D>> points) {
    Sym<D> sum;
    for (const Vec<D>& x : points) {
        const Vec<D> y = b * x;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) sum(i, j) += y[i] * y[j];
    }
    return sum * (1 / static_cast<double>(points.size()));
}

/// Rows of B from here on are L⁻¹ of it, with L Lᵀ = C. Pivots below what cancellation leaves of C are raised to that.
template <int D>
inline void divide_by_factor(const Sym<D>& c, Mat<D>& b) {
    std::array<std::array<double, D>, D> l{};
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j <= i; ++j) {
            double rest = c(i, j);
            for (int k = 0; k < j; ++k) rest -= l[i][k] * l[j][k];
            if (j < i)
                l[i][j] = l[j][j] > 0 ? rest / l[j][j] : 0;
            else
                l[i][i] = std::sqrt(std::max(rest, 16 * std::numeric_limits<double>::epsilon() * c(i, i)));
        }
        for (int column = 0; column < D; ++column) {
            double rest = b(i, column);
            for (int k = 0; k < i; ++k) rest -= l[i][k] * b(k, column);
            b(i, column) = l[i][i] > 0 ? rest / l[i][i] : 0;
        }
    }
}

/// B for which the points y = B x have the covariance 1 (about the origin), then divided so that the farthest is at
/// |y| = 1. The covariance of the points as they are loses the thin direction's digits at an anisotropy of 1e8: it is
/// taken again of what it has whitened, until it is 1. A direction in which the points extend by no more than `noise`,
/// that of their coordinates, has a row of zeros.
template <int D>
[[nodiscard]] inline Mat<D> whitening(std::span<const Vec<D>> points, double noise) {
    double largest = 0;
    for (const Vec<D>& x : points)
        for (const double c : x.c) largest = std::max(largest, std::abs(c));
    Mat<D> b;
    if (!(largest > 0)) return b;
    for (int i = 0; i < D; ++i) b(i, i) = 1 / largest;
    constexpr int passes = 5;  // each makes 1e7 of the anisotropy
    for (int pass = 0; pass < passes; ++pass) {
        const Sym<D> c = covariance(b, points);
        divide_by_factor(c, b);
        for (int i = 0; i < D; ++i) {
            double gain = 0;
            for (int j = 0; j < D; ++j) gain += std::abs(b(i, j));
            if (gain * noise > 0.1)
                for (int j = 0; j < D; ++j) b(i, j) = 0;
        }
        if (norm(c - Sym<D>::identity()) < 0.1) break;
    }
    double farthest = 0;
    for (const Vec<D>& x : points) farthest = std::max(farthest, norm_squared(b * x));
    if (farthest > 0)
        for (Vec<D>& column : b.column) column *= 1 / std::sqrt(farthest);
    return b;
}

}  // namespace camber
