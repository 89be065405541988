export module camber.repair:relax;
import camber.core;
import camber.validity;
import :options;
import :repaired;

export namespace camber {

/// The fourth verb: moves nodes of elements that are not valid (and of those that break by it) towards the middle of
/// their chords, volume edges first, surface and ridge edges last, until every element is valid. By theta if that is
/// the method of the options, else by segments. Elements that this leaves go back towards the input mesh
/// (`restore_input`). Succeeds whenever the straight mesh, or the input mesh, is valid to the bound; what cannot be
/// repaired remains, and the validation says so. Nothing changes when all elements are valid. A proposal that was
/// judged for another bound is judged again. Errors: options out of range (usage), columns that do not fit the mesh
/// (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> relax(const JudgedProposal<D>& wanted, const RepairOptions& options,
                                         const Execution& execution);

/// Repairs elements that a repair left below the bound by moving their nodes back towards where the input mesh has
/// them, in few steps, the last one exactly there: volume nodes first, then boundary nodes, then vertices; elements
/// that become invalid by it are next. Then these nodes return towards `wanted` as far as the elements around them
/// allow. The result has no more elements below the bound than the input mesh or `repaired`, whichever has fewer. Does
/// nothing if the input mesh is straight, or is valid nowhere `repaired` is not. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> restore_input(const JudgedProposal<D>& wanted, Repaired<D> repaired,
                                                 const RepairOptions& options, const Execution& execution);

}  // namespace camber
