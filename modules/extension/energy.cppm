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

/// Weight of an element by |det| of a simplex with the same volume. It is bounded, so that the smallest elements do not
/// hide others by rounding.
struct Weighting {
    double mean = 1, stiffening = 0;

    [[nodiscard]] double of(double volume) const { return std::min(pow(mean / volume, stiffening), 1e12); }
};

template <Shape shape, int D>
using CornerPoints = std::array<Vec<D>, shape_table<shape>.corner_count>;

/// |det| of a linear map from dimension S (S < D: square root of the Gram determinant), and the gradients of reference
/// coordinates multiplied by |det|.
template <int S, int D>
struct ScaledInverse {
    double volume = 0;
    std::array<Vec<D>, S> gradients{};
};

/// `columns`: derivatives of the map by the reference coordinates.
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

/// Number of nodes other than corners, numbered from 0 in the order of `lagrange_nodes`.
template <Shape shape, int degree>
inline constexpr int moving_nodes = element_nodes<shape, degree> - shape_table<shape>.corner_count;

/// Stored energy of an element. Simplices of any degree store w |det| ∇ξ_i · ∇ξ_j for each edge ij; the squares |∇ξ_i|²
/// follow from Σ ∇ξ_i = 0. Other shapes store the lower triangle of the matrix of nodes other than corners, by rows.
template <Shape shape, int degree>
struct ElementEnergy {
    static constexpr int moving = moving_nodes<shape, degree>;
    std::array<double, is_simplex(shape) ? shape_table<shape>.edge_count : moving*(moving + 1) / 2> products{};
    double height = std::numeric_limits<double>::infinity();  ///< smallest height of the element
};

}  // namespace camber

namespace camber {

/// Common factor of matrix entries for dimension S. Quadratic simplices then need no other factor.
template <int S>
inline constexpr double energy_unit = [] {
    double factorial = 1;
    for (int i = 2; i <= S + 2; ++i) factorial *= i;
    return factorial / 16;
}();

/// Other edges of a simplex for its edge ij: `first` ik and `second` jk for each further vertex k; `opposite` joins
/// both in a tetrahedron.
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

/// Coefficients of the stored products in ∫ ∇φ_m · ∇φ_n over the reference simplex, for nodes m, n other than corners.
template <int S, int degree>
const auto& product_coefficients() {
    constexpr Shape shape = simplex<S>;
    constexpr int corners = S + 1, moving = moving_nodes<shape, degree>;
    using Coefficients = std::array<double, edges_per_simplex<S>>;
    static const auto table = [] {
        std::vector<std::array<Coefficients, moving>> rows(moving);
        for (const ReferenceRulePoint& point : reference_rule<shape>(degree)) {
            const auto functions = lagrange_functions<shape, degree>(point.x);
            // The functions depend on ξ_1 … ξ_S, so their derivatives by ξ_0 are 0. With g_ab = ∇ξ_a · ∇ξ_b, each g_aa
            // is minus the sum of g_ab over b ≠ a. Therefore Σ_ab ∂_a φ ∂_b ψ g_ab is −Σ_(edges ab) (∂_a − ∂_b) φ (∂_a
            // − ∂_b) ψ g_ab.
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

/// Largest gradient of barycentric coordinates of the simplices whose product is the shape: 1 / smallest height.
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
    constexpr int of_simplex = S == 3 ? 6 : 2;  // |det| / volume of a simplex
    const double factor = energy_unit<S> * weighting.of(of_simplex * volume);
    for (double& product : energy.products) product *= factor;
    if (!std::ranges::all_of(energy.products, [](double product) { return std::isfinite(product); })) return {};
    energy.height = 1 / steepest;
    return energy;
}

template <int S, int degree, int D>
[[nodiscard]] ElementEnergy<simplex<S>, degree> energy_of_simplex(const std::array<Vec<D>, S + 1>& corners,
                                                                  const Weighting& weighting) {
    // `rows` are gradients times |det|. A product of two has the factor 1/det², the integral the factor |det|.
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

/// Energy of a straight element; zero if the element is degenerate. Exact for simplices; other shapes use a rule of
/// degree + 1 points per direction, exact for affine elements.
template <Shape shape, int degree, int D>
    requires(shape != Shape::pyramid)
[[nodiscard]] ElementEnergy<shape, degree> element_energy(const CornerPoints<shape, D>& corners,
                                                          const Weighting& weighting) {
    if constexpr (is_simplex(shape))
        return energy_of_simplex<shape_table<shape>.dimension, degree, D>(corners, weighting);
    else
        return energy_by_quadrature<shape, degree, D>(corners, weighting);
}

/// Calls add(n, entry) for each entry of row `own`: w ∫ ∇φ_own · ∇φ_n dx times (S + 2)!/16, S the element's dimension,
/// n a node other than corners.
template <Shape shape, int degree, class Add>
void each_row_entry(const ElementEnergy<shape, degree>& energy, int own, const Add& add) {
    constexpr int moving = moving_nodes<shape, degree>;
    if constexpr (is_simplex(shape) && degree == 2) {
        // The entries follow from ∫ ξ_a ξ_b = (1 + δ_ab) · constant over the simplex.
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
