module;
#include <span>
#include <vector>
export module camber.recipes:known_solution;
import camber.core;
import camber.curving;
import camber.recovery;

export namespace camber {

/// A scalar field that is known on a mesh: at its vertices or, then of degree 2, at all of its nodes.
struct WeightedField {
    Column<double> values;
    double weight = 1;  ///< of its error beside those of others, each in a unit in which its range is about 1
};

/// What the objective solution is given: fields, or one function that is known everywhere.
template <int D>
struct GivenSolution {
    std::vector<WeightedField> fields = {};
    FunctionOfPlace<D> function = {};

    [[nodiscard]] bool empty() const { return fields.empty() && !function; }
};

/// What edges' nodes are found by, in the elements of \p curved, which is \p mesh with mid nodes of its own: of fields
/// on \p mesh polynomials, each by nodes of its own material; a function itself. Errors: those of `element_values`;
/// stopped, memory.
template <int D>
[[nodiscard]] Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, const GivenSolution<D>& given,
                                                       const QuadraticMesh<D>& curved, const Execution& execution);

}  // namespace camber
