module;
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// The cosine of planes that are one, but for rounding.
constexpr double same_plane = 1 - 1e-12;

/// The plane on which all facets at the edge lie, where they lie on one.
template <int D>
std::optional<Plane<D>> plane_of(const Geometry<D>& geometry, const EdgeSite<D>& edge) {
    std::optional<Plane<D>> common;
    for (const FacetSite<D>& facet : edge.facets) {
        const auto plane = geometry->plane_at(facet);
        if (!plane || (common && std::abs(dot(plane->normal, common->normal)) < same_plane)) return std::nullopt;
        common = plane;
    }
    return common;
}

/// p moved by the part of `shift` that lies in the plane. A coordinate in which the plane is constant stays as it is.
template <int D>
Vec<D> slid(const Plane<D>& plane, const Vec<D>& p, const Vec<D>& shift) {
    Vec<D> q = p + (shift - dot(plane.normal, shift) * plane.normal);
    for (int k = 0; k < D; ++k)
        if (std::abs(plane.normal[k]) == 1) q[k] = p[k];
    return q;
}

}  // namespace

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
        const auto plane = plane_of(geometry, site);
        return plane ? LagrangeNode<D>{slid(*plane, nodes[e].point, shifts[e])} : nodes[e];
    });
}

template Outcome<Buffer<LagrangeNode<2>>> slid_nodes(const QuadraticMesh<2>&, const Column<LagrangeNode<2>>&,
                                                     std::span<const Vec<2>>, const Features<2>&, const Geometry<2>&,
                                                     const Execution&);
template Outcome<Buffer<LagrangeNode<3>>> slid_nodes(const QuadraticMesh<3>&, const Column<LagrangeNode<3>>&,
                                                     std::span<const Vec<3>>, const Features<3>&, const Geometry<3>&,
                                                     const Execution&);

}  // namespace camber
