module;
#include <optional>
#include <span>
module camber.run:numbering;
import camber.core;
import camber.config;
import camber.ordering;
import :pipeline;
import :stages;
import :state;

/// Where a mesh is in an order that makes stages slow they work on it in another, and nobody sees it: all that goes in
/// is renumbered at one place, before the first stage, and all that comes out at one, after the last.
namespace camber::run {

/// The order to work in; nothing where the mesh's own will do, or where stages change the straight mesh: what they make
/// has an order of its own. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::optional<BetterOrder>> working_order(const StageInputs<D>& inputs,
                                                                std::span<const config::Stage> stages,
                                                                const OrderingOptions& options,
                                                                const Execution& execution);

/// What stages take, by the numbers to work by. Metric files whose rows are not the mesh's vertices stay: they are
/// refused later. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<StageInputs<D>> in_working_order(StageInputs<D> inputs, const Renumbering& order,
                                                       const Execution& execution);

/// What stages made, by the user's numbers: mesh, fields, metric, and the elements that the report names. Errors:
/// memory, stopped.
template <int D>
[[nodiscard]] Outcome<Run> in_given_order(Run run, const Renumbering& order, const Execution& execution);

/// Why they made nothing: the entity that the error names.
template <int D>
[[nodiscard]] Error in_given_order(Error error, const Renumbering& order);

}  // namespace camber::run
