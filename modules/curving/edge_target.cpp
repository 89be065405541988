module;
#include <array>
#include <span>
module camber.curving;
import camber.core;
import camber.metric;
import camber.validity;

namespace camber {

namespace {

template <int D>
Vec<D> chord_middle(const QuadraticMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges.vertices[edge];
    return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
}

}  // namespace

template <int D>
EdgeTarget<D> boundary_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node) {
    const bool moved = node.point != chord_middle(mesh, edge);
    return {.node = node, .change = moved ? EdgeChange::projected : EdgeChange::straight, .flags = {}};
}

template <int D>
EdgeTarget<D> volume_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& present,
                            std::span<const ElementId> shell, const BackMesh<D>& back, const EdgeRules& rules,
                            const EdgeMinimiserOptions& options) {
    if (shell.empty()) return boundary_target(mesh, edge, mesh.mid_nodes[edge]);
    const auto& [a, b] = mesh.edges.vertices[edge];
    const EdgeMinimum<D> m = minimise_back_edge(back, a, b, present, shell, rules, options);
    const bool moved = m.node.point != chord_middle(mesh, edge);
    return {.node = m.node,
            .change = moved ? EdgeChange::optimised : EdgeChange::straight,
            .flags = {.volume = 1,
                      .curved = moved,
                      .polished = m.search == EdgeSearch::polished,
                      .exhausted = m.search == EdgeSearch::exhausted,
                      .shortened = m.shortened,
                      .outside = m.outside,
                      .lost = m.lost},
            .straight_length = m.straight_length,
            .length = m.length};
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template EdgeTarget<D> boundary_target<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&);       \
    template EdgeTarget<D> volume_target<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&,          \
                                            std::span<const ElementId>, const BackMesh<D>&, const EdgeRules&, \
                                            const EdgeMinimiserOptions&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
