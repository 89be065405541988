module;
#include <array>
#include <cmath>
#include <cstddef>
module camber.curving;
import camber.core;
import :lattice_polynomial;
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

/// Straight elements as maps from the reference simplex.
template <int D>
struct Straight {
    std::array<PackVec<D>, D> axes;     ///< columns of J
    std::array<PackVec<D>, D> inverse;  ///< rows of J⁻¹
    Pack volume;                        ///< 0 of those that are flat

    [[gnu::always_inline]] explicit Straight(const std::array<PackVec<D>, D>& columns) : axes(columns) {
        Pack det;
        if constexpr (D == 2) {
            det = axes[0][0] * axes[1][1] - axes[0][1] * axes[1][0];
            inverse = {PackVec<2>{axes[1][1], -axes[1][0]}, PackVec<2>{-axes[0][1], axes[0][0]}};
        } else {
            inverse = {cross(axes[1], axes[2]), cross(axes[2], axes[0]), cross(axes[0], axes[1])};
            det = axes[0][0] * inverse[0][0] + axes[0][1] * inverse[0][1] + axes[0][2] * inverse[0][2];
        }
        const Pack over = select(det == 0, packed(0), 1 / select(det == 0, packed(1), det));
        for (auto& row : inverse)
            for (Pack& x : row) x = x * over;
        volume = abs(det) * (D == 2 ? 1.0 / 2 : 1.0 / 6);
    }
    [[gnu::always_inline]] static PackVec<3> cross(const PackVec<3>& a, const PackVec<3>& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
    /// J⁻¹ v, and J⁻ᵀ g.
    [[nodiscard, gnu::always_inline]] PackVec<D> pulled_back(const PackVec<D>& v) const {
        PackVec<D> out;
        for (int a = 0; a < D; ++a) {
            out[a] = inverse[a][0] * v[0];
            for (int i = 1; i < D; ++i) out[a] += inverse[a][i] * v[i];
        }
        return out;
    }
    [[nodiscard, gnu::always_inline]] PackVec<D> in_space(const PackVec<D>& g) const {
        PackVec<D> out;
        for (int i = 0; i < D; ++i) {
            out[i] = inverse[0][i] * g[0];
            for (int a = 1; a < D; ++a) out[i] += inverse[a][i] * g[a];
        }
        return out;
    }
};

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
[[gnu::always_inline]] inline void add_error_packed(const ElementPacks<D>& elements, const LatticePacks<D>& field,
                                                    double weight, ErrorPacks<D>& sum) {
    constexpr int edges = edges_per_simplex<D>;
    const Straight<D> straight(elements.axes);
    const auto u = polynomial_of<D>(field);
    std::array<PackVec<D>, edges> offsets{};
    std::array<PackSlope<D>, edges> of_nodes{};
    for (int e = 0; e < edges; ++e) {
        offsets[e] = straight.pulled_back(elements.offsets[e]);
        PackVec<D> node = offsets[e];
        for (const int v : local_edges<D>[e])
            if (v > 0) node[v - 1] += 0.5;
        of_nodes[e] = u.at(node);
        of_nodes[e].gradient = straight.in_space(of_nodes[e].gradient);
    }
    std::array<Pack, D + 1> of_vertices{};
    for (int v = 0; v <= D; ++v) {
        PackVec<D> vertex;
        for (int i = 0; i < D; ++i) vertex[i] = packed(v == i + 1 ? 1 : 0);
        of_vertices[v] = u.at(vertex).value;
    }
    for (std::size_t q = 0; q < simplex_rule<D>.size(); ++q) {
        PackVec<D> x;
        for (int i = 0; i < D; ++i) x[i] = packed(simplex_rule<D>[q].at[i + 1]);
        for (int e = 0; e < edges; ++e)
            for (int i = 0; i < D; ++i) x[i] += edge_functions<D>[q][e] * offsets[e][i];
        PackSlope<D> at = u.at(x);
        at.gradient = straight.in_space(at.gradient);
        Pack residual = at.value;
        for (int v = 0; v <= D; ++v) residual -= vertex_functions<D>[q][v] * of_vertices[v];
        for (int e = 0; e < edges; ++e) residual -= edge_functions<D>[q][e] * of_nodes[e].value;
        const Pack share = (weight * simplex_rule<D>[q].weight) * straight.volume;
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
