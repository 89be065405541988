module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>
module camber.optimisation:joint_slack;
import :jacobian_gradient;
import :joint_programme;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

template <int D>
[[nodiscard]] inline std::array<Vec<D>, D> straight_columns(const QuadraticSimplex<D, D>& element) {
    std::array<Vec<D>, D> columns;
    for (int a = 0; a < D; ++a) columns[a] = element.control[a + 1] - element.control[0];
    return columns;
}

template <int D>
[[nodiscard]] inline double straight_determinant(const QuadraticSimplex<D, D>& element) {
    const auto columns = straight_columns<D>(element);
    return dot(columns[0], determinant_gradient(columns)[0]);
}

/// What an element's constraints are divided by: |det straight| at the start; a flat element's largest coefficient.
template <int D>
[[nodiscard]] inline double slack_scale(const QuadraticSimplex<D, D>& element) {
    const double straight = std::abs(straight_determinant<D>(element));
    double largest = 0;
    for (const double c : jacobian(element)) largest = std::max(largest, std::abs(c));
    return std::max({straight, 1e-6 * largest, 1e-300});
}

/// P_i = p_i + δ_i and P_ij = p_ij + 2 m_ij + (δ_i + δ_j)/2: the node n_ij + m_ij + (δ_i + δ_j)/2 in Bézier form.
template <int D>
[[nodiscard]] inline QuadraticSimplex<D, D> displaced(const typename JointProgramme<D>::Element& element,
                                                      const std::vector<Vec<D>>& offsets) {
    const auto moved = [&](int node) {
        const int unknown = element.unknowns[node];
        return unknown == JointProgramme<D>::fixed ? Vec<D>{} : offsets[static_cast<std::size_t>(unknown)];
    };
    QuadraticSimplex<D, D> out = element.bezier;
    for (int i = 0; i <= D; ++i) out.control[i] += moved(i);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        out.control[D + 1 + e] += 2 * moved(D + 1 + e) + 0.5 * (moved(i) + moved(j));
    }
    return out;
}

template <int D>
using Slacks = std::array<double, jacobian_coefficients<D>>;

/// What the coefficients of an element are to be above.
struct SlackLevel {
    double floor = 0;  ///< of |det straight|
    double least = -std::numeric_limits<double>::infinity();
};

/// (c − max(floor · |det straight|, least)) / scale for all coefficients of a displaced element.
template <int D>
[[nodiscard]] inline Slacks<D> slacks_of(const QuadraticSimplex<D, D>& element, SlackLevel of, double scale) {
    Slacks<D> g = jacobian(element);
    const double level = std::max(of.floor * std::abs(straight_determinant<D>(element)), of.least);
    for (double& x : g) x = (x - level) / scale;
    return g;
}

/// What an element's slacks change by with the offsets of its vertices and edges.
template <int D>
using SlackGradients = std::array<std::array<Vec<D>, quadratic_nodes<D>>, jacobian_coefficients<D>>;

template <int D>
[[nodiscard]] inline SlackGradients<D> slack_gradients(const QuadraticSimplex<D, D>& element, SlackLevel of,
                                                       double scale) {
    const auto columns = straight_columns<D>(element);
    const auto cofactor = determinant_gradient(columns);
    const double straight = dot(columns[0], cofactor[0]);
    const double floor = of.floor * std::abs(straight) < of.least ? 0 : of.floor;
    const double side = straight < 0 ? -floor : floor;
    SlackGradients<D> gradients = jacobian_gradient(element).gradient;
    for (auto& g : gradients) {
        for (int a = 0; a < D; ++a) {
            g[a + 1] -= side * cofactor[a];
            g[0] += side * cofactor[a];
        }
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            g[i] += 0.5 * g[D + 1 + e];
            g[j] += 0.5 * g[D + 1 + e];
            g[D + 1 + e] *= 2;
        }
        for (auto& x : g) x *= 1 / scale;
    }
    return gradients;
}

}  // namespace camber
