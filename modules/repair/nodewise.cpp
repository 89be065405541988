module;
#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :nodewise;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

template <int D>
LagrangeNode<D> Repair<D>::towards_middle(EdgeId edge, double theta) const {
    const LagrangeNode<D> m = middle(edge);
    if (!(theta > 0)) return m;
    return {m.point + theta * (nodes[edge.index()].point - m.point)};
}

template <int D>
double Repair<D>::length(EdgeId edge) const {
    const auto& [a, b] = mesh.edges.vertices[edge];
    return distance(mesh.linear.points[a], mesh.linear.points[b]);
}

bool contains(EdgeGroup group, EdgeKind kind) {
    if (kind == EdgeKind::fixed) return false;
    return group == EdgeGroup::all || (group == EdgeGroup::volume) == (kind == EdgeKind::volume);
}

template <int D>
std::vector<EdgeId> loose_edges(const Repair<D>& repair, ElementId e, EdgeGroup group) {
    std::vector<EdgeId> loose;
    for (const EdgeId edge : repair.mesh.edges.of_elements[e])
        if (contains(group, repair.kinds[edge]) && !repair.straight(edge)) loose.push_back(edge);
    return loose;
}

template <int D>
void move_node(Repair<D>& repair, EdgeId edge, const LagrangeNode<D>& node, Changes<D>& changes) {
    LagrangeNode<D>& present = repair.nodes[edge.index()];
    repair.originals.try_emplace(edge, present);
    changes.nodes.emplace_back(edge, present);
    present = node;
}

template <int D>
void check_shells(Repair<D>& repair, std::span<const EdgeId> edges, Changes<D>& changes) {
    std::vector<ElementId> around;
    for (const EdgeId edge : edges) around.insert(around.end(), repair.shells[edge].begin(), repair.shells[edge].end());
    around |= ranges::actions::sort | ranges::actions::unique;
    for (const ElementId e : around) {
        Verdict& verdict = repair.verdicts[e.index()];
        const Verdict now = decide(repair.element(e), repair.options.min_scaled_jacobian);
        if (now == verdict) continue;
        changes.verdicts.emplace_back(e, verdict);
        if (verdict == Verdict::valid) changes.broken.push_back(e);
        verdict = now;
    }
}

template <int D>
void undo(Repair<D>& repair, const Changes<D>& changes) {
    for (auto it = changes.nodes.rbegin(); it != changes.nodes.rend(); ++it)
        repair.nodes[it->first.index()] = it->second;
    for (auto it = changes.verdicts.rbegin(); it != changes.verdicts.rend(); ++it)
        repair.verdicts[it->first.index()] = it->second;
}

template <int D>
BoundedJacobian<D> jacobian_with(const Repair<D>& repair, ElementId e, EdgeId edge, const LagrangeNode<D>& node) {
    const auto& edges = repair.mesh.edges.of_elements[e];
    NodalSimplex<D> element = repair.element(e);
    for (int i = 0; i < edges_per_simplex<D>; ++i)
        if (edges[i] == edge) element.nodes[D + 1 + i] = node.point;
    return bounded_jacobian(element);
}

/// Elements that one attempt of mend_with_neighbours may relax, repeats counted.
constexpr std::size_t most_drawn_in = 200;

template <int D>
bool mend_with_neighbours(Repair<D>& repair, ElementId e, EdgeGroup group, double scaled_jacobian) {
    Changes<D> changes;
    std::map<EdgeId, int> corrections;
    std::vector<ElementId> queue{e};
    const auto reaches = [&](ElementId element) {
        return repair.valid(element) && decide(repair.element(element), scaled_jacobian) == Verdict::valid;
    };
    for (std::size_t next = 0; next < queue.size(); ++next) {
        const ElementId element = queue[next];
        if (reaches(element)) continue;
        const std::vector<EdgeId> loose = loose_edges(repair, element, group);
        if (loose.empty() || next >= most_drawn_in) {
            undo(repair, changes);
            return false;
        }
        for (const EdgeId edge : loose) {
            const bool last = ++corrections[edge] > repair.options.max_corrections;
            move_node(repair, edge, repair.towards_middle(edge, last ? 0 : repair.options.theta), changes);
        }
        changes.broken.clear();
        check_shells(repair, loose, changes);
        queue.insert(queue.end(), changes.broken.begin(), changes.broken.end());
        if (!reaches(element)) queue.push_back(element);
    }
    return true;
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template struct Repair<D>;                                                                                 \
    template std::vector<EdgeId> loose_edges<D>(const Repair<D>&, ElementId, EdgeGroup);                       \
    template void move_node<D>(Repair<D>&, EdgeId, const LagrangeNode<D>&, Changes<D>&);                       \
    template void check_shells<D>(Repair<D>&, std::span<const EdgeId>, Changes<D>&);                           \
    template void undo<D>(Repair<D>&, const Changes<D>&);                                                      \
    template BoundedJacobian<D> jacobian_with<D>(const Repair<D>&, ElementId, EdgeId, const LagrangeNode<D>&); \
    template bool mend_with_neighbours<D>(Repair<D>&, ElementId, EdgeGroup, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
