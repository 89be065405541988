module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.metric:curved_simplex;
import camber.core;
import :element_frame;

namespace camber {

/// A K-simplex of degree 2 in D dimensions, from its vertex 0:
///   F(ξ) − P_0 = Σ_i ξ_i d_i + Σ_e 4 ξ_i ξ_j u_e,  d_i = P_i − P_0,  u_e = how far e's node is off its chord's middle.
/// Only differences of stored numbers occur, so errors are relative to the element and not to its place.
template <int K, int D>
struct CurvedSimplex {
    Vec<D> origin;
    std::array<Vec<D>, K + 1> d{};                 ///< d_0 = 0
    std::array<Vec<D>, edges_per_simplex<K>> u{};  ///< in the order of `local_edges`

    [[nodiscard]] Vec<D> point(const std::array<double, K + 1>& xi) const {
        Vec<D> p;
        for (int i = 1; i <= K; ++i) p += xi[i] * d[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) p += edge_shape<K>(xi, e) * u[e];
        return p;
    }
    /// ∂F/∂ξ_a for a = 1 … K, with ξ_0 = 1 − Σ ξ_a.
    [[nodiscard]] std::array<Vec<D>, K> derivatives(const std::array<double, K + 1>& xi) const {
        std::array<Vec<D>, K + 1> partial = d;
        for (int e = 0; e < edges_per_simplex<K>; ++e) add_edge_derivatives<K>(xi, e, u[e], partial);
        std::array<Vec<D>, K> columns;
        for (int a = 0; a < K; ++a) columns[a] = partial[a + 1] - partial[0];
        return columns;
    }
    /// ∂²F/∂ξ_a ∂ξ_b, a, b = 1 … K, which is constant.
    [[nodiscard]] std::array<std::array<Vec<D>, K>, K> second() const {
        std::array<std::array<Vec<D>, K + 1>, K + 1> h{};
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            h[i][j] = h[j][i] = 4 * u[e];
        }
        std::array<std::array<Vec<D>, K>, K> out;
        for (int a = 0; a < K; ++a)
            for (int b = 0; b < K; ++b) out[a][b] = h[a + 1][b + 1] - h[a + 1][0] - h[0][b + 1];
        return out;
    }
    /// The blossom: F(ξ) − P_0 = blossom(ξ, ξ), linear in each. At the corners of a part of the simplex it has the
    /// part's Bézier points.
    [[nodiscard]] Vec<D> blossom(const std::array<double, K + 1>& a, const std::array<double, K + 1>& b) const {
        Vec<D> p;
        for (int i = 1; i <= K; ++i) p += (0.5 * (a[i] + b[i])) * d[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            p += (2 * (a[i] * b[j] + a[j] * b[i])) * u[e];
        }
        return p;
    }
    /// A box of the Bézier points, and of what rounding may have done to them.
    [[nodiscard]] Box<D> box() const {
        Box<D> box;
        for (int i = 0; i <= K; ++i) box.include(origin + d[i]);
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            box.include(origin + 0.5 * (d[i] + d[j]) + 2 * u[e]);
        }
        for (int c = 0; c < D; ++c) {
            const double blur = 4e-15 * std::max(std::abs(box.low[c]), std::abs(box.high[c]));
            box.low[c] -= blur;
            box.high[c] += blur;
        }
        return box;
    }
};

/// The simplex of these corners and nodes.
template <int K, int D>
[[nodiscard]] CurvedSimplex<K, D> curved_simplex(const std::array<Vec<D>, K + 1>& corners,
                                                 const std::array<Vec<D>, edges_per_simplex<K>>& nodes) {
    CurvedSimplex<K, D> s;
    s.origin = corners[0];
    for (int i = 1; i <= K; ++i) s.d[i] = corners[i] - corners[0];
    for (int e = 0; e < edges_per_simplex<K>; ++e) {
        const auto [i, j] = local_edges<K>[e];
        s.u[e] = (nodes[e] - corners[0]) - 0.5 * (s.d[i] + s.d[j]);
    }
    return s;
}

/// Element e of the mesh.
template <int D>
[[nodiscard]] CurvedSimplex<D, D> curved_element(const QuadraticMesh<D>& mesh, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    std::array<Vec<D>, edges_per_simplex<D>> nodes;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) nodes[k] = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
    return curved_simplex<D, D>(corners, nodes);
}

/// The curved face of an element, with the corners of `face_opposite`.
template <int D>
[[nodiscard]] CurvedSimplex<D - 1, D> curved_face(const QuadraticMesh<D>& mesh, const ElementFace& face) {
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    std::array<Vec<D>, D> corners;
    std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
    for (int i = 0; i < D; ++i) corners[i] = mesh.linear.points[mesh.linear.elements.vertices[face.element][local[i]]];
    for (int k = 0; k < edges_per_simplex<D - 1>; ++k) {
        const auto [i, j] = local_edges<D - 1>[k];
        for (int m = 0; m < edges_per_simplex<D>; ++m) {
            const auto [a, b] = local_edges<D>[m];
            if ((a == local[i] && b == local[j]) || (a == local[j] && b == local[i]))
                nodes[k] = mesh.mid_nodes[mesh.edges.of_elements[face.element][m]].point;
        }
    }
    return curved_simplex<D - 1, D>(corners, nodes);
}

template <int D>
[[nodiscard]] Mat<D> jacobian_at(const CurvedSimplex<D, D>& element, const Barycentrics<D>& xi) {
    return {element.derivatives(xi)};
}

/// ξ with ξ_0 made of the others.
template <int K>
[[nodiscard]] std::array<double, K + 1> moved(const std::array<double, K + 1>& xi, const Vec<K>& step) {
    std::array<double, K + 1> out{};
    double rest = 1;
    for (int i = 1; i <= K; ++i) rest -= out[i] = xi[i] + step[i - 1];
    out[0] = rest;
    return out;
}

}  // namespace camber
