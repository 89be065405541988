module;
#include <array>
#include <cstddef>
#include <span>
#include <utility>
/// Bernstein algebra in any degree and dimension, P2 edges and simplices, and `elevate`.
export module camber.bezier:bernstein;
import camber.core;

export namespace camber {

/// K + 1 non-negative integers; their sum is the degree (paper §1.4).
template <int K>
using MultiIndex = std::array<int, K + 1>;

template <int K>
using Barycentric = std::array<double, K + 1>;

/// Returns n over k, and 0 outside 0 ≤ k ≤ n.
[[nodiscard]] constexpr int binomial(int n, int k) {
    int b = 1;
    for (int i = 1; i <= k; ++i) b = b * (n - k + i) / i;
    return b;
}

/// Number of multi-indices of degree N: |I_N^K| = (N + K choose K).
template <int N, int K>
inline constexpr int node_count = binomial(N + K, K);

/// Multi-indices of degree N (I_N^K) in reverse lexicographic order: (N,0,…) first, (…,0,N) last.
template <int N, int K>
inline constexpr std::array<MultiIndex<K>, node_count<N, K>> multi_indices = [] {
    std::array<MultiIndex<K>, node_count<N, K>> all{};
    MultiIndex<K> alpha{};
    alpha[0] = N;
    for (auto& slot : all) {
        slot = alpha;
        // Takes one from the last non-zero entry before the end, and adds it and the last entry to the next entry.
        int i = K - 1;
        while (i >= 0 && alpha[i] == 0) --i;
        if (i < 0) break;
        const int tail = alpha[K];
        alpha[K] = 0;
        --alpha[i];
        alpha[i + 1] = tail + 1;
    }
    return all;
}();

/// Returns the position of α in multi_indices<N, K>, or −1 if absent.
template <int N, int K>
[[nodiscard]] constexpr int position(const MultiIndex<K>& alpha) {
    for (int i = 0; i < node_count<N, K>; ++i)
        if (multi_indices<N, K>[i] == alpha) return i;
    return -1;
}

/// Returns n! / ∏ α_i! with n = Σ α_i.
template <int K>
[[nodiscard]] constexpr double multinomial(const MultiIndex<K>& alpha) {
    int sum = 0;
    double m = 1;
    for (const int a : alpha) {
        sum += a;
        m *= binomial(sum, a);
    }
    return m;
}

/// Returns x^n for n ≥ 0.
[[nodiscard]] constexpr double power(double x, int n) {
    double p = 1;
    for (int i = 0; i < n; ++i) p *= x;
    return p;
}

/// Returns the Bernstein polynomial B_α^n(ξ) = n!/∏α_i! ∏ξ_i^{α_i} (paper §1.4).
template <int K>
[[nodiscard]] constexpr double bernstein(const MultiIndex<K>& alpha, const Barycentric<K>& xi) {
    double b = multinomial<K>(alpha);
    for (int i = 0; i <= K; ++i) b *= power(xi[i], alpha[i]);
    return b;
}

/// Returns the Lagrange function of lattice point α/n: φ_α^n(ξ) = ∏_i ∏_{m < α_i} (n ξ_i − m)/(m + 1).
template <int K>
[[nodiscard]] constexpr double lagrange(const MultiIndex<K>& alpha, const Barycentric<K>& xi) {
    int n = 0;
    for (const int a : alpha) n += a;
    double value = 1;
    for (int i = 0; i <= K; ++i)
        for (int m = 0; m < alpha[i]; ++m) value *= (n * xi[i] - m) / (m + 1);
    return value;
}

template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

/// Matrix from Bézier to Lagrange coefficients: row β contains B_α^N(β/N).
template <int N, int K>
inline constexpr auto bezier_to_lagrange = [] {
    SquareMatrix<node_count<N, K>> m{};
    for (int r = 0; r < node_count<N, K>; ++r) {
        Barycentric<K> xi{};
        for (int i = 0; i <= K; ++i) xi[i] = static_cast<double>(multi_indices<N, K>[r][i]) / N;
        for (int c = 0; c < node_count<N, K>; ++c) m[r][c] = bernstein<K>(multi_indices<N, K>[c], xi);
    }
    return m;
}();

/// `is_regular` is false if a pivot is at most 2^-300 in size; then the entries are meaningless.
template <std::size_t N>
struct Inverse {
    SquareMatrix<N> matrix{};
    bool is_regular = true;
};

/// Gauss–Jordan elimination with partial pivoting.
template <std::size_t N>
[[nodiscard]] constexpr Inverse<N> inverted(SquareMatrix<N> a) {
    Inverse<N> inverse;
    SquareMatrix<N>& b = inverse.matrix;
    for (std::size_t i = 0; i < N; ++i) b[i][i] = 1;
    const auto magnitude = [](double x) { return x < 0 ? -x : x; };
    for (std::size_t p = 0; p < N; ++p) {
        std::size_t pivot = p;
        for (std::size_t r = p + 1; r < N; ++r)
            if (magnitude(a[r][p]) > magnitude(a[pivot][p])) pivot = r;
        std::swap(a[p], a[pivot]);
        std::swap(b[p], b[pivot]);
        inverse.is_regular = inverse.is_regular && magnitude(a[p][p]) > 0x1p-300;
        const double scale = 1 / a[p][p];
        for (std::size_t c = 0; c < N; ++c) {
            a[p][c] *= scale;
            b[p][c] *= scale;
        }
        for (std::size_t r = 0; r < N; ++r) {
            const double factor = a[r][p];
            if (r == p || factor == 0) continue;
            for (std::size_t c = 0; c < N; ++c) {
                a[r][c] -= factor * a[p][c];
                b[r][c] -= factor * b[p][c];
            }
        }
    }
    return inverse;
}

/// Matrix from Lagrange to Bézier coefficients (paper §1.4), for values and for log-metrics.
template <int N, int K>
inline const SquareMatrix<node_count<N, K>> lagrange_to_bezier = inverted(bezier_to_lagrange<N, K>).matrix;

template <std::size_t N, class T>
[[nodiscard]] constexpr std::array<T, N> transformed(const std::array<std::array<double, N>, N>& matrix,
                                                     const std::array<T, N>& values) {
    std::array<T, N> out{};
    for (std::size_t r = 0; r < N; ++r)
        for (std::size_t c = 0; c < N; ++c) out[r] = out[r] + values[c] * matrix[r][c];
    return out;
}

/// Bézier control point of a P2 edge: the intersection of its end tangents, not a point of the curve.
template <int D>
struct ControlPoint {
    Vec<D> point;
    friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

/// Returns P_11 = (4 P^l − P_20 − P_02)/2 (paper §2.1), where P^l is the node `mid`.
template <int D>
[[nodiscard]] constexpr ControlPoint<D> control_point(const Vec<D>& p20, const LagrangeNode<D>& mid,
                                                      const Vec<D>& p02) {
    return {2.0 * mid.point - midpoint(p20, p02)};
}

/// Returns P^l = (P_20 + 2 P_11 + P_02)/4.
template <int D>
[[nodiscard]] constexpr LagrangeNode<D> lagrange_node(const Vec<D>& p20, const ControlPoint<D>& p11,
                                                      const Vec<D>& p02) {
    return {0.5 * (midpoint(p20, p02) + p11.point)};
}

template <int D>
struct QuadraticEdge {
    Vec<D> p20;
    LagrangeNode<D> mid;
    Vec<D> p02;

    [[nodiscard]] static constexpr QuadraticEdge straight(const Vec<D>& a, const Vec<D>& b) {
        return {a, {midpoint(a, b)}, b};
    }

    /// l(t) = (1−t)(1−2t) P_20 + 4t(1−t) P^l + t(2t−1) P_02, computed from the straight edge and the node's offset, so
    /// that a straight edge stays straight within rounding.
    [[nodiscard]] constexpr Vec<D> point(double t) const {
        return (1 - t) * p20 + t * p02 + 4 * t * (1 - t) * offset();
    }
    /// l'(t) = (4t−3) P_20 + 4(1−2t) P^l + (4t−1) P_02.
    [[nodiscard]] constexpr Vec<D> derivative(double t) const { return (p02 - p20) + 4 * (1 - 2 * t) * offset(); }

    [[nodiscard]] constexpr Vec<D> chord() const { return p02 - p20; }
    [[nodiscard]] constexpr Vec<D> offset() const { return mid.point - midpoint(p20, p02); }
};

/// Returns |P^l − M_11| / |P_20 − P_02| with the node P^l and the chord midpoint M_11 (paper §4).
template <int D>
[[nodiscard]] inline double curvature(const QuadraticEdge<D>& edge) {
    return norm(edge.offset()) / norm(edge.chord());
}

template <int D>
[[nodiscard]] constexpr QuadraticEdge<D> edge_of(const QuadraticMesh<D>& mesh, EdgeId e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return {mesh.linear.points[a], mesh.mid_nodes[e], mesh.linear.points[b]};
}

/// Number of nodes of a quadratic K-simplex: 3, 6 or 10.
template <int K>
inline constexpr int quadratic_nodes = (K + 1) * (K + 2) / 2;

/// A P2 K-simplex in D dimensions, stored as its Bézier points: K + 1 vertices, then the control points of the edges in
/// the order of `local_edges`.
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

    /// ∂_a F − ∂_0 F for a = 1 … K: columns of the Jacobian with respect to ξ_1 … ξ_K.
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

    /// Returns the Bézier point between local vertices i and j, or the vertex if i = j.
    [[nodiscard]] constexpr const Vec<D>& at(int i, int j) const {
        if (i == j) return control[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [a, b] = local_edges<K>[e];
            if ((a == i && b == j) || (a == j && b == i)) return control[K + 1 + e];
        }
        return control[0];  // unreachable for local vertices
    }
};

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

template <int D>
[[nodiscard]] inline QuadraticSimplex<D, D> element_of(const QuadraticMesh<D>& mesh, ElementId e) {
    return bezier_form<D, D>(mesh.linear.points, mesh.mid_nodes.view(), mesh.linear.elements.vertices[e],
                             mesh.edges.of_elements[e]);
}

template <int D>
[[nodiscard]] inline QuadraticSimplex<D - 1, D> facet_of(const QuadraticMesh<D>& mesh, FacetId f) {
    return bezier_form<D - 1, D>(mesh.linear.points, mesh.mid_nodes.view(), mesh.linear.facets.vertices[f],
                                 mesh.edges.of_facets[f]);
}

/// Converts a mesh to degree 2 with each node at the chord midpoint. Exact: no point of any element moves. Errors:
/// those of `unique_edges`, stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> elevate(LinearMesh<D> mesh, const Execution& execution) {
    auto edges = unique_edges(mesh, part_of(execution, 0, 0.82));
    if (!edges) return fail(edges.error());
    auto mid_nodes = map_each(part_of(execution, 0.82, 1), edges->size(), [&](std::size_t e) {
        const auto& [a, b] = edges->vertices[e];
        return LagrangeNode<D>{midpoint(mesh.points[a], mesh.points[b])};
    });
    if (!mid_nodes) return fail(mid_nodes.error());
    return QuadraticMesh<D>{std::move(mesh), std::move(*edges), std::move(*mid_nodes)};
}

}  // namespace camber
