module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// An edge on the boundary, with what is around it.
template <int D>
struct BoundaryEdge {
    EdgeId id;
    EdgeKind kind = EdgeKind::volume;
    Vec<D> a, b;
    std::span<const FacetId> facets;

    [[nodiscard]] Vec<D> middle() const { return midpoint(a, b); }
};

template <int D>
Vec<D> node_on(const StraightGeometry&, const LinearMesh<D>&, const BoundaryEdge<D>& edge) {
    return edge.middle();
}

template <int D>
bool is_own_edge(const Surrogate<D>& surrogate, std::size_t row, const BoundaryEdge<D>& edge) {
    if (row == surrogate.edges.size()) return false;
    const auto& c = surrogate.edge_curves[row].curve.control;
    return c.front() == edge.a && c.back() == edge.b;
}

template <int D>
Vec<D> node_on(const Surrogate<D>& surrogate, const LinearMesh<D>& mesh, const BoundaryEdge<D>& edge) {
    const std::size_t row = surrogate.row(edge.id);
    if (is_own_edge(surrogate, row, edge)) return surrogate.edge_curves[row].middle;
    const Vec<D> middle = edge.middle();
    if (edge.kind == EdgeKind::ridge) {
        const auto foot = closest_on_ridges(surrogate, middle);
        if (foot.row < surrogate.edges.size()) return foot.point;
    }
    if (edge.facets.empty()) return middle;
    const Reference reference = mesh.facets.references[edge.facets[0]];
    const auto foot = closest_among(surrogate, middle, [&](FacetId f) { return surrogate.references[f] == reference; });
    if (!foot.facet.valid()) return middle;
    const auto& flat = surrogate.flats[surrogate.patches[foot.facet]];
    return flat.is_flat() ? flat.snapped(middle) : foot.point;
}

bool is_plane(const AnalyticSurface<3>& surface) { return std::holds_alternative<Plane<3>>(surface); }

/// The facet's own plane.
Plane<3> plane_through(const LinearMesh<3>& mesh, FacetId f) {
    const auto& [a, b, c] = mesh.facets.vertices[f];
    return {mesh.points[a], cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a])};
}

/// The plane of the surrogate's patch that the facet lies on, where that is flat.
std::optional<Plane<3>> plane_under(const Surrogate<3>& surrogate, const LinearMesh<3>& mesh, FacetId f) {
    const auto& [a, b, c] = mesh.facets.vertices[f];
    const Vec<3> centroid = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
    const auto foot = closest_among(surrogate, centroid,
                                    [&](FacetId of) { return surrogate.references[of] == mesh.facets.references[f]; });
    if (!foot.facet.valid()) return plane_through(mesh, f);
    const auto& flat = surrogate.flats[surrogate.patches[foot.facet]];
    if (!flat.is_flat()) return std::nullopt;
    return Plane<3>{flat.point, flat.normal};
}

/// What is known of the surfaces around an edge.
struct SurfacesAround {
    std::vector<AnalyticSurface<3>> distinct;  ///< those given, and the planes of facets that have none
    bool any = false;                          ///< whether one was given
    bool all = true;                           ///< whether each facet has one or a plane

    void add(const AnalyticSurface<3>& surface) {
        if (std::find(distinct.begin(), distinct.end(), surface) != distinct.end()) return;
        // Curved ones first: among three or more the first two decide.
        distinct.insert(is_plane(surface) ? distinct.end() : distinct.begin(), surface);
    }
};

/// `plane_of(f)`: the plane of a facet without a surface, if it has one.
template <class PlaneOf>
SurfacesAround surfaces_around(const AnalyticGeometry<3>& geometry, const LinearMesh<3>& mesh,
                               const BoundaryEdge<3>& edge, PlaneOf&& plane_of) {
    SurfacesAround around;
    for (const FacetId f : edge.facets) {
        if (const auto* given = surface_of(geometry, mesh.facets.references[f])) {
            around.any = true;
            around.add(*given);
        } else if (const std::optional<Plane<3>> plane = plane_of(f)) {
            around.add(*plane);
        } else {
            around.all = false;
        }
    }
    return around;
}

/// The node of an edge with at least one surface around it.
Vec<3> node_where_they_meet(const std::vector<AnalyticSurface<3>>& surfaces, const Vec<3>& middle) {
    if (surfaces.size() == 1) return closest_point<3>(surfaces[0], middle).point;
    if (is_plane(surfaces[0]) && is_plane(surfaces[1])) return middle;
    const auto met = closest_on_intersection(surfaces[0], surfaces[1], middle);
    // Surfaces that touch rather than cross: the curve is wherever the edge is, on the first of them.
    return met ? *met : closest_point<3>(surfaces[0], middle).point;
}

Vec<3> node_on(const AnalyticGeometry<3>& geometry, const LinearMesh<3>& mesh, const BoundaryEdge<3>& edge) {
    const auto around =
        surfaces_around(geometry, mesh, edge, [&](FacetId f) { return std::optional(plane_through(mesh, f)); });
    return around.any ? node_where_they_meet(around.distinct, edge.middle()) : edge.middle();
}

Vec<2> node_on(const AnalyticGeometry<2>& geometry, const LinearMesh<2>& mesh, const BoundaryEdge<2>& edge) {
    const Vec<2> middle = edge.middle();
    for (const FacetId f : edge.facets)
        if (const auto* surface = surface_of(geometry, mesh.facets.references[f]))
            return closest_point<2>(*surface, middle).point;
    return middle;
}

template <int D>
bool has_surface(const AnalyticGeometry<D>& geometry, const LinearMesh<D>& mesh, const BoundaryEdge<D>& edge) {
    return std::any_of(edge.facets.begin(), edge.facets.end(),
                       [&](FacetId f) { return surface_of(geometry, mesh.facets.references[f]) != nullptr; });
}

Vec<3> node_on(const MixedGeometry<3>& geometry, const LinearMesh<3>& mesh, const BoundaryEdge<3>& edge) {
    const auto& [analytic, surrogate] = geometry;
    if (!has_surface(analytic, mesh, edge)) return node_on(surrogate, mesh, edge);
    const auto around =
        surfaces_around(analytic, mesh, edge, [&](FacetId f) { return plane_under(surrogate, mesh, f); });
    // Beside a curved patch the surrogate knows the ridge along the surface, and the surface where it is across.
    return node_where_they_meet(around.distinct, around.all ? edge.middle() : node_on(surrogate, mesh, edge));
}

Vec<2> node_on(const MixedGeometry<2>& geometry, const LinearMesh<2>& mesh, const BoundaryEdge<2>& edge) {
    return has_surface(geometry.analytic, mesh, edge) ? node_on(geometry.analytic, mesh, edge)
                                                      : node_on(geometry.surrogate, mesh, edge);
}

}  // namespace

template <int D>
Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution) {
    if (features.edge_kinds.size() != mesh.edges.size() || mesh.mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features are not of this mesh");
    const auto shells = facet_shells(mesh.edges, execution);
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        if (features.edge_kinds[e] == EdgeKind::volume) return mesh.mid_nodes[e];
        const auto& [low, high] = mesh.edges.vertices[e];
        const BoundaryEdge<D> edge{EdgeId(e), features.edge_kinds[e], mesh.linear.points[low], mesh.linear.points[high],
                                   (*shells)[e]};
        if (required[e] != 0) return mesh.mid_nodes[e];
        return {std::visit([&](const auto& g) { return node_on(g, mesh.linear, edge); }, geometry)};
    });
}

template Outcome<Buffer<LagrangeNode<2>>> boundary_nodes(const QuadraticMesh<2>&, const Features<2>&,
                                                         const Geometry<2>&, const Execution&);
template Outcome<Buffer<LagrangeNode<3>>> boundary_nodes(const QuadraticMesh<3>&, const Features<3>&,
                                                         const Geometry<3>&, const Execution&);

}  // namespace camber
