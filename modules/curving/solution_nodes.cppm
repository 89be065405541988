module;
#include <array>
#include <cstddef>
#include <span>
#include <vector>
export module camber.curving:solution_nodes;
import camber.bezier;
import camber.core;
import camber.validity;

/// Nodes of volume edges where a known solution is interpolated best. docs/algorithms/solution-nodes.md.
export namespace camber {

/// A scalar field within each element by a polynomial of that degree in the reference coordinates of the element as the
/// mesh has it, curved or not: its values at the regular lattice, in the order of `multi_indices`, whatever is added to
/// all of them. Fields are in one unit.
inline constexpr int known_degree = 5;
template <int D>
struct KnownField {
    Column<std::array<float, node_count<known_degree, D>>> values;
    double weight = 1;  ///< of its error
};
template <int D>
using KnownSolution = std::vector<KnownField<D>>;

struct SolutionNodesOptions {
    int rounds = 4;          ///< how often the error's dependence on the nodes is taken anew, at most
    double stiffness = 0.3;  ///< an offset as long as its element counts as so many times the element's squared error
    double max_slide = 0.2;  ///< how far along its chord a node may be from the middle, as a share of the chord
    double min_jacobian = default_bound;  ///< see limit_by_jacobian
};

template <int D>
struct SolutionNodes {
    Buffer<Vec<D>> moves;  ///< off the given nodes, one an edge
    double before = 0,
           after = 0;  ///< the error that is expected with the given nodes, and with these: (Σ (weight ‖u − u_h‖)²)^½
    int rounds = 0;    ///< that were taken
    std::size_t drawn_back = 0;  ///< edges that go a part of their way, for their elements
};

/// From the nodes `base` (one an edge: those of the boundary stay) volume edges' nodes are moved so that the sum over
/// fields and elements of ∫ (u − u_h)² is least, u_h the interpolant of degree 2 on the elements that they curve, u
/// what is known in the elements of `mesh`; elements stay above `min_jacobian`. The expected error never rises. The
/// same bytes for any number of threads. Errors: columns that do not fit (internal), stopped, memory.
template <int D>
[[nodiscard]] Outcome<SolutionNodes<D>> solution_nodes(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                       std::span<const LagrangeNode<D>> base,
                                                       const Incidence<ElementId>& shells,
                                                       const KnownSolution<D>& solution,
                                                       const SolutionNodesOptions& options, const Execution& execution);

}  // namespace camber
