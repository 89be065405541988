module;
#include <array>
#include <cmath>
#include <cstddef>
module camber.transfer:simplex;
import camber.core;
import camber.bezier;

namespace camber {

/// Nodes of a field of degree K in a D-simplex.
template <int D, int K>
inline constexpr int field_nodes = K == 1 ? D + 1 : quadratic_nodes<D>;

/// The Lagrange functions of degree K: of the vertices, then of the edges in the order of `local_edges`.
template <int D, int K>
[[nodiscard]] constexpr std::array<double, field_nodes<D, K>> lagrange(const Barycentric<D>& xi) {
    std::array<double, field_nodes<D, K>> phi{};
    for (int i = 0; i <= D; ++i) phi[i] = K == 1 ? xi[i] : vertex_shape(xi[i]);
    if constexpr (K == 2)
        for (int e = 0; e < edges_per_simplex<D>; ++e) phi[D + 1 + e] = edge_shape<D>(xi, e);
    return phi;
}

/// The nodes of an element: vertices, then V + the edge's number.
template <int D, int K>
[[nodiscard]] std::array<std::size_t, field_nodes<D, K>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    std::array<std::size_t, field_nodes<D, K>> nodes{};
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.linear.elements.vertices[e][i].index();
    if constexpr (K == 2)
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            nodes[D + 1 + k] = mesh.linear.points.size() + mesh.edges.of_elements[e][k].index();
    return nodes;
}

/// Where node n of a mesh is.
template <int D>
[[nodiscard]] const Vec<D>& place_of(const QuadraticMesh<D>& mesh, std::size_t n) {
    const std::size_t vertices = mesh.linear.points.size();
    return n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point;
}

/// F of an element, relative to its vertex 0: only differences of stored numbers occur, so errors are relative to the
/// element and not to its place.
template <int D>
struct ElementMap {
    Vec<D> origin;
    QuadraticSimplex<D, D> relative;
    bool is_straight = true;  ///< all edges' nodes are the middles of their chords, to the bit: F is affine

    [[nodiscard]] Vec<D> at(const Barycentric<D>& xi) const { return origin + relative.point(xi); }
    [[nodiscard]] double determinant(const Barycentric<D>& xi) const { return det(Mat<D>{relative.derivatives(xi)}); }
};

template <int D>
[[nodiscard]] ElementMap<D> element_map(const QuadraticMesh<D>& mesh, std::size_t e) {
    ElementMap<D> map;
    const auto& v = mesh.linear.elements.vertices[e];
    map.origin = mesh.linear.points[v[0]];
    auto& control = map.relative.control;
    for (int i = 0; i <= D; ++i) control[i] = mesh.linear.points[v[i]] - map.origin;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Vec<D>& node = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
        const bool is_middle = node == midpoint(mesh.linear.points[v[i]], mesh.linear.points[v[j]]);
        // A middle is the middle of the differences, too, which its own rounding far from 0 is not.
        control[D + 1 + k] = is_middle
                                 ? midpoint(control[i], control[j])
                                 : control_point(control[i], LagrangeNode<D>{node - map.origin}, control[j]).point;
        map.is_straight = map.is_straight && is_middle;
    }
    return map;
}

}  // namespace camber
