module;
#include <algorithm>
#include <cstddef>
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
            if (!is_degraded(state, e, growth.element(e), verdict_of(state, e, growth.element(e)))) continue;
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

/// Steps of a node; each but the last takes it half of the way that is left.
constexpr int max_steps = 4;

/// The next step of all volume nodes of these elements that are not at home.
template <int D>
Moves<D> steps_home(const RepairState<D>& state, const std::vector<ElementId>& elements, const HomeOf<D>& home,
                    SparseMap<EdgeId, int>& steps) {
    std::vector<EdgeId> edges;
    for (const ElementId e : elements)
        for (const EdgeId edge : state.mesh().edges.of_elements[e])
            if (state.kinds[edge] == EdgeKind::volume) edges.push_back(edge);
    edges |= ranges::actions::sort | ranges::actions::unique;
    Moves<D> moves;
    for (const EdgeId edge : edges) {
        const auto there = home(edge);
        const LagrangeNode<D>& now = state.moved.nodes[edge];
        if (!there || *there == now) continue;
        const bool last = ++steps.at(edge) >= max_steps;
        moves.nodes.emplace_back(edge, last ? *there : LagrangeNode<D>{midpoint(now.point, there->point)});
    }
    return moves;
}

template <int D>
std::vector<ElementId> elements_around(const RepairState<D>& state,
                                       const std::vector<std::pair<EdgeId, LagrangeNode<D>>>& nodes) {
    std::vector<ElementId> elements;
    for (const auto& [edge, node] : nodes)
        elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
    elements |= ranges::actions::sort | ranges::actions::unique;
    return elements;
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
Outcome<Done> go_home(RepairState<D>& state, std::vector<ElementId> queue, const HomeOf<D>& home,
                      const Execution& execution) {
    const double asked = state.options.aim();
    SparseMap<EdgeId, int> steps;
    while (!queue.empty()) {
        const auto moves = steps_home(state, queue, home, steps);
        if (moves.nodes.empty()) break;
        state.moved.apply(moves);
        const std::vector<ElementId> touched = elements_around(state, moves.nodes);
        const auto judged = map_each(execution, touched.size(), [&](std::size_t i) {
            const NodalSimplex<D> element = state.element(touched[i]);
            const Verdict verdict = verdict_of(state, touched[i], element);
            return std::pair(verdict, verdict == Verdict::valid && decide(element, asked) == Verdict::valid);
        });
        if (!judged) return fail(judged.error());
        std::vector<ElementId> next;
        for (std::size_t i = 0; i < touched.size(); ++i) {
            const auto& [verdict, reached] = (*judged)[i];
            state.moved.verdicts.set(touched[i], verdict);
            const bool waits = !reached && std::ranges::binary_search(queue, touched[i]);
            if (verdict != Verdict::valid || waits) next.push_back(touched[i]);
        }
        queue = std::move(next);
    }
    return Done{};
}

template <int D>
Moves<D> plan_towards(const RepairState<D>& state, const Overlay<EdgeId, LagrangeNode<D>>& there) {
    Growth<D> growth{state.moved, state.shells, state.kinds, there};
    for (const EdgeId edge : there.set_rows())
        if (there[edge] != state.moved.nodes[edge]) growth.choose(edge);
    shrink(state, growth);
    return plan_of(state, growth);
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<Done> go_home<D>(RepairState<D>&, std::vector<ElementId>, const HomeOf<D>&, const Execution&); \
    template Moves<D> plan_towards<D>(const RepairState<D>&, const Overlay<EdgeId, LagrangeNode<D>>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
