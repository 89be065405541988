module;
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

template <int D>
Outcome<JudgedProposal<D>> judge_moved(const MovedMesh<D>& moved, const Incidence<ElementId>& shells,
                                       const JudgedProposal<D>& before, const Execution& execution) {
    auto proposal = moved.proposal(before.proposal());
    for (const VertexId v : moved.points.set_rows())
        if (moved.points[v] != before.proposal().points[v])
            return validate(before.mesh(), std::move(proposal), before.validation().bound, execution);
    std::vector<ElementId> touched;
    for (const EdgeId edge : moved.nodes.set_rows())
        if (moved.nodes[edge] != moved.nodes.base()[edge])
            touched.insert(touched.end(), shells[edge].begin(), shells[edge].end());
    touched |= ranges::actions::sort | ranges::actions::unique;
    return before.judge_again(std::move(proposal), touched, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<JudgedProposal<D>> judge_moved<D>(const MovedMesh<D>&, const Incidence<ElementId>&, \
                                                       const JudgedProposal<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
