module;
#include <span>
#include <vector>
export module camber.operation:commit;
import camber.core;
import camber.cavity;
import :judged_patch;
import :state;

export namespace camber {

/// A state with patches in place, and which entities that changed.
template <int D>
struct CommittedState {
    Adaptation<D> state;
    TopologyChanges changes;
};

/// The last verb of the operator, and the only way into a state: patches in the place of their cavities (see
/// replace_cavities), and with them all that is known of vertices; walls; points that are short of the geometry. Give
/// the state away (std::move), or all of it is copied; with an error it is lost then. Errors: of replace_cavities.
template <int D>
[[nodiscard]] Outcome<CommittedState<D>> commit(Adaptation<D> state, std::vector<JudgedPatch<D>> patches);

/// Nodes alone: topology stays, and patches that were planned before are not of this state. The edges share no element.
template <int D>
[[nodiscard]] Adaptation<D> commit(Adaptation<D> state, std::span<const JudgedNode<D>> nodes);

}  // namespace camber
