module;
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>
module camber.repair;
import :by_programmes;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.programmes;
import camber.curving;

namespace camber {

namespace {

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, std::size_t models) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges ||
        models != edges)
        return fail(ErrorKind::internal, "the proposal or the models have another number of edges than the mesh");
    return Done{};
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                            const RepairOptions& options, const Execution& execution) {
    if (!needs_models(options.method)) return relax(wanted, options, execution);
    if (auto fits = check(wanted.mesh(), wanted.proposal(), models.size()); !fits) return fail(fits.error());
    if (auto fits = check_limits(options); !fits) return fail(fits.error());
    if (wanted.validation().bound != options.min_scaled_jacobian) {
        const auto again = validate(wanted.mesh(), wanted.proposal(), options.min_scaled_jacobian, execution);
        if (!again) return fail(again.error());
        return repair(*again, models, options, execution);
    }
    if (wanted.validation().all_valid()) return Repaired<D>{wanted};
    return guarded([&] { return repair_by_programmes(wanted, models, options, execution); });
}

template <int D>
Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                          const RepairOptions& options, const Execution& execution) {
    auto kept = repair(wanted, models, options, execution);
    if (!kept || kept->judged.validation().all_valid() || options.method != RepairMethod::cavity) return kept;
    auto done = relax(kept->judged, options, execution);
    if (!done) return fail(done.error());
    if (done->judged.validation().not_valid() >= kept->judged.validation().not_valid()) return kept;
    kept->judged = std::move(done->judged);
    std::erase_if(kept->given_up, [&](ElementId e) { return kept->judged.validation().verdicts[e] == Verdict::valid; });
    return with_all_changes(wanted, std::move(*kept));
}

template <int D>
Outcome<Column<QuadraticModel<D>>> own_models(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                              const Execution& execution) {
    const QuadraticMesh<D>& mesh = judged.mesh();
    const Proposal<D>& proposal = judged.proposal();
    auto extended = extend_boundary(mesh, proposal.kinds, proposal.mid_nodes, shells, {}, execution);
    if (!extended) return fail(extended.error());
    Buffer<LagrangeNode<D>> wanted(proposal.mid_nodes.begin(), proposal.mid_nodes.end());
    for (std::size_t e = 0; e < wanted.size(); ++e)
        for (const VertexId v : mesh.edges.vertices[e])
            wanted[e].point -= 0.5 * (proposal.points[v] - mesh.linear.points[v]);
    for (const ElementId e : elements_not_valid(judged.validation()))
        for (const EdgeId edge : mesh.edges.of_elements[e])
            if (proposal.kinds[edge] == EdgeKind::volume) wanted[edge.index()] = extended->nodes[edge.index()];
    auto models = implied_edge_models(mesh, Column<LagrangeNode<D>>(std::move(wanted)), shells, execution);
    if (!models) return fail(models.error());
    return Column<QuadraticModel<D>>(std::move(*models));
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<Repaired<D>> repair<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&,               \
                                            const RepairOptions&, const Execution&);                                  \
    template Outcome<Repaired<D>> repair_or_straighten<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&, \
                                                          const RepairOptions&, const Execution&);                    \
    template Outcome<Column<QuadraticModel<D>>> own_models<D>(const JudgedProposal<D>&, const Incidence<ElementId>&,  \
                                                              const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
