module;
#include <cstddef>
#include <string>
module camber.validity;
import camber.core;

namespace camber {

namespace {

template <int D>
MeshMaps identities(const QuadraticMesh<D>& mesh) {
    return {IdMap<VertexId>::identity(mesh.linear.points.size()), IdMap<EdgeId>::identity(mesh.edges.size()),
            IdMap<ElementId>::identity(mesh.linear.elements.size()),
            IdMap<FacetId>::identity(mesh.linear.facets.size())};
}

/// The first element of which det J > 0 is not certified. There is one.
template <int D>
ElementId first_uncertified(const JudgedProposal<D>& judged) {
    const QuadraticMesh<D> mesh = apply_proposal(judged.mesh(), judged.proposal());
    const auto& verdicts = judged.validation().verdicts;
    for (std::size_t e = 0; e < verdicts.size(); ++e)
        if (verdicts[e] != Verdict::valid &&
            decide(nodal_element<D>(mesh, mesh.mid_nodes.view(), ElementId(e)), 0) != Verdict::valid)
            return ElementId(e);
    return judged.validation().worst;
}

}  // namespace

template <int D>
Outcome<Committed<D>> commit(const JudgedProposal<D>& judged) {
    const Validation<D>& validation = judged.validation();
    if (!validation.certified())
        return fail(ErrorKind::input,
                    "is not certified valid, one of " + std::to_string(validation.not_positive) +
                        " of which det J > 0 is not certain",
                    {}, Entity{simplex_name<D>, first_uncertified(judged).index() + 1},
                    "put a relax stage before commit");
    return commit_uncertified(judged);
}

template <int D>
Committed<D> commit_uncertified(const JudgedProposal<D>& judged) {
    return {apply_proposal(judged.mesh(), judged.proposal()), identities(judged.mesh())};
}

template Outcome<Committed<2>> commit<2>(const JudgedProposal<2>&);
template Outcome<Committed<3>> commit<3>(const JudgedProposal<3>&);
template Committed<2> commit_uncertified<2>(const JudgedProposal<2>&);
template Committed<3> commit_uncertified<3>(const JudgedProposal<3>&);

}  // namespace camber
