module camber.repair:by_optimisation;
import camber.core;
import camber.validity;
import camber.optimisation;
import :guide;
import :options;
import :repaired;

namespace camber {

/// The methods `extension`, `cavity` and `edge`. Repairs what is not valid in a mesh with the places of `wanted`. By
/// `extension` nodes first go home, to the boundary's displacement extended, by as few steps as their elements need.
/// What is left, and by `cavity` all, is repaired at the least cost by the models: for each such element a cavity, its
/// volume nodes, which move together (joint_programme) while its surroundings and the boundary stay; then one volume
/// node; then the nodes around it extend the boundary's displacement; then larger cavities, and the vertices of the
/// volume; last, surface nodes, which are counted. Then nodes return as near to their places as they may, one at a time
/// and together. No element that is valid ever stops being so. Cavities that do not overlap are planned in parallel;
/// the result is the same for any number of threads. Where a vertex moves, det J is to be above bound · |det of the
/// mesh's straight element| too, and the mean ratio at least min(before, 0.05), or the vertex stays. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_by_optimisation(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                                          const RepairOptions& options, const Execution& execution);

}  // namespace camber
