module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.recovery:polynomial;
import camber.core;
import :fit;
import :monomials;

namespace camber {

/// u − u(vertex) in units of the largest such difference: values of 1e200 have fourth powers of nothing in them.
struct Unit {
    double half = 0;  ///< half of the largest difference, which may be beyond the range of numbers
    [[nodiscard]] double times(double x) const { return x * half * 2; }
};
/// Brings values to [−1, 1]; the vertex's is the first.
[[nodiscard]] inline Unit scale(std::span<double> values) {
    const double first = values[0] / 2;
    Unit unit;
    for (double& u : values) {
        u = u / 2 - first;
        unit.half = std::max(unit.half, std::abs(u));
    }
    if (unit.half > 0)
        for (double& u : values) u /= unit.half;
    return unit;
}

/// First, second and third derivatives at a point.
template <int D>
struct Derivatives {
    Vec<D> gradient;
    Sym<D> hessian;
    CubicForm<D> third;
};

/// ∂^α p(y) = Σ_{β ≥ α} c_β β!/(β − α)! y^{β − α}.
template <int D, int P>
[[nodiscard]] double derivative(const Coefficients<D, P>& c, const std::array<int, D>& alpha, const Vec<D>& y) {
    double sum = 0;
    for (std::size_t b = 0; b < c.size(); ++b) {
        const auto& beta = monomials<D, P>[b].exponents;
        double term = c[b];
        for (int i = 0; i < D; ++i) {
            for (int k = 0; k < alpha[i]; ++k) term *= beta[i] - k;  // 0 where β_i < α_i
            for (int k = alpha[i]; k < beta[i]; ++k) term *= y[i];
        }
        sum += term;
    }
    return sum;
}

/// Derivatives by y at a place y.
template <int D, int P>
[[nodiscard]] Derivatives<D> derivatives_at(const Coefficients<D, P>& c, const Vec<D>& y) {
    Derivatives<D> at;
    const auto& all = monomials<D, P>;
    constexpr int first = monomials_up_to<D>(0), second = monomials_up_to<D>(1), third = monomials_up_to<D>(2);
    for (int i = 0; i < D; ++i) at.gradient.c[i] = derivative<D, P>(c, all[first + i].exponents, y);
    for (int i = 0; i < sym_size<D>; ++i) at.hessian.c[i] = derivative<D, P>(c, all[second + i].exponents, y);
    for (int i = 0; i < cubic_size<D>; ++i) at.third.c[i] = derivative<D, P>(c, all[third + i].exponents, y);
    return at;
}

/// The same at y = 0: α! c_α.
template <int D, int P>
[[nodiscard]] Derivatives<D> derivatives_at_origin(const Coefficients<D, P>& c) {
    constexpr std::array factorials{1.0, 1.0, 2.0, 6.0};
    const auto of = [&](int place) {
        double value = c[static_cast<std::size_t>(place)];
        for (const int a : monomials<D, P>[static_cast<std::size_t>(place)].exponents) value *= factorials[a];
        return value;
    };
    Derivatives<D> at;
    for (int i = 0; i < D; ++i) at.gradient.c[i] = of(monomials_up_to<D>(0) + i);
    for (int i = 0; i < sym_size<D>; ++i) at.hessian.c[i] = of(monomials_up_to<D>(1) + i);
    for (int i = 0; i < cubic_size<D>; ++i) at.third.c[i] = of(monomials_up_to<D>(2) + i);
    return at;
}

/// By x, y = B x: Bᵀ g, Bᵀ H B, T[B·, B·, B·].
template <int D>
[[nodiscard]] Derivatives<D> pulled_back(const Derivatives<D>& by_y, const Mat<D>& b) {
    return {transposed_times(b, by_y.gradient), congruence(transposed(b), by_y.hessian), pulled_back(by_y.third, b)};
}

}  // namespace camber
