module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.validity;
import camber.curving;
import :mend;

namespace camber::run {

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
    template Outcome<Column<LagrangeNode<D>>> own_wishes<D>(const JudgedProposal<D>&, const Incidence<ElementId>&, \
                                                            const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
