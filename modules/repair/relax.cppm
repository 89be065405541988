export module camber.repair:relax;
import camber.core;
import camber.validity;
import :options;
import :repaired;

export namespace camber {

/// The fourth verb: moves nodes of elements that are not valid (and of those that break by it) towards the middle of
/// their chords, volume edges first, surface and ridge edges last, until every element is valid. By theta if that is
/// the method of the options, else by segments. Succeeds whenever the straight mesh is valid to the bound; what cannot
/// be repaired remains, and the validation says so. Nothing changes when all elements are valid. A proposal that was
/// judged for another bound is judged again. Errors: options out of range (usage), columns that do not fit the mesh
/// (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> relax(const JudgedProposal<D>& wanted, const RepairOptions& options,
                                         const Execution& execution);

}  // namespace camber
