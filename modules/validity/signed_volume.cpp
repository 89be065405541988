module;
#include <array>
#include <cmath>
module camber.validity;
import camber.core;
import camber.bezier;
import :coefficients;
import :jacobian;
import :twice;

namespace camber {

namespace {

/// det of the edge vectors in numbers of the kind, and its rounding error.
template <int D, class Real>
struct BoundedVolume {
    Real value{}, error{};
};
template <int D, class Real>
BoundedVolume<D, Real> volume_in(const std::array<Vec<D>, D + 1>& p) {
    std::array<std::array<Real, D>, D> columns{};
    ColumnBounds<D, Real> bounds{};
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) {
            columns[a - 1][c] = Real(p[a][c]) - Real(p[0][c]);
            bounds[a - 1][c] = magnitude<Real>(columns[a - 1][c]);
        }
    return {determinant<D, Real>(columns), error_bound<D, Real>(bounds)};
}

}  // namespace

template <int D>
double signed_volume(const std::array<Vec<D>, D + 1>& p) {
    const auto plain = volume_in<D, double>(p);
    if (std::abs(plain.value) > plain.error) return plain.value;
    const auto sharp = volume_in<D, Twice>(p);
    return magnitude(sharp.value) > sharp.error ? sharp.value.high : 0;
}

template <int D>
double signed_volume(const NodalSimplex<D>& s) {
    const BoundedJacobian<D> jacobian = bounded_jacobian(s);
    double mean = 0;
    for (const double c : jacobian.coefficients) mean += c / jacobian_coefficients<D>;
    if (std::abs(mean) > 2 * jacobian.error) return mean;
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = s.nodes[i];
    return signed_volume<D>(corners);
}

template double signed_volume<2>(const std::array<Vec<2>, 3>&);
template double signed_volume<3>(const std::array<Vec<3>, 4>&);
template double signed_volume<2>(const NodalSimplex<2>&);
template double signed_volume<3>(const NodalSimplex<3>&);

}  // namespace camber
