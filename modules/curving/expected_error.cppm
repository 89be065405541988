export module camber.curving:expected_error;
import camber.core;
import :solution_nodes;

export namespace camber {

/// Returns the expected L2 error of a solution's interpolants of degree 1 or 2 on straight elements. For one field it
/// is weight · ‖u − u_h‖ in the user's unit, for several fields the root of Σ (weight ‖u − u_h‖)² in the units of the
/// fields, as in `SolutionNodes`. The integral goes over a rule of degree 6 in each element. The result does not depend
/// on the number of threads. Errors: values that are not one an element, another degree (internal); stopped.
template <int D>
[[nodiscard]] Outcome<double> expected_error(const LinearMesh<D>& mesh, const KnownSolution<D>& solution, int degree,
                                             const Execution& execution);

}  // namespace camber
