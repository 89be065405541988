module;
#include <optional>
export module camber.recipes:guide;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.repair;
import camber.surface;
import camber.validity;
import :boundary;

export namespace camber {

/// Where nodes were wanted, and by what; all is asked while a guide that it makes is used.
template <int D>
struct WantedNodes {
    const Curved<D>& curved;  ///< before any correction
    const Incidence<ElementId>& shells;
    const Column<LagrangeNode<D>>& extended;  ///< see CurveInput
    CurvingAim aim;
    const BackMesh<D>* field;  ///< null: the mesh's own metric
};

/// What repair goes by: what a node off its wanted place costs in the field, feet on surfaces that are prescribed.
/// Without wanted nodes where the mesh itself has them; without a boundary no feet. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<RepairGuide<D>> make_guide(const JudgedProposal<D>& judged,
                                                 const std::optional<WantedNodes<D>>& wanted,
                                                 const Boundary<D>* boundary, RepairMethod method,
                                                 const Execution& execution);

}  // namespace camber
