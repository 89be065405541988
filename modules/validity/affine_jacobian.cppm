module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>
export module camber.validity:affine_jacobian;
import camber.core;
import camber.bezier;
import :coefficients;
import :jacobian;

export namespace camber {

/// A function affine in x ∈ R^M: gradient · x + offset.
template <int M>
struct AffineFunction {
    Vec<M> gradient;
    double offset = 0;

    [[nodiscard]] constexpr double operator()(const Vec<M>& x) const { return dot(gradient, x) + offset; }
    friend bool operator==(const AffineFunction&, const AffineFunction&) = default;
};

/// All Bézier coefficients of det J of an element as functions of x = P − P_0, P the node of one of its edges and P_0
/// where it is, divided by `scale`.
template <int D>
struct AffineJacobian {
    std::array<AffineFunction<D>, jacobian_coefficients<D>> coefficients{};
    double scale = 1;     ///< |det of the straight element|; the largest coefficient where that is flat
    double straight = 0;  ///< |det of the straight element| / scale: 1, or about 0
    double error = 0;     ///< of the coefficients at P_0, divided by scale
};

}  // namespace camber

namespace camber {

/// The element's vertices in an even order that puts a local edge last: edge 2–3 of a tetrahedron, 1–2 of a triangle.
template <int D>
[[nodiscard]] constexpr std::array<int, D + 1> edge_last(int edge) {
    const auto [a, b] = local_edges<D>[edge];
    if constexpr (D == 2) {
        const int c = 3 - a - b;
        return (a + 1) % 3 == b ? std::array{c, a, b} : std::array{c, b, a};
    } else {
        std::array<int, 4> order{-1, -1, a, b};
        for (int i = 0, n = 0; i < 4; ++i)
            if (i != a && i != b) order[n++] = i;
        int inversions = 0;
        for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
        if (inversions % 2 == 1) std::swap(order[0], order[1]);
        return order;
    }
}

/// The derivatives of the coefficients with respect to the node of the last edge, D−1 to D. It enters column D of J at
/// vertex D−1 and column D−1 at vertex D, twice each; so with the cofactors of these columns, which are products of the
/// others (J = J_0 + P ⊗ g: what stands beside P does not depend on P).
template <int D, std::size_t A>
[[nodiscard]] constexpr Vec<D> coefficient_gradient(const auto& of_last, const auto& of_other) {
    constexpr auto alpha = jacobian_indices<D>[A];
    Vec<D> gradient;
    const auto add = [&]<int I>(std::integral_constant<int, I>, const auto& cofactors) {
        if constexpr (alpha[I] > 0) {
            constexpr int beta = [] {
                auto rest = jacobian_indices<D>[A];
                --rest[I];
                return position<D - 1, D>(rest);
            }();
            for (int c = 0; c < D; ++c) gradient[c] += cofactors[beta][c];
        }
    };
    add(std::integral_constant<int, D - 1>{}, of_last);
    add(std::integral_constant<int, D>{}, of_other);
    return ((D == 2 ? 8.0 : 16.0) / multinomial<D>(alpha)) * gradient;
}

/// Cofactors of columns D and D−1 of J / 2, as Bézier coefficients of degree D − 1.
template <int D>
[[nodiscard]] constexpr auto cofactors_of(const ColumnPoints<D, double>& d) {
    constexpr int count = node_count<D - 1, D>;
    std::array<std::array<std::array<double, D>, count>, 2> both{};
    if constexpr (D == 2) {
        for (int m = 0; m <= D; ++m) {
            MultiIndex<2> beta{};
            ++beta[m];
            both[0][position<1, 2>(beta)] = {-d[0][m][1], d[0][m][0]};
            both[1][position<1, 2>(beta)] = {d[1][m][1], -d[1][m][0]};
        }
    } else {
        const ColumnPoints<3, double> last{{{}, d[0], d[1]}};
        const ColumnPoints<3, double> other{{{}, d[2], d[0]}};
        [&]<std::size_t... B>(std::index_sequence<B...>) {
            ((both[0][B] = pair_product<3, B>(last), both[1][B] = pair_product<3, B>(other)), ...);
        }(std::make_index_sequence<count>{});
    }
    return both;
}

}  // namespace camber

export namespace camber {

/// Of an element, as functions of the node of its local edge `edge`. The order of the coefficients is that of the
/// element with the edge's vertices last.
template <int D>
[[nodiscard]] inline AffineJacobian<D> affine_jacobian(const NodalSimplex<D>& s, int edge) {
    const auto order = edge_last<D>(edge);
    const auto node = [&](int i, int j) -> const Vec<D>& { return s.nodes[node_between<D>[order[i]][order[j]]]; };
    ColumnPoints<D, double> d;
    ColumnBounds<D, double> w{};
    std::array<std::array<double, D>, D> straight;
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) {
            straight[a - 1][c] = node(a, a)[c] - node(0, 0)[c];
            const double half = 0.5 * straight[a - 1][c];
            double largest = 0;
            for (int i = 0; i <= D; ++i) {
                const double twice = 2 * (node(i, a)[c] - node(i, 0)[c]);
                d[a - 1][i][c] = twice - half;
                largest = larger(largest, magnitude(twice));
            }
            w[a - 1][c] = largest + magnitude(half);
        }
    const auto values = coefficients_of<D, double>(d);
    const auto cofactors = cofactors_of<D>(d);
    const double error = error_bound<D, double>(w);
    const double volume = std::abs(determinant<D, double>(straight));

    AffineJacobian<D> j;
    j.scale = volume;
    if (!(volume > 2 * error)) {
        j.scale = std::numeric_limits<double>::min();
        for (const double v : values) j.scale = std::max(j.scale, std::abs(v));
    }
    j.straight = volume / j.scale;
    j.error = error / j.scale;
    [&]<std::size_t... A>(std::index_sequence<A...>) {
        ((j.coefficients[A] = {coefficient_gradient<D, A>(cofactors[0], cofactors[1]) / j.scale, values[A] / j.scale}),
         ...);
    }(std::make_index_sequence<jacobian_coefficients<D>>{});
    return j;
}

}  // namespace camber
