module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :growth;
import :moved_mesh;
import :state;
import :vertex_moves;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// Inwards again: around elements that would be spoilt nodes stay.
template <int D>
void shrink(const RepairState<D>& state, Growth<D>& growth) {
    std::vector<ElementId> suspects = growth.around(growth.edges);
    while (!suspects.empty()) {
        std::vector<EdgeId> removed;
        for (const ElementId e : suspects) {
            if (!spoilt(state, e, growth.element(e), verdict_of(state, e, growth.element(e)))) continue;
            for (const EdgeId edge : state.mesh().edges.of_elements[e]) {
                if (!growth.is_chosen(edge)) continue;
                growth.chosen.at(edge) = 0;
                removed.push_back(edge);
            }
        }
        suspects = growth.around(removed);
    }
    std::erase_if(growth.edges, [&](EdgeId e) { return !growth.is_chosen(e); });
}

template <int D>
Moves<D> plan_of(const RepairState<D>& state, Growth<D>& growth) {
    Moves<D> plan;
    for (const ElementId e : growth.around(growth.edges))
        plan.verdicts.emplace_back(e, verdict_of(state, e, growth.element(e)));
    growth.edges |= ranges::actions::sort;
    plan.nodes.reserve(growth.edges.size());
    for (const EdgeId edge : growth.edges) plan.nodes.emplace_back(edge, growth.there[edge]);
    return plan;
}

}  // namespace

template <int D>
Moves<D> plan_extension(const RepairState<D>& state, const std::vector<ElementId>& seeds,
                        const Column<LagrangeNode<D>>& extended, double bound) {
    const Overlay<EdgeId, LagrangeNode<D>> there(extended);
    Growth<D> growth{state.moved, state.shells, state.kinds, there};
    grow(growth, seeds, bound);
    return plan_of(state, growth);
}

template <int D>
Moves<D> plan_towards(const RepairState<D>& state, const Overlay<EdgeId, LagrangeNode<D>>& there) {
    Growth<D> growth{state.moved, state.shells, state.kinds, there};
    for (const EdgeId edge : there.set_rows())
        if (there[edge] != state.moved.nodes[edge]) growth.choose(edge);
    shrink(state, growth);
    return plan_of(state, growth);
}

#define CAMBER_INSTANTIATE(D)                                                                 \
    template Moves<D> plan_extension<D>(const RepairState<D>&, const std::vector<ElementId>&, \
                                        const Column<LagrangeNode<D>>&, double);              \
    template Moves<D> plan_towards<D>(const RepairState<D>&, const Overlay<EdgeId, LagrangeNode<D>>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
