module;
#include <cstddef>
#include <span>
#include <string>
#include <utility>
module camber.cavity;
import camber.core;
import camber.validity;

namespace camber {

template <int D>
Outcome<QuadraticMesh<D>> commit(QuadraticMesh<D> mesh, const Proposal<D>& proposal, const Validation<D>& validation) {
    if (validation.verdicts.size() != mesh.linear.elements.size())
        return fail(ErrorKind::internal, "commit needs a verdict for each element");
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e)
        if (validation.verdicts[e] != Verdict::valid)
            return fail(ErrorKind::input,
                        "is not certified valid, one of " + std::to_string(validation.invalid + validation.undecided),
                        {}, Entity{simplex_name<D>, e + 1}, "put a relax stage before commit, or lower its bound");
    return commit_unvalidated(std::move(mesh), proposal);
}

template <int D>
Outcome<QuadraticMesh<D>> commit_unvalidated(QuadraticMesh<D> mesh, const Proposal<D>& proposal) {
    if (proposal.mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "commit needs a node for each edge");
    mesh.mid_nodes = proposal.mid_nodes;
    return mesh;
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

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<Curving<D>> commit<D>(Curving<D>, std::span<const Patch<D>>);                            \
    template Outcome<QuadraticMesh<D>> commit<D>(QuadraticMesh<D>, const Proposal<D>&, const Validation<D>&); \
    template Outcome<QuadraticMesh<D>> commit_unvalidated<D>(QuadraticMesh<D>, const Proposal<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
