module;
#include <cstddef>
#include <vector>
export module camber.run:mend;
import camber.core;
import camber.cavity;
import camber.config;
import camber.validity;
import camber.programmes;
import camber.curving;
import camber.repair;
import :report;

namespace camber::run {

/// A proposal after a correction, and what it changed.
template <int D>
struct Mended {
    JudgedProposal<D> judged;
    std::size_t corrected_elements = 0, moved_volume_nodes = 0, moved_surface_nodes = 0, moved_vertices = 0;
    double work = 0;                  ///< as `RepairOptions::effort` counts it
    std::vector<ElementId> given_up;  ///< not valid when the work that may be spent was spent
};

/// Whether that repair weighs places by models, one an edge; the others take none.
[[nodiscard]] constexpr bool needs_models(config::Repair repair) {
    return repair == config::Repair::cavity || repair == config::Repair::edge;
}

/// The options of `camber.validity`'s relaxation, with the strategy that the repair stands for.
[[nodiscard]] RelaxOptions relax_options(const config::Relax& options);

/// What is not valid mended, by the repair that the options name and for no more than that work. Errors: those of the
/// repair.
template <int D>
[[nodiscard]] Outcome<Mended<D>> mend(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                      const config::Relax& options, double most_work, const Execution& execution);

/// The same as `mend`; what cavities leave is relaxed towards the straight mesh, surface edges last, if that mends any:
/// an element then remains only if its straight one is not valid.
template <int D>
[[nodiscard]] Outcome<Mended<D>> mend_or_straighten(const JudgedProposal<D>& wanted,
                                                    const Column<QuadraticModel<D>>& models,
                                                    const config::Relax& options, const Execution& execution);

/// Volume nodes around elements that are not valid, and nodes of the boundary's plane pieces within their planes by at
/// most the tolerance, go where a linear extension of all other boundary nodes' displacements has them, as far out as
/// that breaks elements. The boundary's shape stays. The proposal need not be better. Errors: stopped.
[[nodiscard]] Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance,
                                                  const Execution& execution);

/// The same as `mend` with the boundary given: its nodes stay while that is enough; then they slide in planes, then
/// they move, by no more than the options' boundary_tolerance; its vertices always stay. A node that would go further
/// is held where it was, and what is left is mended again without it. Where the bound cannot be had, no more elements
/// are left invalid than with the default bound.
template <int D>
[[nodiscard]] Outcome<Mended<D>> mend_within(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                             const config::Relax& options, const Execution& execution);

/// Where the nodes of a mesh that was read are wanted: where they are, but for the volume nodes of elements that are
/// not valid, whose places say nothing: there, by the boundary's displacement carried inwards (`extend_boundary`).
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> own_wishes(const JudgedProposal<D>& judged,
                                                          const Incidence<ElementId>& shells,
                                                          const Execution& execution);

/// How far the proposal's boundary nodes are from the mesh's.
template <int D>
[[nodiscard]] KeptBoundaryReport kept_boundary(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                               double tolerance);

/// The elements that are not certified valid, in the mesh's order, and why, as far as that can be told: a straight
/// element without volume; a determinant at a vertex that boundary nodes alone decide (there the columns are
/// 4 P_ij − 3 P_i − P_j); required edges and vertices; a facet of the boundary that is folded, seen from its straight
/// form; nodes that are all on the boundary; else nothing that forbids it is known.
template <int D>
[[nodiscard]] std::vector<RemainingReport> remaining(const Mended<D>& mended);

/// Those of them that hold something required, or on which the work was spent, with that reason: the others had all the
/// freedom there is.
template <int D>
[[nodiscard]] std::vector<RemainingReport> remaining_but_for_shape(const Mended<D>& mended);

}  // namespace camber::run
