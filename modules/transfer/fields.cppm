module;
#include <cstddef>
export module camber.transfer:fields;
import camber.core;

export namespace camber {

/// A continuous field on a mesh of degree 2, by its values at the nodes: u∘F_K = Σ φ_α(ξ) u_α in the curved element K.
struct TransferField {
    int components = 1;  ///< of a node: 1 of a scalar, D of a vector; each is a function by itself
    /// 1: a node a vertex, the field linear in ξ; 2: the nodes are the vertices, then the edges' nodes in the order of
    /// the mesh's EdgeSet.
    int degree = 2;
    Column<double> values;  ///< components of a node side by side, node after node

    friend bool operator==(const TransferField&, const TransferField&) = default;
};

/// How many nodes a field of that degree has on a mesh.
template <int D>
[[nodiscard]] std::size_t node_count_of(const QuadraticMesh<D>& mesh, int degree) {
    return mesh.linear.points.size() + (degree == 2 ? mesh.edges.size() : 0);
}

}  // namespace camber
