module;
#include <string>
#include <vector>
export module camber.run:solution_source;
import camber.core;
import camber.io;
import camber.recipes;
import :solution;

/// The solution of a run, for stages that place nodes by it.
export namespace camber::run {

/// An expression's values at the nodes of a mesh; a straight one has them in the middles of its edges. Errors (usage):
/// one that cannot be read, or has no number at a node; stopped, memory.
[[nodiscard]] Outcome<NamedField> field_of_expression(const AnyMesh& mesh, const std::string& expression,
                                                      const Execution& execution);

}  // namespace camber::run

namespace camber::run {

/// Fields on the mesh that was read, or an expression.
struct SolutionSource {
    AnyMesh mesh;
    std::vector<NamedField> fields;
    std::string expression;       ///< empty: none
    std::vector<double> weights;  ///< a field each; none: 1 of all
};

/// Each component of each field at the nodes of a mesh that came of that one: those that stayed keep their values; or
/// the expression itself. Step: transfer. Errors: those of `fields_brought_to`; an expression that cannot be read;
/// as many weights as fields (usage).
template <int D>
[[nodiscard]] Outcome<GivenSolution<D>> solution_on(const SolutionSource& source, const QuadraticMesh<D>& mesh,
                                                    const Around& around);

}  // namespace camber::run
