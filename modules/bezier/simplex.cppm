module;
#include <array>
#include <cstddef>
#include <span>
export module camber.bezier:simplex;
import camber.core;
import :bernstein;
import :edge;

export namespace camber {

/// Nodes of a P2 K-simplex: 3, 6, 10.
template <int K>
inline constexpr int quadratic_nodes = (K + 1) * (K + 2) / 2;

/// A P2 K-simplex in D dimensions by its Bézier points: the K + 1 vertices, then the edges' control points in the
/// order of `local_edges`.
template <int K, int D>
struct QuadraticSimplex {
    std::array<Vec<D>, quadratic_nodes<K>> control{};

    /// F(ξ) = Σ B_α(ξ) P_α.
    [[nodiscard]] constexpr Vec<D> point(const Barycentric<K>& xi) const {
        Vec<D> p;
        for (int i = 0; i <= K; ++i) p += xi[i] * xi[i] * control[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            p += 2 * xi[i] * xi[j] * control[K + 1 + e];
        }
        return p;
    }

    /// ∂_a F − ∂_0 F for a = 1 … K: the columns of the Jacobian with respect to ξ_1 … ξ_K.
    [[nodiscard]] constexpr std::array<Vec<D>, K> derivatives(const Barycentric<K>& xi) const {
        std::array<Vec<D>, K + 1> partial{};
        for (int i = 0; i <= K; ++i) partial[i] = 2 * xi[i] * control[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            partial[i] += 2 * xi[j] * control[K + 1 + e];
            partial[j] += 2 * xi[i] * control[K + 1 + e];
        }
        std::array<Vec<D>, K> columns{};
        for (int a = 0; a < K; ++a) columns[a] = partial[a + 1] - partial[0];
        return columns;
    }

    /// The Bézier point of the local edge between local vertices i and j; the vertex itself when i = j.
    [[nodiscard]] constexpr const Vec<D>& at(int i, int j) const {
        if (i == j) return control[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [a, b] = local_edges<K>[e];
            if ((a == i && b == j) || (a == j && b == i)) return control[K + 1 + e];
        }
        return control[0];  // unreachable for local vertices
    }
};

/// The Bézier form of a simplex of a mesh, from the mesh's Lagrange nodes.
template <int K, int D>
[[nodiscard]] inline QuadraticSimplex<K, D> bezier_form(const Column<Vec<D>>& points,
                                                        std::span<const LagrangeNode<D>> mid_nodes,
                                                        const SimplexVertices<K>& vertices,
                                                        const std::array<EdgeId, edges_per_simplex<K>>& edges) {
    QuadraticSimplex<K, D> s;
    for (int i = 0; i <= K; ++i) s.control[i] = points[vertices[i]];
    for (int e = 0; e < edges_per_simplex<K>; ++e) {
        const auto [i, j] = local_edges<K>[e];
        s.control[K + 1 + e] = control_point(s.control[i], mid_nodes[edges[e].index()], s.control[j]).point;
    }
    return s;
}

/// Element e of the mesh in Bézier form.
template <int D>
[[nodiscard]] inline QuadraticSimplex<D, D> element_of(const QuadraticMesh<D>& mesh, ElementId e) {
    return bezier_form<D, D>(mesh.linear.points, mesh.mid_nodes.view(), mesh.linear.elements.vertices[e],
                             mesh.edges.of_elements[e]);
}

/// Facet f of the mesh in Bézier form.
template <int D>
[[nodiscard]] inline QuadraticSimplex<D - 1, D> facet_of(const QuadraticMesh<D>& mesh, FacetId f) {
    return bezier_form<D - 1, D>(mesh.linear.points, mesh.mid_nodes.view(), mesh.linear.facets.vertices[f],
                                 mesh.edges.of_facets[f]);
}

}  // namespace camber
