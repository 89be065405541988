module;
#include <array>
#include <cstddef>
#include <utility>
#include <vector>
module camber.repair;
import camber.core;
import camber.validity;

namespace camber {

template <int D>
RepairStatistics changes_between(const JudgedProposal<D>& before, const JudgedProposal<D>& after) {
    RepairStatistics changes;
    const auto& verdicts = before.validation().verdicts;
    for (std::size_t e = 0; e < verdicts.size(); ++e)
        changes.corrected_elements += verdicts[e] != Verdict::valid && after.validation().verdicts[e] == Verdict::valid;
    const Proposal<D>& was = before.proposal();
    const Proposal<D>& is = after.proposal();
    for (std::size_t e = 0; e < was.mid_nodes.size(); ++e)
        if (is.mid_nodes[e] != was.mid_nodes[e])
            ++(was.kinds[e] == EdgeKind::volume ? changes.moved_volume_nodes : changes.moved_surface_nodes);
    for (std::size_t v = 0; v < was.points.size(); ++v) changes.moved_vertices += is.points[v] != was.points[v];
    return changes;
}

template <int D>
Repaired<D> with_all_changes(const JudgedProposal<D>& before, Repaired<D> after) {
    const double work = after.statistics.work;
    after.judged = after.judged.with_kinds(before.proposal().kinds);
    after.statistics = changes_between(before, after.judged);
    after.statistics.work = work;
    return after;
}

template <int D>
std::vector<ElementId> elements_not_valid(const Validation<D>& validation) {
    std::vector<ElementId> elements;
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e)
        if (validation.verdicts[e] != Verdict::valid) elements.emplace_back(e);
    return elements;
}

template <int D>
Column<EdgeChange> changes_after(const QuadraticMesh<D>& mesh, const Proposal<D>& before, const Column<Vec<D>>& points,
                                 const Column<LagrangeNode<D>>& mid_nodes) {
    Buffer<EdgeChange> changes(before.changes.begin(), before.changes.end());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        if (mid_nodes[e] == before.mid_nodes[e]) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        const bool straight = mid_nodes[e].point == midpoint(points[a], points[b]);
        changes[e] = straight ? EdgeChange::straightened : EdgeChange::relaxed;
    }
    return changes;
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template RepairStatistics changes_between<D>(const JudgedProposal<D>&, const JudgedProposal<D>&);                \
    template Repaired<D> with_all_changes<D>(const JudgedProposal<D>&, Repaired<D>);                                 \
    template std::vector<ElementId> elements_not_valid<D>(const Validation<D>&);                                     \
    template Column<EdgeChange> changes_after<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Column<Vec<D>>&, \
                                                 const Column<LagrangeNode<D>>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
