module;
#include <array>
#include <cstddef>
#include <utility>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import :polish;

namespace camber {

template <int D>
Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                         const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                         const ShapeOptions& options, const Execution& execution) {
    auto extension = extend_boundary(mesh, kinds, boundary_nodes, shells, options.extension, execution);
    if (!extension) return fail(extension.error());
    auto polished = polish(mesh, kinds, std::move(extension->nodes), shells, options, execution);
    if (!polished) return fail(polished.error());
    auto& nodes = polished->nodes;
    Shaped<D> shaped;
    shaped.iterations = extension->iterations;
    shaped.solved = extension->solved;
    shaped.after_extension = polished->before;
    shaped.steps = polished->steps;
    shaped.smallest = polished->smallest;
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const LagrangeNode<D> middle{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
        changes[e] = nodes[e] == middle             ? EdgeChange::straight
                     : kinds[e] == EdgeKind::volume ? EdgeChange::optimised
                                                    : EdgeChange::projected;
    }
    shaped.proposal = {mesh.linear.points, std::move(nodes), kinds, std::move(changes)};
    return shaped;
}

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<Shaped<D>> shape<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,            \
                                         const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
                                         const ShapeOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
