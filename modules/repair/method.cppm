export module camber.repair:method;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import :guide;
import :options;
import :repaired;

export namespace camber {

/// Repairs elements that are not valid, by the method of the options, until all are or the work is spent; what
/// cannot be repaired remains, and the validation says so. Nothing changes when all elements are valid. `guide`: what
/// methods go by. A proposal that was judged for another bound is judged again. The result is the
/// same for any number of threads. Errors: options out of range (usage), columns that do not fit the mesh (internal),
/// stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                          const RepairOptions& options, const Execution& execution);

/// Repairs as `repair` does. Elements that cavities leave are relaxed towards the straight mesh, surface edges last, if
/// that repairs any, then restored towards the input mesh (`restore_input`): an element remains only if it is valid
/// neither straight nor with the input's nodes. For meshes whose boundary nodes may leave the geometry.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                                        const RepairOptions& options, const Execution& execution);

/// The same with the boundary given: its nodes stay while that is enough; then they slide in planes, then they move, by
/// no more than the options' boundary_tolerance; its vertices always stay. A node that would go further is held where
/// it was, and what is left is repaired again without it. Where the bound cannot be had, both take what leaves fewest
/// invalid elements, and never more than the input mesh has.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_within(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                                 const RepairOptions& options, const Execution& execution);

/// Returns what holds each edge: elements, or the triangles of a surface alone. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> holders_of_edges(const QuadraticMesh<D>& mesh, const Execution& execution);

/// The guide of a mesh that was read with its curves and has no field: models in the mesh's implied metric, about where
/// its nodes are, but for the volume nodes of elements that are not valid, whose places say nothing: there, by the
/// displacement around them extended inwards. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<RepairGuide<D>> own_guide(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                                const Execution& execution);

}  // namespace camber
