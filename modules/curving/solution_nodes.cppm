module;
#include <array>
#include <cstddef>
#include <functional>
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
/// all of them.
inline constexpr int known_degree = 5;
template <int D>
struct KnownField {
    Column<std::array<float, node_count<known_degree, D>>> values;
    double weight = 1;  ///< of its error
    int exponent = 0;   ///< the unit of the values is 2^exponent of the user's
};
template <int D>
using KnownSolution = std::vector<KnownField<D>>;
/// What is known in the elements of this mesh, as its mid nodes curve them. A copy of the mesh with other mid nodes is
/// another mesh.
template <int D>
using SolutionInElements = std::function<Outcome<KnownSolution<D>>(const QuadraticMesh<D>&, const Execution&)>;

struct SolutionNodesOptions {
    int frames = 4;          ///< how often the solution is looked at anew in the elements that were found, at most
    int rounds = 3;          ///< how often the error's dependence on the nodes is taken anew in a frame, at most
    double stiffness = 0.3;  ///< an offset as long as its element counts as so many times the element's squared error
    double max_slide = 0.2;  ///< how far along its chord a node may be from the middle, as a share of the chord
    double min_jacobian = default_bound;  ///< see limit_by_jacobian
};

template <int D>
struct SolutionNodes {
    Column<LagrangeNode<D>> nodes;  ///< one an edge
    /// The expected error with the first of the given nodes, and with these: of one field weight · ‖u − u_h‖ in the
    /// user's unit, of several the root of Σ (weight ‖u − u_h‖)² in the units of the fields.
    double before = 0, after = 0;
    int frames = 0;              ///< that were taken
    std::size_t drawn_back = 0;  ///< edges that go a part of their way, for their elements
};

/// From the best of the nodes `starts` (one an edge each; boundary nodes stay) volume edges' nodes are moved so that
/// the sum over fields and elements of ∫ (u − u_h)² is least, u_h the interpolant of degree 2 on the elements that they
/// curve; elements stay above `min_jacobian`. In turns, the solution is taken in the elements as they are (the frame),
/// and nodes are found by least squares about it. Far from its frame a solution is told wrong: edges whose elements
/// turn out worse than before go a part of their way. The expected error never rises, and is the interpolant's. The
/// same bytes for any number of threads. Errors: columns that do not fit (internal); those of `solution`; stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<SolutionNodes<D>> solution_nodes(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                       std::span<const Column<LagrangeNode<D>>> starts,
                                                       const Incidence<ElementId>& shells,
                                                       const SolutionInElements<D>& solution,
                                                       const SolutionNodesOptions& options, const Execution& execution);

}  // namespace camber
