module;
#include <array>
#include <cstddef>
module camber.optimisation:jacobian_gradient;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

/// The Bézier coefficients of det J of an element and what they change by when one of its Bézier points moves, in the
/// orders of multi_indices<D, D> and QuadraticSimplex.
template <int D>
struct JacobianGradient {
    std::array<double, jacobian_coefficients<D>> value{};
    std::array<std::array<Vec<D>, quadratic_nodes<D>>, jacobian_coefficients<D>> gradient{};
};

/// Position of the Bézier point between local vertices i and j in a QuadraticSimplex; the vertex when i = j.
template <int D>
inline constexpr auto control_between = [] {
    std::array<std::array<int, D + 1>, D + 1> table{};
    for (int i = 0; i <= D; ++i) table[i][i] = i;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        table[i][j] = table[j][i] = D + 1 + e;
    }
    return table;
}();

/// ∂ det(c_1 … c_D) / ∂ c_a: the cofactors.
[[nodiscard]] constexpr std::array<Vec<2>, 2> determinant_gradient(const std::array<Vec<2>, 2>& c) {
    return {Vec<2>{{c[1][1], -c[1][0]}}, Vec<2>{{-c[0][1], c[0][0]}}};
}
[[nodiscard]] constexpr std::array<Vec<3>, 3> determinant_gradient(const std::array<Vec<3>, 3>& c) {
    return {cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])};
}

/// One ordered way to write α = Σ_a e_{i_a}, as c_α needs it.
template <int D>
struct CoefficientWay {
    int position = 0;         ///< of α
    std::array<int, D> at{};  ///< i_a
    double weight = 0;        ///< 2^D by the number of such ways
};

template <int D>
inline constexpr auto coefficient_ways = [] {
    std::array<CoefficientWay<D>, D == 2 ? 9 : 64> ways{};
    for (int w = 0; w < static_cast<int>(ways.size()); ++w) {
        MultiIndex<D> alpha{};
        for (int a = 0, rest = w; a < D; ++a, rest /= D + 1) ++alpha[ways[w].at[a] = rest % (D + 1)];
        ways[w].position = position<D, D>(alpha);
        ways[w].weight = (1 << D) / static_cast<double>(multinomial<D>(alpha));
    }
    return ways;
}();

/// c_α is the mean over the ordered ways α = Σ_a e_{i_a} of 2^D det(d_1[i_1] … d_D[i_D]), d_a[i] = P_{e_i+e_a} −
/// P_{e_i+e_0} (Johnen, Remacle, Geuzaine 2013); each summand is linear in each of its columns.
template <int D>
[[nodiscard]] inline JacobianGradient<D> jacobian_gradient(const QuadraticSimplex<D, D>& element) {
    JacobianGradient<D> out;
    for (const auto& [p, at, weight] : coefficient_ways<D>) {
        std::array<Vec<D>, D> columns;
        for (int a = 0; a < D; ++a)
            columns[a] =
                element.control[control_between<D>[at[a]][a + 1]] - element.control[control_between<D>[at[a]][0]];
        const auto cofactor = determinant_gradient(columns);
        out.value[p] += weight * dot(columns[0], cofactor[0]);
        for (int a = 0; a < D; ++a) {
            const Vec<D> g = weight * cofactor[a];
            out.gradient[p][control_between<D>[at[a]][a + 1]] += g;
            out.gradient[p][control_between<D>[at[a]][0]] -= g;
        }
    }
    return out;
}

}  // namespace camber
