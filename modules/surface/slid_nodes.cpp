module;
#include <array>
#include <cstddef>
#include <span>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& nodes,
                                            std::span<const Vec<D>> shifts, const Features<D>& features,
                                            const Geometry<D>& geometry, const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (nodes.size() != n || shifts.size() != n || features.edge_kinds.size() != n)
        return fail(ErrorKind::internal, "the nodes or shifts are not of this mesh");
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    return map_each(execution, n, [&](std::size_t e) -> LagrangeNode<D> {
        if (D == 2 || features.edge_kinds[e] != EdgeKind::surface || required[e] != 0 || shifts[e] == Vec<D>{})
            return nodes[e];
        const auto& [low, high] = mesh.edges.vertices[e];
        const EdgeSite<D> site{EdgeId(e),
                               features.edge_kinds[e],
                               {mesh.linear.points[low], mesh.linear.points[high]},
                               facet_sites<D>(mesh.linear, (*shells)[e])};
        const auto plane = common_plane(*geometry, site);
        return plane ? LagrangeNode<D>{slid_within(*plane, nodes[e].point, shifts[e])} : nodes[e];
    });
}

template Outcome<Buffer<LagrangeNode<2>>> slid_nodes(const QuadraticMesh<2>&, const Column<LagrangeNode<2>>&,
                                                     std::span<const Vec<2>>, const Features<2>&, const Geometry<2>&,
                                                     const Execution&);
template Outcome<Buffer<LagrangeNode<3>>> slid_nodes(const QuadraticMesh<3>&, const Column<LagrangeNode<3>>&,
                                                     std::span<const Vec<3>>, const Features<3>&, const Geometry<3>&,
                                                     const Execution&);

}  // namespace camber
