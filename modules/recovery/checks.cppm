module;
#include <span>
module camber.recovery:checks;
import camber.core;
import :derivatives;
import :rings;

namespace camber {

/// The nodes of fields, and what is around them.
template <int D>
struct CheckedNodes {
    int degree = 1;  ///< of the fields, by their numbers of values
    Incidence<ElementId> balls;

    [[nodiscard]] NodalMesh<D> of(const QuadraticMesh<D>& mesh) const { return {mesh, balls, degree}; }
};

/// Errors: usage (numbers of values that are not of this mesh, or differ; a value that is not finite, with the node),
/// input (a mesh without what fields of degree 2 need, or not of one reference an element; a node that is not at a
/// finite place, with the node).
template <int D>
[[nodiscard]] Outcome<CheckedNodes<D>> checked_nodes(const QuadraticMesh<D>& mesh,
                                                     std::span<const Column<double>> fields,
                                                     const Execution& execution);

/// Errors: usage (derivatives beyond the range of numbers), with the vertex.
template <int D>
[[nodiscard]] Outcome<Done> check_results(const RecoveredDerivatives<D>& recovered, const Execution& execution);

}  // namespace camber
