module;
#include <array>
export module camber.core:shape_functions;
import :mesh;

/// The Lagrange functions of degree 2 on a K-simplex, by barycentric coordinates.
export namespace camber {

/// Of a vertex's node: ξ (2ξ − 1).
[[nodiscard]] constexpr double vertex_shape(double xi) { return xi * (2 * xi - 1); }

/// Of the node of local edge e: 4 ξ_i ξ_j. It is also what that node adds, by how far it is from the middle of its
/// chord, to the linear function of the vertices.
template <int K>
[[nodiscard]] constexpr double edge_shape(const std::array<double, K + 1>& xi, int e) {
    const auto [i, j] = local_edges<K>[e];
    return 4 * xi[i] * xi[j];
}

/// Adds ∂/∂ξ_a, a = 0 … K, of edge_shape times a value.
template <int K, class T>
constexpr void add_edge_derivatives(const std::array<double, K + 1>& xi, int e, const T& value,
                                    std::array<T, K + 1>& partial) {
    const auto [i, j] = local_edges<K>[e];
    partial[i] += (4 * xi[j]) * value;
    partial[j] += (4 * xi[i]) * value;
}

}  // namespace camber
