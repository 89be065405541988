module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
module camber.curving:edge_energy;
import camber.core;

/// The energy Σ_K w_K ∫_K |∇u|² dx of displacements of edge nodes, u = Σ_e 4 ξ_i ξ_j u_e: an element's part of its
/// matrix follows from the products of its ∇ξ.
namespace camber {

/// How much an element counts, by |det| of its edges. Bounded, so that the slightest elements do not drown the others.
struct Weighting {
    double mean = 1, stiffening = 0;

    [[nodiscard]] double of(double volume) const { return std::min(pow(mean / volume, stiffening), 1e12); }
};

template <int D>
[[nodiscard]] inline Mat<D> edge_vectors(const LinearMesh<D>& mesh, ElementId e) {
    const auto& v = mesh.elements.vertices[e];
    Mat<D> edges;
    for (int a = 0; a < D; ++a) edges.column[a] = mesh.points[v[a + 1]] - mesh.points[v[0]];
    return edges;
}

template <int D>
[[nodiscard]] inline Outcome<Weighting> weighting_of(const LinearMesh<D>& mesh, double stiffening,
                                                     const Execution& execution) {
    const auto sum = reduce_each(
        execution, mesh.elements.size(), 0.0,
        [&](double& total, std::size_t e) { total += std::abs(det(edge_vectors(mesh, ElementId(e)))); },
        [](double a, double b) { return a + b; });
    if (!sum) return fail(sum.error());
    return Weighting{*sum / static_cast<double>(std::max<std::size_t>(1, mesh.elements.size())), stiffening};
}

/// w |K| ∇ξ_i · ∇ξ_j of an element's edges ij, but for a constant factor. Since Σ ∇ξ_i = 0, the squares are less the
/// sums of these.
template <int D>
using Gradients = std::array<double, edges_per_simplex<D>>;

template <int D>
struct ElementEnergy {
    Gradients<D> gradients{};
    double height = std::numeric_limits<double>::infinity();  ///< the smallest of the straight element
};

/// Flat elements have no say.
template <int D>
[[nodiscard]] inline ElementEnergy<D> element_energy(const LinearMesh<D>& mesh, ElementId e,
                                                     const Weighting& weighting) {
    const Mat<D> edges = edge_vectors(mesh, e);
    const double volume = std::abs(det(edges));
    const auto rows = cofactors(edges);
    // ∇ξ_i times det: its factor 1/det² joins the volume's.
    std::array<Vec<D>, D + 1> gradient{};
    for (int a = 0; a < D; ++a) gradient[a + 1] = rows[a], gradient[0] -= rows[a];
    const double factor = weighting.of(volume) / volume;
    ElementEnergy<D> energy;
    if (!std::isfinite(factor)) return energy;
    double steepest = 0;
    for (const Vec<D>& g : gradient) steepest = std::max(steepest, norm_squared(g));
    energy.height = volume / std::sqrt(steepest);
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        energy.gradients[k] = factor * dot(gradient[local_edges<D>[k][0]], gradient[local_edges<D>[k][1]]);
    return energy;
}

/// Of a local edge ij: the edges ik and jk for each further vertex k, and kl where there are two.
template <int D>
struct EdgesBeside {
    std::array<int, D - 1> first{}, second{};
    int opposite = 0;
};

template <int D>
inline constexpr auto edges_beside = [] {
    const auto between = [](int a, int b) {
        int k = 0;
        while (local_edges<D>[k] != std::array{a, b} && local_edges<D>[k] != std::array{b, a}) ++k;
        return k;
    };
    std::array<EdgesBeside<D>, edges_per_simplex<D>> table{};
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        std::array<int, D - 1> others{};
        for (int k = 0, n = 0; k <= D; ++k)
            if (k != i && k != j) others[n++] = k;
        for (int n = 0; n < D - 1; ++n) {
            table[e].first[n] = between(i, others[n]);
            table[e].second[n] = between(j, others[n]);
        }
        if constexpr (D == 3) table[e].opposite = between(others[0], others[1]);
    }
    return table;
}();

/// What the element adds to an edge's row, add(local edge, entry) each. From ∫ ξ_a ξ_b = (1 + δ_ab) · constant, with
/// g_ii and g_jj put as sums; the edge kl opposite takes the sum of all that are beside.
template <int D, class Add>
inline void each_row_entry(const Gradients<D>& g, int own, const Add& add) {
    const auto& beside = edges_beside<D>[own];
    double firsts = 0;
    double seconds = 0;
    for (int n = 0; n < D - 1; ++n) firsts += g[beside.first[n]], seconds += g[beside.second[n]];
    add(own, -2 * (g[own] + firsts + seconds));
    for (int n = 0; n < D - 1; ++n) {
        const double b = g[beside.first[n]];
        const double d = g[beside.second[n]];
        add(beside.first[n], 2 * d + b - firsts);
        add(beside.second[n], 2 * b + d - seconds);
    }
    if constexpr (D == 3) add(beside.opposite, firsts + seconds);
}

template <int D>
[[nodiscard]] inline int local_edge(const std::array<EdgeId, edges_per_simplex<D>>& edges, EdgeId edge) {
    int own = 0;
    for (int k = 1; k < edges_per_simplex<D>; ++k) own += edges[k] == edge ? k : 0;  // which branch is anybody's guess
    return own;
}

}  // namespace camber
