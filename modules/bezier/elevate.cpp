module;
#include <array>
#include <cstddef>
#include <utility>
module camber.bezier;
import camber.core;

namespace camber {

template <int D>
Outcome<QuadraticMesh<D>> elevate(LinearMesh<D> mesh, const Execution& execution) {
    auto edges = unique_edges(mesh, part_of(execution, 0, 0.82));
    if (!edges) return fail(edges.error());
    auto mid_nodes = map_each(part_of(execution, 0.82, 1), edges->size(), [&](std::size_t e) {
        const auto& [a, b] = edges->vertices[e];
        return LagrangeNode<D>{midpoint(mesh.points[a], mesh.points[b])};
    });
    if (!mid_nodes) return fail(mid_nodes.error());
    return QuadraticMesh<D>{std::move(mesh), std::move(*edges), std::move(*mid_nodes)};
}

#define CAMBER_INSTANTIATE(D) template Outcome<QuadraticMesh<D>> elevate<D>(LinearMesh<D>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
