module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.interpolation;
import camber.validity;

namespace camber {

namespace {

template <int D>
using LatticeRow = std::array<double, lattice_size<D>>;

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

/// Coefficients of the lattice values that yield the error u − u_h of the interpolant u_h at the points of a quadrature
/// rule. The rule is exact for (u − u_h)².
template <int D>
struct ResidualRule {
    std::vector<RulePoint<D>> points = conical_rule<D>(known_degree + 1);
    std::vector<LatticeRow<D>> rows;

    explicit ResidualRule(int degree) : rows(points.size()) {
        for (std::size_t q = 0; q < rows.size(); ++q) {
            const std::array<double, D + 1>& at = points[q].xi;
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
    }
};

/// Returns Σ weight² ∫ (u − u_h)² of the fields over an element; `det(point)` is |det J| at a point.
template <int D>
double squared_within(const ResidualRule<D>& rule, const KnownSolution<D>& solution, ElementId e, const auto& det) {
    double sum = 0;
    for (std::size_t q = 0; q < rule.points.size(); ++q) {
        double of_fields = 0;
        for (const KnownField<D>& field : solution) {
            double residual = 0;
            for (std::size_t k = 0; k < lattice_size<D>; ++k)
                residual += rule.rows[q][k] * static_cast<double>(field.values[e.index()][k]);
            of_fields += field.weight * field.weight * residual * residual;
        }
        sum += rule.points[q].weight * det(rule.points[q].xi) * of_fields;
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
        return fail(ErrorKind::internal, "the expected error needs values for each element, and degree 1 or 2");
    const ResidualRule<D> rule(degree);
    const auto square = reduce_each(
        execution, n, 0.0,
        [&](double& sum, std::size_t e) {
            std::array<Vec<D>, D + 1> corners;
            for (std::size_t v = 0; v <= D; ++v) corners[v] = mesh.points[mesh.elements.vertices[e][v]];
            const double det = std::abs(signed_volume<D>(corners));
            sum += squared_within<D>(rule, solution, ElementId(e), [&](const auto&) { return det; });
        },
        [](double a, double b) { return a + b; });
    if (!square) return fail(square.error());
    return (solution.size() == 1 ? std::ldexp(1.0, solution.front().exponent) : 1) * std::sqrt(*square);
}

template <int D>
Outcome<double> squared_error(const QuadraticMesh<D>& mesh, const KnownSolution<D>& solution,
                              const Execution& execution) {
    const ResidualRule<D> rule(2);
    return reduce_each(
        execution, mesh.linear.elements.size(), 0.0,
        [&](double& sum, std::size_t e) {
            const auto& vertices = mesh.linear.elements.vertices[e];
            std::array<Vec<D>, edges_per_simplex<D>> offsets;
            for (int k = 0; k < edges_per_simplex<D>; ++k)
                offsets[k] = edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
            sum += squared_within<D>(rule, solution, ElementId(e), [&](const std::array<double, D + 1>& at) {
                // Columns of J: the edge vectors from vertex 0, plus the derivatives of 4 λ_i λ_j times the offset of
                // each edge i–j.
                std::array<Vec<D>, D + 1> corners{};
                for (int a = 1; a <= D; ++a)
                    corners[a] = mesh.linear.points[vertices[a]] - mesh.linear.points[vertices[0]];
                for (int k = 0; k < edges_per_simplex<D>; ++k) {
                    const auto [i, j] = local_edges<D>[k];
                    corners[i] += (4 * at[j]) * offsets[k];
                    corners[j] += (4 * at[i]) * offsets[k];
                }
                return std::abs(signed_volume<D>(corners));
            });
        },
        [](double a, double b) { return a + b; });
}

template Outcome<double> squared_error<2>(const QuadraticMesh<2>&, const KnownSolution<2>&, const Execution&);
template Outcome<double> squared_error<3>(const QuadraticMesh<3>&, const KnownSolution<3>&, const Execution&);
template Outcome<double> expected_error<2>(const LinearMesh<2>&, const KnownSolution<2>&, int, const Execution&);
template Outcome<double> expected_error<3>(const LinearMesh<3>&, const KnownSolution<3>&, int, const Execution&);

namespace {

template <int D>
constexpr auto edge_functions = [] {
    std::array<std::array<double, edges_per_simplex<D>>, simplex_rule<D>.size()> at{};
    for (std::size_t q = 0; q < at.size(); ++q)
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            at[q][e] = 4 * simplex_rule<D>[q].at[i] * simplex_rule<D>[q].at[j];
        }
    return at;
}();
template <int D>
constexpr auto vertex_functions = [] {
    std::array<std::array<double, D + 1>, simplex_rule<D>.size()> at{};
    for (std::size_t q = 0; q < at.size(); ++q)
        for (int v = 0; v <= D; ++v) at[q][v] = simplex_rule<D>[q].at[v] * (2 * simplex_rule<D>[q].at[v] - 1);
    return at;
}();

template <int D>
[[gnu::always_inline]] inline PackPolynomial<D, known_degree> polynomial_of(const LatticePacks<D>& values) {
    const LatticeBasis<D>& basis = lattice_basis<D>();
    PackPolynomial<D, known_degree> polynomial{};
    for (std::size_t c = 0; c < basis.size(); ++c) {
        Pack sum = values[0] * basis[c][0];
        for (std::size_t k = 1; k < values.size(); ++k) sum += values[k] * basis[c][k];
        polynomial.c[c] = sum;
    }
    return polynomial;
}

template <int D>
[[gnu::always_inline]] inline PackSlope<D> value_at(const PackPolynomial<D, known_degree>& u, const PackFrame<D>& frame,
                                                    const PackVec<D>& from, const PackJacobian<D>& there,
                                                    const PackVec<D>& delta) {
    const auto place = frame.displaced(from, there, delta);
    PackSlope<D> at = u.at(place.at);
    at.gradient = place.jacobian.in_space(at.gradient);
    return at;
}

template <int D>
[[gnu::always_inline]] inline void add_error_packed(const ElementPacks<D>& elements, const LatticePacks<D>& field,
                                                    double weight, ErrorPacks<D>& sum) {
    constexpr int edges = edges_per_simplex<D>;
    constexpr double simplex = D == 2 ? 1.0 / 2 : 1.0 / 6;
    const PackFrame<D> frame(elements.axes, elements.frame_offsets);
    const auto u = polynomial_of<D>(field);
    std::array<PackVec<D>, edges> moves{};
    std::array<PackSlope<D>, edges> of_nodes{};
    for (int e = 0; e < edges; ++e) {
        PackVec<D> middle{};
        for (int i = 0; i < D; ++i) moves[e][i] = elements.offsets[e][i] - elements.frame_offsets[e][i];
        for (const int v : local_edges<D>[e])
            if (v > 0) middle[v - 1] += 0.5;
        of_nodes[e] = value_at<D>(u, frame, middle, frame.jacobian(middle), moves[e]);
    }
    std::array<Pack, D + 1> of_vertices{};
    for (int v = 0; v <= D; ++v) {
        PackVec<D> vertex;
        for (int i = 0; i < D; ++i) vertex[i] = packed(v == i + 1 ? 1 : 0);
        of_vertices[v] = u.at(vertex).value;
    }
    for (std::size_t q = 0; q < simplex_rule<D>.size(); ++q) {
        PackVec<D> from, delta{};
        for (int i = 0; i < D; ++i) from[i] = packed(simplex_rule<D>[q].at[i + 1]);
        for (int e = 0; e < edges; ++e)
            for (int i = 0; i < D; ++i) delta[i] += edge_functions<D>[q][e] * moves[e][i];
        const PackJacobian<D> there = frame.jacobian(from);
        const PackSlope<D> at = value_at<D>(u, frame, from, there, delta);
        Pack residual = at.value;
        for (int v = 0; v <= D; ++v) residual -= vertex_functions<D>[q][v] * of_vertices[v];
        for (int e = 0; e < edges; ++e) residual -= edge_functions<D>[q][e] * of_nodes[e].value;
        const Pack share = (weight * simplex_rule<D>[q].weight * simplex) * abs(there.det);
        std::array<Pack, ErrorPacks<D>::unknowns> answer{};
        for (int e = 0; e < edges; ++e)
            for (int i = 0; i < D; ++i)
                answer[e * D + i] = edge_functions<D>[q][e] * (at.gradient[i] - of_nodes[e].gradient[i]);
        sum.error += share * residual * residual;
        int n = 0;
        for (int i = 0; i < ErrorPacks<D>::unknowns; ++i) {
            const Pack shared = share * answer[i];
            sum.slope[i] += shared * residual;
            for (int j = 0; j <= i; ++j, ++n) sum.curvature[n] += shared * answer[j];
        }
    }
}

}  // namespace

template <int D>
void add_error(const ElementPacks<D>& elements, const LatticePacks<D>& field, double weight, Instructions set,
               ErrorPacks<D>& sum) {
    with_instructions(set, [&]() __attribute__((always_inline)) { add_error_packed<D>(elements, field, weight, sum); });
}

template void add_error<2>(const ElementPacks<2>&, const LatticePacks<2>&, double, Instructions, ErrorPacks<2>&);
template void add_error<3>(const ElementPacks<3>&, const LatticePacks<3>&, double, Instructions, ErrorPacks<3>&);

namespace {

template <int D>
using Polynomial = std::array<double, lattice_size<D>>;

template <int D>
std::size_t place_of(const std::array<int, D>& exponent) {
    const auto& all = exponents<D, known_degree>;
    return static_cast<std::size_t>(std::ranges::find(all, exponent) - all.begin());
}

template <int D>
Polynomial<D> times_linear(const Polynomial<D>& p, const std::array<double, D>& slope, double constant) {
    Polynomial<D> product{};
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (p[i] == 0) continue;
        product[i] += constant * p[i];
        for (std::size_t a = 0; a < D; ++a) {
            auto exponent = exponents<D, known_degree>[i];
            ++exponent[a];
            if (slope[a] != 0) product[place_of<D>(exponent)] += slope[a] * p[i];
        }
    }
    return product;
}

/// Returns φ_α = ∏_i ∏_{m < α_i} (n ξ_i − m)/(m + 1) for the degree n, with ξ_i = x_i and ξ_0 = 1 − Σ x_i.
template <int D>
Polynomial<D> lagrange_polynomial(const MultiIndex<D>& alpha) {
    constexpr double n = known_degree;
    Polynomial<D> p{};
    p[0] = 1;
    for (std::size_t i = 0; i <= D; ++i)
        for (int m = 0; m < alpha[i]; ++m) {
            std::array<double, D> slope{};
            if (i == 0)
                slope.fill(-n / (m + 1));
            else
                slope[i - 1] = n / (m + 1);
            p = times_linear<D>(p, slope, ((i == 0 ? n : 0) - m) / (m + 1));
        }
    return p;
}

template <int D>
LatticeBasis<D> make_basis() {
    LatticeBasis<D> basis{};
    for (std::size_t node = 0; node < lattice_size<D>; ++node) {
        const Polynomial<D> p = lagrange_polynomial<D>(multi_indices<known_degree, D>[node]);
        for (std::size_t c = 0; c < p.size(); ++c) basis[c][node] = p[c];
    }
    return basis;
}

}  // namespace

template <int D>
const LatticeBasis<D>& lattice_basis() {
    static const LatticeBasis<D> basis = make_basis<D>();
    return basis;
}

template const LatticeBasis<2>& lattice_basis<2>();
template const LatticeBasis<3>& lattice_basis<3>();

}  // namespace camber
