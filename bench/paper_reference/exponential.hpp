// Exponential of a symmetric matrix and its derivatives by scaling and squaring with the series (paper §2.2.1).
//
// T is scaled by 2^-m until its norm is below 1, the series of exp and its derivative are summed, and both are squared
// m times: exp(2Q) = exp(Q)², ∂exp(2Q) = (∂exp Q) exp Q + exp Q (∂exp Q). (The paper prints 2 exp Q ∂exp Q, which holds
// only if Q and ∂Q commute.) Two modifications save time without changing the method: the trace is subtracted first,
// exp(μI + S) = e^μ exp S, and the series is summed in blocks of four powers (Paterson and Stockmeyer), up to the
// number that the norm requires.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "matrix.hpp"

namespace paper {

/// 1/k!.
inline constexpr auto inverse_factorials = [] {
    std::array<double, 21> f{};
    double factorial = 1;
    for (std::size_t k = 0; k < f.size(); ++k) {
        if (k > 0) factorial *= static_cast<double>(k);
        f[k] = 1 / factorial;
    }
    return f;
}();

/// Returns the number of blocks of four powers after which the rest of the series is below rounding, for norms below 1.
/// (At anisotropy 10^6 the eigenvalues of M differ by 10^12, and errors are relative to the largest one.)
[[nodiscard]] inline std::size_t blocks_for(double norm) {
    if (norm < 0.069) return 2;
    if (norm < 0.333) return 3;
    return norm < 0.822 ? 4 : 5;
}

/// Returns Σ_{k ≤ 4 blocks} T^k/k! with its derivatives.
template <std::size_t N>
[[nodiscard]] inline Jet<N> series(const Jet<N>& t, std::size_t blocks) {
    const Jet<N> t2 = product(t, t);
    const Jet<N> t3 = product(t2, t);
    const Jet<N> t4 = product(t2, t2);
    const auto add_block = [&](Jet<N>& sum, std::size_t first) {
        add_to_diagonal(sum.value, inverse_factorials[first]);
        add(sum, inverse_factorials[first + 1], t);
        add(sum, inverse_factorials[first + 2], t2);
        add(sum, inverse_factorials[first + 3], t3);
    };
    Jet<N> sum{};
    add(sum, inverse_factorials[4 * blocks], t4);
    add_block(sum, 4 * blocks - 4);
    for (std::size_t block = blocks - 1; block-- > 0;) {
        sum = product(sum, t4);
        add_block(sum, 4 * block);
    }
    return sum;
}

/// Returns exp(T) and its derivatives from those of T.
template <std::size_t N>
[[nodiscard]] inline Jet<N> exponential(Jet<N> t) {
    const double mean = trace(t.value) / 3;
    std::array<double, N> mean_slope{};
    add_to_diagonal(t.value, -mean);
    for (std::size_t n = 0; n < N; ++n) {
        mean_slope[n] = trace(t.slope[n]) / 3;
        add_to_diagonal(t.slope[n], -mean_slope[n]);
    }
    const double size = norm(t.value);
    int squarings = 0;
    double scaled = size;
    for (; scaled >= 1 && squarings < 64; ++squarings) scaled *= 0.5;
    scale(t, std::ldexp(1.0, -squarings));
    Jet<N> e = series(t, blocks_for(scaled));
    for (int s = 0; s < squarings; ++s) e = product(e, e);
    // e^μ exp S, and its derivative e^μ (∂exp S + ∂μ exp S).
    for (std::size_t n = 0; n < N; ++n) add(e.slope[n], mean_slope[n], e.value);
    scale(e, std::exp(mean));
    return e;
}

}  // namespace paper
