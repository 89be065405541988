module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :state;
import :vertex_moves;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// Which edges have their nodes of `there`, and the elements around them with these.
template <int D>
struct Moving {
    const RepairState<D>& state;
    const Buffer<LagrangeNode<D>>& there;
    std::vector<std::uint8_t> chosen;  ///< of edges
    std::vector<EdgeId> edges;         ///< those chosen

    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> element = state.element(e);
        const auto& edges_of = state.mesh.edges.of_elements[e];
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (chosen[edges_of[i].index()] != 0) element.nodes[D + 1 + i] = there[edges_of[i].index()].point;
        return element;
    }
    [[nodiscard]] Verdict verdict(ElementId e) const { return verdict_of(state, e, element(e)); }
    [[nodiscard]] std::vector<ElementId> around(const std::vector<EdgeId>& some) const {
        std::vector<ElementId> elements;
        for (const EdgeId edge : some)
            elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
        elements |= ranges::actions::sort | ranges::actions::unique;
        return elements;
    }
    /// Its volume edges that are not chosen yet.
    std::vector<EdgeId> choose(ElementId e) {
        std::vector<EdgeId> added;
        for (const EdgeId edge : state.mesh.edges.of_elements[e]) {
            if (state.kinds[edge] != EdgeKind::volume || chosen[edge.index()] != 0) continue;
            chosen[edge.index()] = 1;
            added.push_back(edge);
        }
        edges.insert(edges.end(), added.begin(), added.end());
        return added;
    }
};

/// Outwards: whatever is not above the bound with the nodes chosen so far gets its own.
template <int D>
void grow(Moving<D>& moving, const std::vector<ElementId>& seeds, double bound) {
    std::vector<ElementId> queue = seeds;
    while (!queue.empty()) {
        std::vector<EdgeId> added;
        for (const ElementId e : queue) {
            const auto own = moving.choose(e);
            added.insert(added.end(), own.begin(), own.end());
        }
        queue.clear();
        for (const ElementId e : moving.around(added))
            if (decide(moving.element(e), bound) != Verdict::valid) queue.push_back(e);
    }
}

/// Inwards again: around elements that would be spoilt nodes stay.
template <int D>
void shrink(Moving<D>& moving) {
    std::vector<ElementId> suspects = moving.around(moving.edges);
    while (!suspects.empty()) {
        std::vector<EdgeId> removed;
        for (const ElementId e : suspects) {
            if (!spoilt(moving.state, e, moving.element(e), moving.verdict(e))) continue;
            for (const EdgeId edge : moving.state.mesh.edges.of_elements[e])
                if (std::exchange(moving.chosen[edge.index()], std::uint8_t{0}) != 0) removed.push_back(edge);
        }
        suspects = moving.around(removed);
    }
    std::erase_if(moving.edges, [&](EdgeId e) { return moving.chosen[e.index()] == 0; });
}

template <int D>
RepairPlan<D> plan_of(Moving<D>& moving) {
    RepairPlan<D> plan;
    for (const ElementId e : moving.around(moving.edges)) plan.verdicts.emplace_back(e, moving.verdict(e));
    moving.edges |= ranges::actions::sort;
    plan.nodes.reserve(moving.edges.size());
    for (const EdgeId edge : moving.edges) plan.nodes.emplace_back(edge, moving.there[edge.index()]);
    return plan;
}

}  // namespace

template <int D>
RepairPlan<D> plan_extension(const RepairState<D>& state, const std::vector<ElementId>& seeds,
                             const Buffer<LagrangeNode<D>>& extended, double bound) {
    Moving<D> moving{state, extended, std::vector<std::uint8_t>(state.mesh.edges.size(), 0), {}};
    grow(moving, seeds, bound);
    return plan_of(moving);
}

template <int D>
RepairPlan<D> plan_towards(const RepairState<D>& state, const Buffer<LagrangeNode<D>>& there) {
    Moving<D> moving{state, there, std::vector<std::uint8_t>(state.mesh.edges.size(), 0), {}};
    for (std::size_t e = 0; e < there.size(); ++e) {
        if (there[e] == state.nodes[e]) continue;
        moving.chosen[e] = 1;
        moving.edges.push_back(EdgeId(e));
    }
    shrink(moving);
    return plan_of(moving);
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template RepairPlan<D> plan_extension<D>(const RepairState<D>&, const std::vector<ElementId>&, \
                                             const Buffer<LagrangeNode<D>>&, double);              \
    template RepairPlan<D> plan_towards<D>(const RepairState<D>&, const Buffer<LagrangeNode<D>>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
