module;
#include <array>
#include <cstddef>
#include <utility>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution) {
    if (features.edge_kinds.size() != mesh.edges.size() || mesh.mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features are not of this mesh");
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        if (features.edge_kinds[e] == EdgeKind::volume) return mesh.mid_nodes[e];
        if (required[e] != 0) return mesh.mid_nodes[e];
        const auto& [low, high] = mesh.edges.vertices[e];
        return {geometry->middle_of({EdgeId(e),
                                     features.edge_kinds[e],
                                     {mesh.linear.points[low], mesh.linear.points[high]},
                                     facet_sites<D>(mesh.linear, (*shells)[e])})};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>&, const Features<D>&, \
                                                             const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
