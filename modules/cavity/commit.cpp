module;
#include <cstddef>
#include <span>
#include <string>
#include <utility>
module camber.cavity;
import camber.core;
import camber.validity;

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
    const QuadraticMesh<D> mesh = proposed(judged.mesh(), judged.proposal());
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
    return {proposed(judged.mesh(), judged.proposal()), identities(judged.mesh())};
}

template <int D>
Outcome<Curving<D>> commit(Curving<D> curving, std::span<const Patch<D>> patches) {
    for (const Patch<D>& patch : patches)
        for (const PatchNode<D>& node : patch.nodes)
            if (!node.edge.valid() || node.edge.index() >= curving.mesh.edges.size())
                return fail(ErrorKind::internal, "a patch has an edge that the mesh does not have");
    auto nodes = take(std::move(curving.mesh.mid_nodes));
    auto changes = take(std::move(curving.changes));
    for (const Patch<D>& patch : patches)
        for (const PatchNode<D>& node : patch.nodes) {
            nodes[node.edge.index()] = node.node;
            changes[node.edge.index()] = node.change;
        }
    curving.mesh.mid_nodes = std::move(nodes);
    curving.changes = std::move(changes);
    return curving;
}

#define CAMBER_INSTANTIATE(D)                                                      \
    template Outcome<Curving<D>> commit<D>(Curving<D>, std::span<const Patch<D>>); \
    template Outcome<Committed<D>> commit<D>(const JudgedProposal<D>&);            \
    template Committed<D> commit_uncertified<D>(const JudgedProposal<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
