module;
#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :trial;
import :moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

template <int D>
LagrangeNode<D> Trial<D>::towards_middle(EdgeId edge, double theta) const {
    const LagrangeNode<D> m = middle(edge);
    if (!(theta > 0)) return m;
    return {m.point + theta * (node(edge).point - m.point)};
}

template <int D>
double Trial<D>::length(EdgeId edge) const {
    const auto& [a, b] = mesh().edges.vertices[edge];
    return distance(state.moved.points[a], state.moved.points[b]);
}

template <int D>
Moves<D> Trial<D>::moves() const {
    Moves<D> moves;
    for (const EdgeId edge : nodes.keys()) moves.nodes.emplace_back(edge, *nodes.find(edge));
    for (const ElementId e : verdicts.keys()) moves.verdicts.emplace_back(e, *verdicts.find(e));
    return moves;
}

bool contains(EdgeGroup group, EdgeKind kind) {
    if (kind == EdgeKind::fixed) return false;
    return group == EdgeGroup::all || (group == EdgeGroup::volume) == (kind == EdgeKind::volume);
}

template <int D>
std::vector<EdgeId> loose_edges(const Trial<D>& trial, ElementId e, EdgeGroup group) {
    std::vector<EdgeId> loose;
    for (const EdgeId edge : trial.mesh().edges.of_elements[e])
        if (contains(group, trial.state.kinds[edge]) && !trial.straight(edge)) loose.push_back(edge);
    return loose;
}

template <int D>
void move_node(Trial<D>& trial, EdgeId edge, const LagrangeNode<D>& node, Changes<D>& changes) {
    changes.nodes.emplace_back(edge, trial.node(edge));
    trial.nodes.at(edge) = node;
}

template <int D>
void check_shells(Trial<D>& trial, std::span<const EdgeId> edges, Changes<D>& changes) {
    std::vector<ElementId> around;
    for (const EdgeId edge : edges)
        around.insert(around.end(), trial.state.shells[edge].begin(), trial.state.shells[edge].end());
    around |= ranges::actions::sort | ranges::actions::unique;
    for (const ElementId e : around) {
        const Verdict verdict = trial.verdict(e);
        const Verdict now = decide(trial.element(e), trial.state.options.min_scaled_jacobian);
        if (now == verdict) continue;
        changes.verdicts.emplace_back(e, verdict);
        if (verdict == Verdict::valid) changes.broken.push_back(e);
        trial.verdicts.at(e) = now;
    }
}

template <int D>
void undo(Trial<D>& trial, const Changes<D>& changes) {
    for (auto it = changes.nodes.rbegin(); it != changes.nodes.rend(); ++it) trial.nodes.at(it->first) = it->second;
    for (auto it = changes.verdicts.rbegin(); it != changes.verdicts.rend(); ++it)
        trial.verdicts.at(it->first) = it->second;
}

template <int D>
BoundedJacobian<D> jacobian_with(const Trial<D>& trial, ElementId e, EdgeId edge, const LagrangeNode<D>& node) {
    const auto& edges = trial.mesh().edges.of_elements[e];
    NodalSimplex<D> element = trial.element(e);
    for (int i = 0; i < edges_per_simplex<D>; ++i)
        if (edges[i] == edge) element.nodes[D + 1 + i] = node.point;
    return bounded_jacobian(element);
}

/// Elements that one attempt of repair_with_neighbours may relax, repeats counted.
constexpr std::size_t max_drawn_in = 200;

template <int D>
bool repair_with_neighbours(Trial<D>& trial, ElementId e, EdgeGroup group, double scaled_jacobian) {
    Changes<D> changes;
    std::map<EdgeId, int> corrections;
    std::vector<ElementId> queue{e};
    const auto reaches = [&](ElementId element) {
        return trial.valid(element) && decide(trial.element(element), scaled_jacobian) == Verdict::valid;
    };
    for (std::size_t next = 0; next < queue.size(); ++next) {
        const ElementId element = queue[next];
        if (reaches(element)) continue;
        const std::vector<EdgeId> loose = loose_edges(trial, element, group);
        if (loose.empty() || next >= max_drawn_in) {
            undo(trial, changes);
            return false;
        }
        for (const EdgeId edge : loose) {
            const bool last = ++corrections[edge] > trial.state.options.max_corrections;
            move_node(trial, edge, trial.towards_middle(edge, last ? 0 : trial.state.options.theta), changes);
        }
        changes.broken.clear();
        check_shells(trial, loose, changes);
        queue.insert(queue.end(), changes.broken.begin(), changes.broken.end());
        if (!reaches(element)) queue.push_back(element);
    }
    return true;
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template struct Trial<D>;                                                                                 \
    template std::vector<EdgeId> loose_edges<D>(const Trial<D>&, ElementId, EdgeGroup);                       \
    template void move_node<D>(Trial<D>&, EdgeId, const LagrangeNode<D>&, Changes<D>&);                       \
    template void check_shells<D>(Trial<D>&, std::span<const EdgeId>, Changes<D>&);                           \
    template void undo<D>(Trial<D>&, const Changes<D>&);                                                      \
    template BoundedJacobian<D> jacobian_with<D>(const Trial<D>&, ElementId, EdgeId, const LagrangeNode<D>&); \
    template bool repair_with_neighbours<D>(Trial<D>&, ElementId, EdgeGroup, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
