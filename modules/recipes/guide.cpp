module;
#include <optional>
#include <utility>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.repair;
import camber.surface;
import camber.validity;
import :boundary;
import :guide;

namespace camber {

namespace {

template <int D>
Outcome<RepairGuide<D>> by_models(const JudgedProposal<D>& judged, const std::optional<WantedNodes<D>>& wanted,
                                  RepairMethod method, const Execution& execution) {
    if (!needs_models(method) || judged.validation().all_valid()) return RepairGuide<D>{};
    if (is_surface_alone(judged.mesh().linear)) return RepairGuide<D>{};  // goes by the geometry
    if (wanted) {
        const Column<LagrangeNode<D>> nodes = wanted->curved.proposal.mid_nodes;
        return RepairGuide<D>{wanted->shells, [nodes](EdgeId e) { return nodes[e]; },
                              wanted->field
                                  ? edge_models(wanted->aim, judged.mesh(), nodes, wanted->shells, *wanted->field)
                                  : implied_edge_models(judged.mesh(), nodes, wanted->shells),
                              wanted->extended};
    }
    const auto around = shells(judged.mesh().edges, execution);
    if (!around) return fail(around.error());
    return own_guide(judged, *around, execution);
}

}  // namespace

template <int D>
Outcome<RepairGuide<D>> make_guide(const JudgedProposal<D>& judged, const std::optional<WantedNodes<D>>& wanted,
                                   const Boundary<D>* boundary, RepairMethod method, const Execution& execution) {
    auto guide = by_models(judged, wanted, method, execution);
    if (!guide || boundary == nullptr || judged.validation().all_valid()) return guide;
    const bool is_alone = is_surface_alone(judged.mesh().linear);
    if (!is_alone && !boundary->geometry->prescribes_any()) return guide;
    const auto feet_of = is_alone ? feet_on_any<D> : feet_on<D>;
    auto feet = feet_of(boundary->geometry, boundary->features.edge_kinds, judged.mesh(), without_progress(execution));
    if (!feet) return fail(feet.error());
    guide->onto = std::move(*feet);
    if (is_alone) return guide;
    auto vertices = vertex_feet_on(boundary->geometry, boundary->features, judged.mesh(), without_progress(execution));
    if (!vertices) return fail(vertices.error());
    guide->vertices_onto = std::move(*vertices);
    return guide;
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<RepairGuide<D>> make_guide<D>(const JudgedProposal<D>&, const std::optional<WantedNodes<D>>&, \
                                                   const Boundary<D>*, RepairMethod, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
