// Extends the displacement of boundary curves over smooth boundary faces.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.surface;

namespace camber {

namespace {

/// Two surfaces form one face if the sine of the angle between their normals is below this limit.
constexpr double smooth_sine = 0.05;

constexpr double on_surface = 1e-9;

/// The nearest surface point counts as perpendicularly above a chord's middle if the tangential part of the vector
/// between them is at most this fraction of its length.
constexpr double largest_slope = 1e-6;

template <int D>
Outcome<Buffer<std::uint8_t>> facets_with_surface(const LinearMesh<D>& mesh, const Features<D>& features,
                                                  const Geometry<D>& geometry, const Execution& execution) {
    const auto flat = flat_patches(mesh, features, without_progress(execution));
    if (!flat) return fail(flat.error());
    return map_each(execution, mesh.facets.size(), [&](std::size_t f) -> std::uint8_t {
        return (*flat)[features.patches[f]].is_flat() || geometry->has_surface_at(facet_site(mesh, FacetId(f))) ? 1 : 0;
    });
}

class SmoothFaces {
  public:
    SmoothFaces(const QuadraticMesh<3>& mesh, const Column<EdgeKind>& kinds, const Features<3>& features,
                const Geometry<3>& geometry)
        : mesh_(mesh), kinds_(kinds), features_(features), geometry_(geometry) {}

    [[nodiscard]] Outcome<Faces> find(const Execution& execution) {
        auto around = facet_shells(mesh_.edges, without_progress(execution));
        if (!around) return fail(around.error());
        shells_ = std::move(*around);
        auto with_surface = facets_with_surface(mesh_.linear, features_, geometry_, execution);
        if (!with_surface) return fail(with_surface.error());
        facets_ = *with_surface;
        auto inside = map_each(execution, mesh_.edges.size(),
                               [&](std::size_t e) -> std::uint8_t { return is_inside(EdgeId(e)) ? 1 : 0; });
        if (!inside) return fail(inside.error());
        return Faces{std::move(*with_surface), std::move(*inside)};
    }

    [[nodiscard]] SurfaceFoot<3> foot(const FacetSite<3>& facet, const Vec<3>& p) const {
        if (const auto plane = geometry_->plane_at(facet)) {
            const Vec<3> n = normalised(plane->normal);
            return {p - dot(p - plane->point, n) * n, n};
        }
        // If the geometry has no piece for the facet, the whole surface is searched, since p may be many layers away
        // from the facet.
        const auto found = geometry_->project(geometry_->hint_at(facet, geometry_->surface_at(facet)), p);
        return {found.point, found.normal};
    }
    /// Returns the node of an edge on the surface of one facet. If the surface was built from facets, this is the
    /// middle of the edge on the facet's piece. Otherwise it is the surface point nearest to the chord's middle. On the
    /// boundary of a trimmed face, this point is moved in its tangent plane until it is perpendicularly above the
    /// middle.
    [[nodiscard]] Vec<3> node_on(FacetId f, EdgeId e) const {
        const FacetSite<3> facet = facet_site(mesh_.linear, f);
        if (geometry_->is_built_from(facet)) return middle_of_piece(facet, e);
        const auto& [low, high] = mesh_.edges.vertices[e];
        const Vec<3>& a = mesh_.linear.points[low];
        const Vec<3>& b = mesh_.linear.points[high];
        const Vec<3> middle = midpoint(a, b);
        const SurfaceFoot<3> at = foot(facet, middle);
        const Vec<3> bow = at.point - middle, sideways = bow - dot(bow, at.normal) * at.normal;
        return norm(sideways) > largest_slope * norm(bow) + on_surface * distance(a, b) ? at.point - sideways
                                                                                        : at.point;
    }

    /// Moves the edge's node on the surface by `shift` and projects it again. Nodes off the geometry on purpose
    /// (`node_without_cusp`) keep their distance.
    [[nodiscard]] Vec<3> moved(EdgeId e, const Vec<3>& node, const Vec<3>& shift) const {
        const EdgeSite<3> site = site_of(e);
        const FacetSite<3>& facet = site.facets.front();
        const Vec<3> start = node_on(facet.id, e);
        if (const auto plane = common_plane(*geometry_, site)) return slid_within(*plane, start, shift);
        const auto projected = [&](const Vec<3>& p) {
            return kinds_[e] == EdgeKind::ridge ? geometry_->on_edge(site, p).point : foot(facet, p).point;
        };
        Vec<3> off = node - projected(node);
        if (norm(off) <= on_surface * distance(site.ends[0], site.ends[1])) off = {};
        return projected(start + shift) + off;
    }

  private:
    [[nodiscard]] EdgeSite<3> site_of(EdgeId e) const {
        const auto& [low, high] = mesh_.edges.vertices[e];
        EdgeSite<3> site{e, kinds_[e], {mesh_.linear.points[low], mesh_.linear.points[high]}, {}};
        for (const FacetId f : shells_[e])
            if (has_surface(f)) site.facets.push_back(facet_site(mesh_.linear, f));
        return site;
    }

    [[nodiscard]] Vec<3> middle_of_piece(const FacetSite<3>& facet, EdgeId e) const {
        const auto& vertices = mesh_.linear.facets.vertices[facet.id];
        const auto& ends = mesh_.edges.vertices[e];
        std::array<Barycentric<2>, 1> at{};
        for (std::size_t i = 0; i < 3; ++i) at[0][i] = vertices[i] == ends[0] || vertices[i] == ends[1] ? 0.5 : 0;
        std::array<Vec<3>, 1> point{};
        const auto& [a, b] = ends;
        return geometry_->surface_points(facet, at, point) ? point[0]
                                                           : midpoint(mesh_.linear.points[a], mesh_.linear.points[b]);
    }
    [[nodiscard]] bool has_surface(FacetId f) const { return facets_[f.index()] != 0; }
    [[nodiscard]] bool is_inside(EdgeId e) const {
        if (kinds_[e] == EdgeKind::volume) return false;
        if (std::ranges::none_of(shells_[e], [&](FacetId f) { return has_surface(f); })) return false;
        if (kinds_[e] == EdgeKind::surface) return true;
        // If the user listed a curve inside a face, its nodes are fixed.
        const bool is_ridge = kinds_[e] == EdgeKind::ridge && features_.edge_kinds[e] == EdgeKind::ridge;
        return is_ridge && is_smooth(site_of(e), shells_[e].size());
    }

    /// Returns true if a ridge edge of the mesh is not on a sharp curve of the geometry.
    [[nodiscard]] bool is_smooth(const EdgeSite<3>& site, std::size_t facets) const {
        if (facets != 2) return false;
        if (site.facets.size() == 1) return true;
        const GeometryEntity entity = geometry_->entity_at_edge(site);
        if (entity.kind == GeometryKind::surface) return true;
        if (entity.kind != GeometryKind::curve || entity.id != GeometryEntity::unnumbered) return false;
        const Vec<3> one = foot(site.facets[0], site.middle()).normal,
                     other = foot(site.facets[1], site.middle()).normal;
        return norm(cross(one, other)) < smooth_sine && norm(one) > 0 && norm(other) > 0;
    }

    const QuadraticMesh<3>& mesh_;
    const Column<EdgeKind>& kinds_;
    const Features<3>& features_;
    const Geometry<3>& geometry_;
    Incidence<FacetId> shells_ = {};
    Buffer<std::uint8_t> facets_ = {};
};

Outcome<Column<LagrangeNode<3>>> nodes_of_faces(const QuadraticMesh<3>& mesh, const Column<EdgeKind>& kinds,
                                                const Column<LagrangeNode<3>>& boundary_nodes,
                                                const Features<3>& features, const Geometry<3>& geometry,
                                                const Execution& execution) {
    SmoothFaces faces(mesh, kinds, features, geometry);
    auto found = faces.find(without_progress(execution));
    if (!found) return fail(found.error());
    const auto input = [&](FacetId f, EdgeId e) { return boundary_nodes[e].point - faces.node_on(f, e); };
    const auto extended = extend_over_triangles(mesh.linear, mesh.edges, *found, input, execution);
    if (!extended) return fail(extended.error());
    if (extended->edges.empty()) return boundary_nodes;
    Buffer<LagrangeNode<3>> nodes(boundary_nodes.begin(), boundary_nodes.end());
    auto done = each(execution, extended->edges.size(), [&](std::size_t i) {
        const EdgeId e = extended->edges[i];
        nodes[e.index()].point = faces.moved(e, boundary_nodes[e].point, extended->shifts[i]);
    });
    if (!done) return fail(done.error());
    return Column<LagrangeNode<3>>(std::move(nodes));
}

}  // namespace

template <int D>
Outcome<Column<LagrangeNode<D>>> extend_over_faces(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                   const Column<LagrangeNode<D>>& boundary_nodes,
                                                   const Features<D>& features, const Geometry<D>& geometry,
                                                   const Execution& execution) {
    if constexpr (D == 2)
        return boundary_nodes;
    else
        return guarded([&] { return nodes_of_faces(mesh, kinds, boundary_nodes, features, geometry, execution); });
}

template <int D>
Outcome<Column<EdgeKind>> kinds_with_following(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                               const Features<D>& features, const Geometry<D>& geometry,
                                               const Execution& execution) {
    const auto with_surface = facets_with_surface(mesh.linear, features, geometry, execution);
    if (!with_surface) return fail(with_surface.error());
    if (std::ranges::all_of(*with_surface, [](std::uint8_t has) { return has != 0; })) return kinds;
    const auto around = facet_shells(mesh.edges, without_progress(execution));
    if (!around) return fail(around.error());
    Buffer<EdgeKind> free(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < free.size(); ++e) {
        const bool is_fixed = free[e] == EdgeKind::volume || free[e] == EdgeKind::fixed;
        const auto has = [&](FacetId f) { return (*with_surface)[f.index()] != 0; };
        if (!is_fixed && std::ranges::none_of((*around)[e], has)) free[e] = EdgeKind::volume;
    }
    return Column<EdgeKind>(std::move(free));
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Column<LagrangeNode<D>>> extend_over_faces<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,   \
                                                                   const Column<LagrangeNode<D>>&, const Features<D>&, \
                                                                   const Geometry<D>&, const Execution&);              \
    template Outcome<Column<EdgeKind>> kinds_with_following<D>(                                                        \
        const QuadraticMesh<D>&, const Column<EdgeKind>&, const Features<D>&, const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
