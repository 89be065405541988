module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>
/// Energy w ∫_K |∇u|² dx of the node displacements u of a straight element K with weight w.
export module camber.extension:energy;
import camber.core;
import camber.bezier;

export namespace camber {

/// Weight w of an element: (mean / |det J|)^stiffening, with the Jacobian matrix J of a simplex of the same volume.
/// Weights above 1e12 are reduced to 1e12, because rounding of larger ones would hide other elements.
struct Weighting {
    double mean = 1, stiffening = 0;

    [[nodiscard]] double of(double volume) const { return std::min(pow(mean / volume, stiffening), 1e12); }
};

template <Shape shape, int D>
using CornerPoints = std::array<Vec<D>, shape_table<shape>.corner_count>;

/// `volume` = |det J| and `gradients` = |det J| ∇ξ_a, for a linear map x(ξ) with Jacobian matrix J and S reference
/// coordinates ξ_a. For S < D, |det J| is the square root of det JᵀJ.
template <int S, int D>
struct ScaledInverse {
    double volume = 0;
    std::array<Vec<D>, S> gradients{};
};

/// `columns`: derivatives ∂x/∂ξ_a of the map.
template <int S, int D>
[[nodiscard]] ScaledInverse<S, D> scaled_inverse(const std::array<Vec<D>, S>& columns) {
    static_assert(S == D || (S == 2 && D == 3), "elements, or faces in space");
    if constexpr (S == D) {
        const Mat<D> matrix{columns};
        return {std::abs(det(matrix)), cofactors(matrix)};
    } else {
        const auto& [a, b] = columns;
        const Vec<D> normal = cross(a, b);
        const double volume = norm(normal);
        return {volume, {cross(b, normal) / volume, cross(normal, a) / volume}};
    }
}

template <int S, int D>
[[nodiscard]] ScaledInverse<S, D> scaled_inverse(const std::array<Vec<D>, S + 1>& corners) {
    std::array<Vec<D>, S> columns;
    for (int a = 0; a < S; ++a) columns[a] = corners[a + 1] - corners[0];
    return scaled_inverse<S, D>(columns);
}

/// Number of an element's nodes without its corners. These nodes are numbered from 0 in the order of `lagrange_nodes`.
template <Shape shape, int degree>
inline constexpr int moving_nodes = element_nodes<shape, degree> - shape_table<shape>.corner_count;

/// Energy of an element in compact form. For simplices of any degree, `products` contains w |det J| ∇ξ_i · ∇ξ_j for
/// each edge ij; the squares |∇ξ_i|² follow from Σ ∇ξ_i = 0. For other shapes, `products` contains the lower triangle
/// (by rows) of the energy matrix of the nodes other than corners.
template <Shape shape, int degree>
struct ElementEnergy {
    static constexpr int moving = moving_nodes<shape, degree>;
    std::array<double, is_simplex(shape) ? shape_table<shape>.edge_count : moving*(moving + 1) / 2> products{};
    double height = std::numeric_limits<double>::infinity();  ///< smallest height of the element
};

}  // namespace camber

namespace camber {

/// Factor of all matrix entries: (S + 2)!/16 in dimension S. With this factor, entries of quadratic simplices are
/// integer combinations of `ElementEnergy::products`.
template <int S>
inline constexpr double energy_unit = [] {
    double factorial = 1;
    for (int i = 2; i <= S + 2; ++i) factorial *= i;
    return factorial / 16;
}();

/// Local numbers of the other edges of a simplex, for its edge ij. For each further vertex k, `first` is the edge ik
/// and `second` the edge jk. In a tetrahedron, `opposite` connects the two further vertices.
template <int S>
struct EdgesBeside {
    std::array<int, S - 1> first{}, second{};
    int opposite = 0;
};

template <int S>
inline constexpr auto edges_beside = [] {
    const auto between = [](int a, int b) {
        int k = 0;
        while (local_edges<S>[k] != std::array{a, b} && local_edges<S>[k] != std::array{b, a}) ++k;
        return k;
    };
    std::array<EdgesBeside<S>, edges_per_simplex<S>> table{};
    for (int e = 0; e < edges_per_simplex<S>; ++e) {
        const auto [i, j] = local_edges<S>[e];
        std::array<int, S - 1> others{};
        for (int k = 0, n = 0; k <= S; ++k)
            if (k != i && k != j) others[n++] = k;
        for (int n = 0; n < S - 1; ++n) {
            table[e].first[n] = between(i, others[n]);
            table[e].second[n] = between(j, others[n]);
        }
        if constexpr (S == 3) table[e].opposite = between(others[0], others[1]);
    }
    return table;
}();

/// Coefficients of `ElementEnergy::products` in the matrix entries of nodes m and n other than corners.
template <int S, int degree>
const auto& product_coefficients() {
    constexpr Shape shape = simplex<S>;
    constexpr int corners = S + 1, moving = moving_nodes<shape, degree>;
    using Coefficients = std::array<double, edges_per_simplex<S>>;
    static const auto table = [] {
        std::vector<std::array<Coefficients, moving>> rows(moving);
        for (const ReferenceRulePoint& point : reference_rule<shape>(degree)) {
            const auto functions = lagrange_functions<shape, degree>(point.x);
            // Let g_ab = ∇ξ_a · ∇ξ_b and ∂_a = ∂/∂ξ_a. The basis functions φ, ψ are functions of ξ_1 … ξ_S, so ∂_0 φ =
            // 0. Since Σ_a ∇ξ_a = 0, each g_aa is −Σ_(b ≠ a) g_ab. Therefore:
            //     ∇φ · ∇ψ = −Σ_(edges ab) (∂_a − ∂_b) φ (∂_a − ∂_b) ψ g_ab
            const auto difference = [&](int node, int edge) {
                const auto [a, b] = local_edges<S>[edge];
                const ReferencePoint& gradient = functions.gradients[corners + node];
                return (a > 0 ? gradient[a - 1] : 0) - (b > 0 ? gradient[b - 1] : 0);
            };
            for (int m = 0; m < moving; ++m)
                for (int n = 0; n < moving; ++n)
                    for (int e = 0; e < edges_per_simplex<S>; ++e)
                        rows[m][n][e] -= energy_unit<S> * point.weight * difference(m, e) * difference(n, e);
        }
        return rows;
    }();
    return table;
}

template <Shape shape, int degree>
struct ReferenceGradients {
    double weight = 0;
    decltype(LagrangeFunctions<shape, 1>::gradients) of_corners{};
    decltype(LagrangeFunctions<shape, degree>::gradients) of_nodes{};
};
template <Shape shape, int degree>
const std::vector<ReferenceGradients<shape, degree>>& reference_gradients() {
    static const auto table = [] {
        std::vector<ReferenceGradients<shape, degree>> points;
        for (const ReferenceRulePoint& point : reference_rule<shape>(degree + 1))
            points.push_back({point.weight, lagrange_functions<shape, 1>(point.x).gradients,
                              lagrange_functions<shape, degree>(point.x).gradients});
        return points;
    }();
    return table;
}

/// The shape is a product of simplices. Returns the largest |∇ξ| of their barycentric coordinates ξ: 1 / smallest
/// height.
template <Shape shape, int S, int D>
[[nodiscard]] double steepest_gradient(const ScaledInverse<S, D>& at) {
    double steepest = 0;
    int first = 0;
    for (const int dimension : factors<shape>) {
        Vec<D> rest;
        for (int d = first; d < first + dimension; ++d) {
            rest -= at.gradients[d];
            steepest = std::max(steepest, norm(at.gradients[d]));
        }
        steepest = std::max(steepest, norm(rest));
        first += dimension;
    }
    return steepest / at.volume;
}

template <Shape shape, int degree, int D>
[[nodiscard]] ElementEnergy<shape, degree> energy_by_quadrature(const CornerPoints<shape, D>& corners,
                                                                const Weighting& weighting) {
    constexpr int S = shape_table<shape>.dimension, moving = moving_nodes<shape, degree>;
    ElementEnergy<shape, degree> energy;
    double volume = 0, steepest = 0;
    for (const auto& [weight, of_corners, of_nodes] : reference_gradients<shape, degree>()) {
        std::array<Vec<D>, S> columns{};
        for (std::size_t c = 0; c < corners.size(); ++c)
            for (int d = 0; d < S; ++d) columns[d] += of_corners[c][d] * corners[c];
        const auto at = scaled_inverse<S, D>(columns);
        const auto gradient = [&](const ReferencePoint& reference) {
            Vec<D> sum;
            for (int d = 0; d < S; ++d) sum += reference[d] * at.gradients[d];
            return sum;
        };
        volume += weight * at.volume;
        steepest = std::max(steepest, steepest_gradient<shape>(at));
        std::array<Vec<D>, moving> gradients;
        for (int n = 0; n < moving; ++n) gradients[n] = gradient(of_nodes[corners.size() + n]);
        for (int m = 0, k = 0; m < moving; ++m)
            for (int n = 0; n <= m; ++n, ++k)
                energy.products[k] += weight / at.volume * dot(gradients[m], gradients[n]);
    }
    constexpr int of_simplex = S == 3 ? 6 : 2;  // |det J| of a simplex divided by its volume
    const double factor = energy_unit<S> * weighting.of(of_simplex * volume);
    for (double& product : energy.products) product *= factor;
    if (!std::ranges::all_of(energy.products, [](double product) { return std::isfinite(product); })) return {};
    energy.height = 1 / steepest;
    return energy;
}

template <int S, int degree, int D>
[[nodiscard]] ElementEnergy<simplex<S>, degree> energy_of_simplex(const std::array<Vec<D>, S + 1>& corners,
                                                                  const Weighting& weighting) {
    // `rows` are v ∇ξ_a with v = `volume` = |det J|. The products w v ∇ξ_a · ∇ξ_b therefore have the factor w/v.
    const auto [volume, rows] = scaled_inverse<S, D>(corners);
    const double factor = weighting.of(volume) / volume;
    ElementEnergy<simplex<S>, degree> energy;
    if (!std::isfinite(factor)) return energy;
    std::array<Vec<D>, S + 1> gradients{};
    for (int a = 0; a < S; ++a) gradients[a + 1] = rows[a], gradients[0] -= rows[a];
    double steepest = 0;
    for (const Vec<D>& g : gradients) steepest = std::max(steepest, norm_squared(g));
    energy.height = volume / std::sqrt(steepest);
    for (int k = 0; k < edges_per_simplex<S>; ++k)
        energy.products[k] = factor * dot(gradients[local_edges<S>[k][0]], gradients[local_edges<S>[k][1]]);
    return energy;
}

}  // namespace camber

export namespace camber {

/// Computes the energy of a straight element; it is zero if the element is degenerate. The energy is exact for
/// simplices and for affine elements. Other shapes use a quadrature rule with degree + 1 points per direction.
template <Shape shape, int degree, int D>
    requires(shape != Shape::pyramid)
[[nodiscard]] ElementEnergy<shape, degree> element_energy(const CornerPoints<shape, D>& corners,
                                                          const Weighting& weighting) {
    if constexpr (is_simplex(shape))
        return energy_of_simplex<shape_table<shape>.dimension, degree, D>(corners, weighting);
    else
        return energy_by_quadrature<shape, degree, D>(corners, weighting);
}

/// Calls add(n, entry) for each node n other than corners. The entry is w ∫ ∇φ_own · ∇φ_n dx times `energy_unit`, where
/// φ_n is the basis function of node n.
template <Shape shape, int degree, class Add>
void each_row_entry(const ElementEnergy<shape, degree>& energy, int own, const Add& add) {
    constexpr int moving = moving_nodes<shape, degree>;
    if constexpr (is_simplex(shape) && degree == 2) {
        // The entries follow from ∫ ξ_a ξ_b = (1 + δ_ab) · constant over the simplex, with the Kronecker symbol δ_ab.
        constexpr int S = shape_table<shape>.dimension;
        const auto& g = energy.products;
        const auto& beside = edges_beside<S>[own];
        double firsts = 0;
        double seconds = 0;
        for (int n = 0; n < S - 1; ++n) firsts += g[beside.first[n]], seconds += g[beside.second[n]];
        add(own, -2 * (g[own] + firsts + seconds));
        for (int n = 0; n < S - 1; ++n) {
            const double b = g[beside.first[n]];
            const double d = g[beside.second[n]];
            add(beside.first[n], 2 * d + b - firsts);
            add(beside.second[n], 2 * b + d - seconds);
        }
        if constexpr (S == 3) add(beside.opposite, firsts + seconds);
    } else if constexpr (is_simplex(shape)) {
        const auto& row = product_coefficients<shape_table<shape>.dimension, degree>()[own];
        for (int n = 0; n < moving; ++n) {
            double sum = 0;
            for (std::size_t e = 0; e < energy.products.size(); ++e) sum += row[n][e] * energy.products[e];
            add(n, sum);
        }
    } else {
        for (int n = 0; n < moving; ++n) {
            const int row = std::max(own, n), column = std::min(own, n);
            add(n, energy.products[row * (row + 1) / 2 + column]);
        }
    }
}

}  // namespace camber
