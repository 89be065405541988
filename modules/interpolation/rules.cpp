// Conical quadrature rules with differentiation tables.
module;
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Returns the differentiation matrix at the nodes x, row by row (barycentric formula).
std::vector<double> differentiation(const std::vector<double>& x) {
    const std::size_t n = x.size();
    std::vector<double> weight(n, 1), matrix(n * n, 0);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            if (j != i) weight[i] /= x[i] - x[j];
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            if (j != i) {
                matrix[i * n + j] = weight[j] / weight[i] / (x[i] - x[j]);
                matrix[i * n + i] -= matrix[i * n + j];
            }
    return matrix;
}

}  // namespace

template <int D>
CollapsedRule<D>::CollapsedRule(int points_per_direction) : n(points_per_direction) {
    const auto m = static_cast<std::size_t>(n);
    const std::vector<RulePoint<D>> points = conical_rule<D>(n);
    count = points.size();
    for (int d = 0; d < D; ++d) {
        nodes_[d] = gauss_jacobi(n, d).nodes;
        matrices_[d] = differentiation(nodes_[d]);
    }
    weights.assign(count, 0);
    for (auto& b : barycentric) b.assign(count, 0);
    for (auto& a : amplification) a.assign(count, 0);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        bubbles[e].assign(count, 0);
        for (auto& slope : bubble_slopes[e]) slope.assign(count, 0);
    }
    for (std::size_t p = 0; p < count; ++p) {
        weights[p] = points[p].weight;
        for (int i = 0; i <= D; ++i) barycentric[i][p] = points[p].xi[i];
        std::size_t stride = count;
        for (int d = D - 1; d >= 0; --d) {
            stride /= m;
            const std::size_t i = p / stride % m;
            for (std::size_t c = 0; c < m; ++c) {
                const double factor = matrices_[d][i * m + c];
                amplification[d][p] += factor * factor;
            }
        }
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            bubbles[e][p] = 4 * barycentric[i][p] * barycentric[j][p];
            const auto slope = [&](int vertex, int axis) {
                return vertex == 0 ? -1.0 : vertex == axis + 1 ? 1.0 : 0.0;
            };
            for (int a = 0; a < D; ++a)
                bubble_slopes[e][a][p] = 4 * (slope(i, a) * barycentric[j][p] + barycentric[i][p] * slope(j, a));
        }
        // ∂/∂ξ_d = Π_{k>d} 1/(1 − t_k) ∂/∂t_d + Σ_{k<d} c_k ∂/∂ξ_k with 0 ≤ c_k ≤ 1, where t are the coordinates of the
        // cube.
        double below = 0;
        for (int d = 0; d < D; ++d) {
            double above = 1;
            std::size_t step = count;
            for (int k = D - 1; k > d; --k) {
                step /= m;
                above *= 1 - nodes_[k][p / step % m];
            }
            amplification[d][p] = amplification[d][p] / (above * above) + below;
            below += amplification[d][p];
        }
    }
}

template <int D>
void CollapsedRule<D>::differentiate(const std::vector<double>& values,
                                     std::array<std::vector<double>, D>& slopes) const {
    const auto m = static_cast<std::size_t>(n);
    std::size_t stride = 1;
    for (int d = 0; d < D; ++d) {
        std::vector<double>& out = slopes[d];
        const std::vector<double>& matrix = matrices_[d];
        // Values are stored in blocks of m rows with `stride` values each. The coordinate t_d increases from row to
        // row.
        for (std::size_t begin = 0; begin < count; begin += m * stride)
            for (std::size_t r = 0; r < m; ++r) {
                double* row = out.data() + begin + r * stride;
                for (std::size_t s = 0; s < stride; ++s) row[s] = 0;
                for (std::size_t c = 0; c < m; ++c) {
                    const double factor = matrix[r * m + c];
                    const double* value = values.data() + begin + c * stride;
                    for (std::size_t s = 0; s < stride; ++s) row[s] += factor * value[s];
                }
            }
        stride *= m;
    }
    to_reference(slopes);
}

template <int D>
void CollapsedRule<D>::to_reference(std::array<std::vector<double>, D>& slopes) const {
    const auto m = static_cast<std::size_t>(n);
    for (std::size_t p = 0; p < count; ++p) {
        if constexpr (D == 2) {
            const double a = nodes_[0][p % m], b = nodes_[1][p / m];
            const double first = slopes[0][p] / (1 - b);
            slopes[0][p] = first;
            slopes[1][p] += a * first;
        } else {
            const double a = nodes_[0][p % m], b = nodes_[1][p / m % m], c = nodes_[2][p / m / m];
            const double first = slopes[0][p] / ((1 - b) * (1 - c));
            const double second = slopes[1][p] / (1 - c) + a * first;
            slopes[0][p] = first;
            slopes[1][p] = second;
            slopes[2][p] += a * (1 - b) * first + b * second;
        }
    }
}

#define CAMBER_INSTANTIATE(D) template struct CollapsedRule<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
