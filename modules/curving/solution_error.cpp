module;
#include <array>
#include <cmath>
#include <cstddef>
module camber.curving;
import camber.core;
import :lattice_polynomial;
import :pack_frame;
import :simplex_rule;
import :solution_error;
import :solution_nodes;

namespace camber {

namespace {

/// 4 λ_i λ_j of the edges, and λ_i (2 λ_i − 1) of the vertices, at the points of the rule.
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

/// The function at a place of the frame that is displaced by δ, and its gradient in space: J⁻ᵀ ∇.
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

}  // namespace camber
