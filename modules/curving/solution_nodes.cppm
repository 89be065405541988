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

/// A scalar field within each element, as a polynomial of this degree in the reference coordinates of the (curved)
/// element: its values at the regular lattice, in the order of `multi_indices`, up to a constant.
inline constexpr int known_degree = 5;
template <int D>
struct KnownField {
    Column<std::array<float, node_count<known_degree, D>>> values;
    double weight = 1;  ///< of its error
    int exponent = 0;   ///< the unit of the values is 2^exponent of the user's
};
template <int D>
using KnownSolution = std::vector<KnownField<D>>;
/// Returns the solution in the elements of a mesh, which its mid nodes curve. It is called for copies of the mesh with
/// other mid nodes.
template <int D>
using SolutionInElements = std::function<Outcome<KnownSolution<D>>(const QuadraticMesh<D>&, const Execution&)>;

struct SolutionNodesOptions {
    int frames = 4;                       ///< largest number of frames
    int rounds = 3;                       ///< largest number of least-squares steps in a frame
    double stiffness = 0.3;               ///< an offset as long as its element adds this share of the squared error
    double max_slide = 0.2;               ///< largest distance of a node from the middle along its chord, in chords
    double min_jacobian = default_bound;  ///< see limit_by_jacobian
};

template <int D>
struct SolutionNodes {
    Column<LagrangeNode<D>> nodes;  ///< one an edge
    /// Expected error with the first start, and with `nodes`: of one field weight · ‖u − u_h‖ in the user's unit; of
    /// several fields the root of Σ (weight ‖u − u_h‖)² in the units of the fields.
    double before = 0, after = 0;
    int frames = 0;              ///< number of frames that reduced the error
    std::size_t drawn_back = 0;  ///< number of edges that were moved by only a part of their step
};

/// Moves the nodes of volume edges so that the sum over fields and elements of ∫ (u − u_h)² is least; u_h is the
/// interpolant of degree 2 on the curved elements. The search begins with the best of `starts` (one node an edge each;
/// boundary nodes stay), and after each turn elements are above `min_jacobian`. Each turn takes the solution in the
/// present elements (the frame) and finds nodes by least squares about it. The polynomials of a frame are inaccurate
/// far from it, so edges are moved by a part of their step where the elements turn out worse. The expected error never
/// rises, and is the error of the interpolant. The result does not depend on the number of threads. Errors: columns
/// that do not fit (internal); those of `solution`; stopped, memory.
template <int D>
[[nodiscard]] Outcome<SolutionNodes<D>> solution_nodes(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                       std::span<const Column<LagrangeNode<D>>> starts,
                                                       const Incidence<ElementId>& shells,
                                                       const SolutionInElements<D>& solution,
                                                       const SolutionNodesOptions& options, const Execution& execution);

/// Returns the expected L2 error of a solution's interpolants of degree 1 or 2 on straight elements. For one field it
/// is weight · ‖u − u_h‖ in the user's unit, for several fields the root of Σ (weight ‖u − u_h‖)² in the units of the
/// fields, as in `SolutionNodes`. The integral goes over a rule of degree 6 in each element. The result does not depend
/// on the number of threads. Errors: values that are not one an element, another degree (internal); stopped.
template <int D>
[[nodiscard]] Outcome<double> expected_error(const LinearMesh<D>& mesh, const KnownSolution<D>& solution, int degree,
                                             const Execution& execution);

}  // namespace camber
