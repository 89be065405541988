module;
#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>
export module camber.validity:coefficients;
import camber.core;
import camber.bezier;
import :twice;

export namespace camber {

/// det J of a P2 simplex has degree D: one linear factor for each of the D columns.
template <int D>
inline constexpr int jacobian_coefficients = node_count<D, D>;

/// The multi-indices of the coefficients, in the order of every array of them here.
template <int D>
inline constexpr const auto& jacobian_indices = multi_indices<D, D>;

/// Position of the coefficient at each vertex; such a coefficient is a value of det J.
template <int D>
inline constexpr std::array<int, D + 1> corner_coefficients = [] {
    std::array<int, D + 1> corners{};
    for (int i = 0; i <= D; ++i) {
        MultiIndex<D> alpha{};
        alpha[i] = D;
        corners[i] = position<D, D>(alpha);
    }
    return corners;
}();

}  // namespace camber

namespace camber {

/// What follows is for any kind of number, packs of doubles too (core:pack): so it is always inlined.

/// d[a−1][i] = P_{e_i+e_a} − P_{e_i+e_0}: column a of J is 2 Σ_i ξ_i d[a−1][i] (a = 1 … D, i = 0 … D).
template <int D, class Real>
using ColumnPoints = std::array<std::array<std::array<Real, D>, D + 1>, D>;

/// A bound on |d[a−1][i]|, component by component, the same for all i; and never less than `smallest_bound`.
template <int D, class Real>
using ColumnBounds = std::array<std::array<Real, D>, D>;

/// Position of the node of the local edge i–j among the nodes of an element; the vertex when i = j.
template <int D>
inline constexpr auto node_between = [] {
    std::array<std::array<int, D + 1>, D + 1> table{};
    for (int i = 0; i <= D; ++i) table[i][i] = i;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const int a = local_edges<D>[e][0];
        const int b = local_edges<D>[e][1];
        table[a][b] = table[b][a] = D + 1 + e;
    }
    return table;
}();

/// u × v, as one number in 2D.
template <class Real>
[[nodiscard, gnu::always_inline]] constexpr std::array<Real, 3> product(const std::array<Real, 3>& u,
                                                                        const std::array<Real, 3>& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
template <class Real>
[[nodiscard, gnu::always_inline]] constexpr std::array<Real, 1> product(const std::array<Real, 2>& u,
                                                                        const std::array<Real, 2>& v) {
    return {u[0] * v[1] - u[1] * v[0]};
}

/// Σ over the ordered ways to write β = e_j + e_k of d_{D−1}[j] × d_D[k].
template <int D, std::size_t B, class Real>
[[nodiscard, gnu::always_inline]] constexpr auto pair_product(const ColumnPoints<D, Real>& d) {
    constexpr auto jk = [] {
        std::array<int, 2> found{-1, -1};
        for (int i = 0, n = 0; i <= D; ++i)
            for (int m = 0; m < multi_indices<2, D>[B][i]; ++m) found[n++] = i;
        return found;
    }();
    auto sum = product(d[D - 2][jk[0]], d[D - 1][jk[1]]);
    if constexpr (jk[0] != jk[1]) {
        const auto other = product(d[D - 2][jk[1]], d[D - 1][jk[0]]);
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += other[c];
    }
    return sum;
}

/// Σ over the vertices i of α of d_1[i] · (pair product of α − e_i), times 8 / multinomial(α): the mean over the
/// ordered ways α = e_i + e_j + e_k of 8 det(d_1[i], d_2[j], d_3[k]) (Johnen, Remacle, Geuzaine 2013).
template <std::size_t A, class Real, class Pairs>
[[nodiscard, gnu::always_inline]] constexpr Real triple_coefficient(const ColumnPoints<3, Real>& d,
                                                                    const Pairs& pairs) {
    constexpr auto alpha = multi_indices<3, 3>[A];
    Real sum{};
    const auto add = [&]<std::size_t I>(std::integral_constant<std::size_t, I>) __attribute__((always_inline)) {
        if constexpr (alpha[I] > 0) {
            constexpr int beta = [] {
                auto rest = multi_indices<3, 3>[A];
                --rest[I];
                return position<2, 3>(rest);
            }();
            const auto& u = d[0][I];
            const auto& v = pairs[beta];
            sum += u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        }
    };
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
        (add(std::integral_constant<std::size_t, I>{}), ...);
    }(std::make_index_sequence<4>{});
    return sum * (8.0 / multinomial<3>(alpha));
}

/// The coefficients of det J from its columns: a fixed sum of products, no branches.
template <int D, class Real>
[[nodiscard, gnu::always_inline]] inline std::array<Real, jacobian_coefficients<D>> coefficients_of(
    const ColumnPoints<D, Real>& d) {
    const auto pairs = [&]<std::size_t... B>(std::index_sequence<B...>) __attribute__((always_inline)) {
        return std::array{pair_product<D, B>(d)...};
    }(std::make_index_sequence<node_count<2, D>>{});
    if constexpr (D == 2)
        return [&]<std::size_t... A>(std::index_sequence<A...>) __attribute__((always_inline)) {
            return std::array{pairs[A][0] * (4.0 / multinomial<2>(multi_indices<2, 2>[A]))...};
        }(std::make_index_sequence<6>{});
    else
        return [&]<std::size_t... A>(std::index_sequence<A...>) __attribute__((always_inline)) {
            return std::array{triple_coefficient<A>(d, pairs)...};
        }(std::make_index_sequence<20>{});
}

template <class Real>
[[nodiscard, gnu::always_inline]] constexpr Real magnitude(Real x) {
    return x < 0 ? -x : x;
}
template <class Real>
[[nodiscard, gnu::always_inline]] constexpr Real larger(Real a, Real b) {
    return a > b ? a : b;
}

/// γ of the bound below: 32 u for doubles, u = 2⁻⁵³, and 32 · 2⁻⁹⁵ for Twice, whose operations err by less than 2⁻¹⁰⁰
/// (the rounding of its factor and result to doubles is in `rounded`).
template <class Real>
inline constexpr double rounding_factor = 0x1p-48;
template <>
inline constexpr double rounding_factor<Twice> = 0x1p-90;

/// Added to every w: makes γ w larger than what underflow can take from an entry of d (half an edge between denormal
/// numbers; in Twice the low part of any product), which then is multiplied by other columns that may be huge.
template <class Real>
inline constexpr double smallest_bound = 0x1p-1020;
template <>
inline constexpr double smallest_bound<Twice> = 0x1p-970;

/// |coefficient error| ≤ γ · 2^D perm(w), with w ≥ |d| and |error of d| ≤ (2u + u²) w. A coefficient is a mean of
/// products 2^D d_1 d_2 d_3, each at most 2^D perm(w); of relative roundings a product meets 6 from d (2 for each
/// factor), and 10 from multiplying, summing and the factor: pair product 2, sum of pairs 1, times d_1 1, sum over
/// axes 2, over vertices 2, 8/multinomial 2. 16 u of second order 16² u² and the roundings of w and perm themselves
/// (at most 14, of the bound alone) leave half of γ. On a triangle: 4 from d, 3 from the rest.
/// The same bound holds for the mean of up to three such sums (`motion`), which takes 4 roundings more, and for the det
/// of the straight element: its columns are below 2 w, with one rounding each.
/// The last term covers underflow: less than 2⁻¹⁰⁷⁰ for each of the 64 products, times |d_1|. Sums are made large
/// first, so that the bound overflows before any partial sum of a coefficient can: then `finite` is false.
template <int D, class Real>
[[nodiscard, gnu::always_inline]] constexpr Real error_bound(const ColumnBounds<D, Real>& w) {
    constexpr double rounding = rounding_factor<Real> * 0x1p-8;
    constexpr double underflow = 0x1p-1060;
    if constexpr (D == 2) {
        return (4 * rounding) * (256 * (w[0][0] * w[1][1] + w[0][1] * w[1][0])) + underflow;
    } else {
        const Real permanent = w[0][0] * (w[1][1] * w[2][2] + w[1][2] * w[2][1]) +
                               w[0][1] * (w[1][2] * w[2][0] + w[1][0] * w[2][2]) +
                               w[0][2] * (w[1][0] * w[2][1] + w[1][1] * w[2][0]);
        return (8 * rounding) * (256 * permanent) + underflow * (1 + w[0][0] + w[0][1] + w[0][2]);
    }
}

template <int D, class Real>
[[nodiscard, gnu::always_inline]] inline Real determinant(const std::array<std::array<Real, D>, D>& columns) {
    if constexpr (D == 2) {
        return product(columns[0], columns[1])[0];
    } else {
        const auto v = product(columns[1], columns[2]);
        return columns[0][0] * v[0] + columns[0][1] * v[1] + columns[0][2] * v[2];
    }
}

}  // namespace camber
