module;
#include <cstddef>
#include <optional>
#include <span>
#include <vector>
export module camber.optimisation:edge_shell;
import camber.core;
import camber.bezier;
import camber.validity;

export namespace camber {

/// An element around an edge.
template <int D>
struct ShellElement {
    NodalSimplex<D> element;
    int edge = 0;  ///< which of its local edges is the shell's
    /// Scaled Jacobian that this element must keep; none: a programme's own demand holds for it.
    std::optional<double> keep;
};

/// The elements around one edge, whose node they share.
template <int D>
struct EdgeShell {
    LagrangeNode<D> node;  ///< the edge's, as the elements have it
    std::vector<ShellElement<D>> elements;
};

/// The shell of an edge of a mesh, with these mid nodes.
template <int D>
[[nodiscard]] inline EdgeShell<D> edge_shell(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                             std::span<const ElementId> shell, EdgeId edge) {
    EdgeShell<D> s{mid_nodes[edge.index()], {}};
    s.elements.reserve(shell.size());
    for (const ElementId e : shell) {
        const auto& edges = mesh.edges.of_elements[e];
        int local = 0;
        while (local + 1 < edges_per_simplex<D> && edges[local] != edge) ++local;
        s.elements.push_back({nodal_element<D>(mesh, mid_nodes, e), local, {}});
    }
    return s;
}

/// The element with the edge's node elsewhere.
template <int D>
[[nodiscard]] inline NodalSimplex<D> with_node(const ShellElement<D>& s, const LagrangeNode<D>& node) {
    NodalSimplex<D> moved = s.element;
    moved.nodes[D + 1 + s.edge] = node.point;
    return moved;
}

}  // namespace camber
