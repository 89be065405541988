module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import :lattice_polynomial;
import :simplex_rule;
import :solution_nodes;

namespace camber {

namespace {

/// Factors of the values at the lattice.
template <int D>
using LatticeRow = std::array<double, lattice_size<D>>;

/// The factors in the polynomial's value at a place.
template <int D>
LatticeRow<D> values_row(const std::array<double, D + 1>& at) {
    const LatticeBasis<D>& basis = lattice_basis<D>();
    LatticeRow<D> row{};
    for (std::size_t m = 0; m < row.size(); ++m) {
        double monomial = 1;
        for (int i = 0; i < D; ++i) monomial *= power(at[i + 1], exponents<D, known_degree>[m][i]);
        for (std::size_t k = 0; k < row.size(); ++k) row[k] += monomial * basis[m][k];
    }
    return row;
}

template <int D>
void subtract(LatticeRow<D>& row, double factor, const LatticeRow<D>& other) {
    for (std::size_t k = 0; k < row.size(); ++k) row[k] -= factor * other[k];
}

/// The factors in u − u_h at the points of the rule.
template <int D>
using ResidualRows = std::array<LatticeRow<D>, simplex_rule<D>.size()>;
template <int D>
ResidualRows<D> residual_rows(int degree) {
    ResidualRows<D> rows{};
    for (std::size_t q = 0; q < rows.size(); ++q) {
        const auto& at = simplex_rule<D>[q].at;
        rows[q] = values_row<D>(at);
        for (int v = 0; v <= D; ++v) {
            std::array<double, D + 1> vertex{};
            vertex[v] = 1;
            subtract<D>(rows[q], degree == 1 ? at[v] : at[v] * (2 * at[v] - 1), values_row<D>(vertex));
        }
        if (degree == 1) continue;
        for (const auto& [i, j] : local_edges<D>) {
            std::array<double, D + 1> middle{};
            middle[i] = middle[j] = 0.5;
            subtract<D>(rows[q], 4 * at[i] * at[j], values_row<D>(middle));
        }
    }
    return rows;
}

/// ∫ (u − u_h)² over a simplex of volume 1.
template <int D>
double mean_square(const ResidualRows<D>& rows, const std::array<float, node_count<known_degree, D>>& values) {
    double sum = 0;
    for (std::size_t q = 0; q < rows.size(); ++q) {
        double residual = 0;
        for (std::size_t k = 0; k < values.size(); ++k) residual += rows[q][k] * static_cast<double>(values[k]);
        sum += simplex_rule<D>[q].weight * residual * residual;
    }
    return sum;
}

}  // namespace

template <int D>
Outcome<double> expected_error(const LinearMesh<D>& mesh, const KnownSolution<D>& solution, int degree,
                               const Execution& execution) {
    const std::size_t n = mesh.elements.size();
    const bool fits = std::ranges::all_of(solution, [&](const KnownField<D>& f) { return f.values.size() == n; });
    if (!fits || degree < 1 || degree > 2)
        return fail(ErrorKind::internal, "an expected error needs values for each element, and degree 1 or 2");
    constexpr double factorial = D == 2 ? 2 : 6;
    const ResidualRows<D> rows = residual_rows<D>(degree);
    const auto square = reduce_each(
        execution, n, 0.0,
        [&](double& sum, std::size_t e) {
            double of_fields = 0;
            for (const KnownField<D>& field : solution)
                of_fields += field.weight * field.weight * mean_square<D>(rows, field.values[e]);
            std::array<Vec<D>, D + 1> corners;
            for (std::size_t v = 0; v <= D; ++v) corners[v] = mesh.points[mesh.elements.vertices[e][v]];
            sum += of_fields * std::abs(signed_volume<D>(corners)) / factorial;
        },
        [](double a, double b) { return a + b; });
    if (!square) return fail(square.error());
    return (solution.size() == 1 ? std::ldexp(1.0, solution.front().exponent) : 1) * std::sqrt(*square);
}

template Outcome<double> expected_error<2>(const LinearMesh<2>&, const KnownSolution<2>&, int, const Execution&);
template Outcome<double> expected_error<3>(const LinearMesh<3>&, const KnownSolution<3>&, int, const Execution&);

}  // namespace camber
