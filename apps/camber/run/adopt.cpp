module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.config;
import camber.surface;
import camber.validity;
import camber.curving;
import :mend;
import :report;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<State<D>> adopt_stage(State<D> state, const config::Features& options, Report& report,
                              const Execution& execution) {
    const QuadraticMesh<D>& mesh = *state.quadratic();
    auto features = find_features(mesh.linear, mesh.edges,
                                  FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle}, execution);
    if (!features) return fail(features.error());
    report.boundary = BoundaryReport{
        features->surface_edges, features->ridge_edges, features->corners, features->patch_count, {}, {}};
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const bool straight = mesh.mid_nodes[e].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
        const bool volume = features->edge_kinds[e] == EdgeKind::volume;
        changes[e] = straight ? EdgeChange::straight : volume ? EdgeChange::optimised : EdgeChange::projected;
    }
    state.required = options.required_boundary;
    state.propose({mesh.linear.points, mesh.mid_nodes, held_kinds(mesh, features->edge_kinds, state.required),
                   std::move(changes)});
    state.features = std::move(*features);
    state.adopted = true;
    return state;
}

template <int D>
Outcome<Column<LagrangeNode<D>>> own_wishes(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                            const Execution& execution) {
    const QuadraticMesh<D>& mesh = judged.mesh();
    const Proposal<D>& proposal = judged.proposal();
    const Validation<D>& validation = judged.validation();
    auto extended = extend_boundary(mesh, proposal.kinds, proposal.mid_nodes, shells, {}, execution);
    if (!extended) return fail(extended.error());
    Buffer<LagrangeNode<D>> wanted(proposal.mid_nodes.begin(), proposal.mid_nodes.end());
    for (std::size_t e = 0; e < wanted.size(); ++e)
        for (const VertexId v : mesh.edges.vertices[e])
            wanted[e].point -= 0.5 * (proposal.points[v] - mesh.linear.points[v]);
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e) {
        if (validation.verdicts[e] == Verdict::valid) continue;
        for (const EdgeId edge : mesh.edges.of_elements[e])
            if (proposal.kinds[edge] == EdgeKind::volume) wanted[edge.index()] = extended->nodes[edge.index()];
    }
    return Column<LagrangeNode<D>>(std::move(wanted));
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<State<D>> adopt_stage<D>(State<D>, const config::Features&, Report&, const Execution&);       \
    template Outcome<Column<LagrangeNode<D>>> own_wishes<D>(const JudgedProposal<D>&, const Incidence<ElementId>&, \
                                                            const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
