module;
#include <span>
#include <utility>
module camber.cavity;
import camber.core;

namespace camber {

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

template Outcome<Curving<2>> commit<2>(Curving<2>, std::span<const Patch<2>>);
template Outcome<Curving<3>> commit<3>(Curving<3>, std::span<const Patch<3>>);

}  // namespace camber
