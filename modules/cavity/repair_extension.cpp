module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.cavity;
import :repair_state;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// Which edges have their extended nodes, and the elements around them with these.
template <int D>
struct Extending {
    const RepairState<D>& state;
    const Buffer<LagrangeNode<D>>& extended;
    std::vector<std::uint8_t> chosen;  ///< of edges
    std::vector<EdgeId> edges;         ///< those chosen, in the order in which they were

    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> element = state.element(e);
        const auto& edges_of = state.mesh.edges.of_elements[e];
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (chosen[edges_of[i].index()] != 0) element.nodes[D + 1 + i] = extended[edges_of[i].index()].point;
        return element;
    }
    [[nodiscard]] Verdict verdict(ElementId e) const { return decide(element(e), state.options.min_scaled_jacobian); }
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

/// Outwards: whatever is not good with the nodes chosen so far gets its own.
template <int D>
void grow(Extending<D>& extending, const std::vector<ElementId>& seeds) {
    std::vector<ElementId> queue = seeds;
    while (!queue.empty()) {
        std::vector<EdgeId> added;
        for (const ElementId e : queue) {
            const auto own = extending.choose(e);
            added.insert(added.end(), own.begin(), own.end());
        }
        queue.clear();
        for (const ElementId e : extending.around(added))
            if (extending.verdict(e) != Verdict::valid) queue.push_back(e);
    }
}

/// Inwards again: around elements that would be spoilt nodes stay.
template <int D>
void shrink(Extending<D>& extending) {
    std::vector<ElementId> suspects = extending.around(extending.edges);
    while (!suspects.empty()) {
        std::vector<EdgeId> removed;
        for (const ElementId e : suspects) {
            if (!spoilt(extending.state, e, extending.element(e), extending.verdict(e))) continue;
            for (const EdgeId edge : extending.state.mesh.edges.of_elements[e])
                if (std::exchange(extending.chosen[edge.index()], std::uint8_t{0}) != 0) removed.push_back(edge);
        }
        suspects = extending.around(removed);
    }
    std::erase_if(extending.edges, [&](EdgeId e) { return extending.chosen[e.index()] == 0; });
}

}  // namespace

template <int D>
RepairPlan<D> plan_extension(const RepairState<D>& state, const std::vector<ElementId>& seeds,
                             const Buffer<LagrangeNode<D>>& extended) {
    Extending<D> extending{state, extended, std::vector<std::uint8_t>(state.mesh.edges.size(), 0), {}};
    grow(extending, seeds);
    shrink(extending);
    RepairPlan<D> plan;
    for (const ElementId e : extending.around(extending.edges)) plan.verdicts.emplace_back(e, extending.verdict(e));
    extending.edges |= ranges::actions::sort;
    plan.nodes.reserve(extending.edges.size());
    for (const EdgeId edge : extending.edges) plan.nodes.emplace_back(edge, extended[edge.index()]);
    return plan;
}

template RepairPlan<2> plan_extension<2>(const RepairState<2>&, const std::vector<ElementId>&,
                                         const Buffer<LagrangeNode<2>>&);
template RepairPlan<3> plan_extension<3>(const RepairState<3>&, const std::vector<ElementId>&,
                                         const Buffer<LagrangeNode<3>>&);

}  // namespace camber
