module;
#include <span>
module camber.recovery:checks;
import camber.core;
import :derivatives;
import :rings;

namespace camber {

/// The degree of the fields by their numbers of values. Errors: usage (numbers that are not of this mesh, or differ),
/// input (a mesh without what fields of degree 2 need).
template <int D>
[[nodiscard]] Outcome<int> degree_of(const QuadraticMesh<D>& mesh, std::span<const Column<double>> fields);

/// Errors: input (a node that is not at a finite place), usage (a value that is not finite), each with the node.
template <int D>
[[nodiscard]] Outcome<Done> check_finite(const NodalMesh<D>& nodal, std::span<const Column<double>> fields,
                                         const Execution& execution);

/// Errors: usage (derivatives beyond the range of numbers), with the vertex.
template <int D>
[[nodiscard]] Outcome<Done> check_results(const RecoveredDerivatives<D>& recovered, const Execution& execution);

}  // namespace camber
