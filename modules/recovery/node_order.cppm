module;
#include <cstdint>
export module camber.recovery:node_order;
import camber.core;

export namespace camber {

/// Relation of the values of a field to the nodes of a mesh.
enum class NodeOrder : std::uint8_t {
    plausible,            ///< nothing speaks against the order, or there are too few different values to tell
    by_first_element,     ///< certain: edges' values fit the order in which elements, one after the other, name their
                          ///< edges
    unrelated_mid_nodes,  ///< certain: vertices' values are related, edges' values are not related to those of their
                          ///< ends
    unrelated,            ///< values at neighbouring nodes are no more alike than those of a random order
};

/// The verdict, and the correlations that it was found by: of neighbouring vertices, and of edges' nodes with the mean
/// of the ends (fields of degree 2).
struct NodeOrderCheck {
    NodeOrder order = NodeOrder::plausible;
    double between_vertices = 1, between_ends_and_middle = 1;
};

/// Compares the order of a field's values with the mesh: at the vertices, or then at the edges' nodes in the order of
/// `mesh.edges`. The values are compressed, asinh((u − median)/(10⁻³ range)), so that neither a few large values nor
/// noise of 10⁻⁶ decides. Method and measured values: docs/algorithms/recovery.md. Errors: numbers of values that are
/// not of this mesh (usage); stopped, memory.
template <int D>
[[nodiscard]] Outcome<NodeOrderCheck> check_node_order(const QuadraticMesh<D>& mesh, const Column<double>& values,
                                                       const Execution& execution);

}  // namespace camber
