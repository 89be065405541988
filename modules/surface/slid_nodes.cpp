module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// The plane in which the node of an edge may slide: of a surface edge whose facets lie in one.
template <int D>
std::optional<Plane<D>> plane_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Incidence<FacetId>& shells,
                                 const Features<D>& features, const Geometry<D>& geometry, std::size_t e) {
    if (D == 2 || features.edge_kinds[e] != EdgeKind::surface || shells[e].empty()) return {};
    // Most edges are on no plane: the first facet tells, before the site has a list of them.
    if (!geometry->plane_at(facet_site(mesh, shells[e].front()))) return {};
    const auto& [low, high] = edges.vertices[e];
    const EdgeSite<D> site{
        EdgeId(e), EdgeKind::surface, {mesh.points[low], mesh.points[high]}, facet_sites<D>(mesh, shells[e])};
    return common_plane(*geometry, site);
}

}  // namespace

template <int D>
Outcome<Buffer<std::uint8_t>> edges_in_planes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                              const Geometry<D>& geometry, const Execution& execution) {
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) -> std::uint8_t {
        return plane_of(mesh.linear, mesh.edges, *shells, features, geometry, e) ? 1 : 0;
    });
}

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
        if (required[e] != 0 || shifts[e] == Vec<D>{}) return nodes[e];
        const auto plane = plane_of(mesh.linear, mesh.edges, *shells, features, geometry, e);
        return plane ? LagrangeNode<D>{slid_within(*plane, nodes[e].point, shifts[e])} : nodes[e];
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<Buffer<std::uint8_t>> edges_in_planes(const QuadraticMesh<D>&, const Features<D>&,           \
                                                           const Geometry<D>&, const Execution&);                 \
    template Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>&, const Column<LagrangeNode<D>>&, \
                                                         std::span<const Vec<D>>, const Features<D>&,             \
                                                         const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
