module;
#include <span>
export module camber.recipes:known_solution;
import camber.core;
import camber.curving;

export namespace camber {

/// A scalar field that is known on a mesh: at its vertices or, then of degree 2, at all of its nodes.
struct WeightedField {
    Column<double> values;
    double weight = 1;  ///< of its error beside those of others, each in a unit in which its range is about 1
};

/// What edges' nodes are found by: derivatives of the fields at the vertices, one-sided where materials meet. Step:
/// recover. Errors: those of `recover_derivatives`; stopped, memory.
template <int D>
[[nodiscard]] Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh,
                                                       std::span<const WeightedField> fields, const Around& around);

}  // namespace camber
