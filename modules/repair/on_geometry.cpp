module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.repair;
import :guide;
import :on_geometry;
import camber.core;
import camber.bezier;
import camber.surface;
import camber.validity;

namespace camber {

namespace {

/// The edges of a boundary, as a geometry is asked for them.
template <int D>
struct Sites {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;
    Incidence<FacetId> facets;

    [[nodiscard]] EdgeSite<D> operator[](EdgeId edge) const {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return {edge,
                kinds[edge],
                {mesh.linear.points[a], mesh.linear.points[b]},
                facet_sites<D>(mesh.linear, facets[edge])};
    }
    [[nodiscard]] bool is_prescribed(EdgeId edge, const Geometry<D>& geometry) const {
        return kinds[edge] != EdgeKind::volume && std::ranges::all_of(facets[edge], [&](FacetId f) {
                   return geometry->prescribes(mesh.linear.facets.references[f]);
               });
    }
};

template <int D>
Sym<D> outer(const Vec<D>& v) {
    Sym<D> s;
    for (int i = 0; i < D; ++i)
        for (int j = i; j < D; ++j) s(i, j) = v[i] * v[j];
    return s;
}

/// The unit tangent of the curve that a point lies on; by the chord where the geometry does not tell it.
template <int D>
Vec<D> tangent_at(const Geometry<D>& geometry, const SurfacePoint<D>& foot, const EdgeSite<D>& site) {
    if (foot.parameters)
        if (const auto there = geometry->evaluate(foot.entity, *foot.parameters); there && norm(there->tangents[0]) > 0)
            return normalised(there->tangents[0]);
    return normalised(site.ends[1] - site.ends[0]);
}

}  // namespace

namespace {

template <int D>
GeometryFoot<D> foot_on(const Geometry<D>& geometry, const EdgeSite<D>& site, const Vec<D>& p) {
    const SurfacePoint<D> foot = geometry->on_edge(site, p);
    if (norm(foot.normal) > 0) return {foot.point, outer<D>(foot.normal)};
    return {foot.point, Sym<D>::identity() - outer<D>(tangent_at(geometry, foot, site))};
}

/// Feet of the edges that are chosen: is_chosen(sites, edge).
template <int D>
Outcome<FootOnGeometry<D>> feet_of(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                   const QuadraticMesh<D>& mesh, const Execution& execution, const auto& is_chosen) {
    auto facets = facet_shells(mesh.edges, execution);
    if (!facets) return fail(facets.error());
    return FootOnGeometry<D>([geometry, is_chosen, sites = Sites<D>{mesh, boundary_kinds, std::move(*facets)}](
                                 EdgeId edge, const Vec<D>& p) {
        if (!is_chosen(sites, edge)) return GeometryFoot<D>{p, Sym<D>::identity()};
        return foot_on(geometry, sites[edge], p);
    });
}

}  // namespace

template <int D>
Outcome<FootOnGeometry<D>> feet_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                   const QuadraticMesh<D>& mesh, const Execution& execution) {
    return feet_of(geometry, boundary_kinds, mesh, execution,
                   [geometry](const Sites<D>& sites, EdgeId edge) { return sites.is_prescribed(edge, geometry); });
}

template <int D>
Outcome<FootOnGeometry<D>> feet_on_any(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                       const QuadraticMesh<D>& mesh, const Execution& execution) {
    return feet_of(geometry, boundary_kinds, mesh, execution, [](const Sites<D>& sites, EdgeId edge) {
        return sites.kinds[edge] == EdgeKind::surface || sites.kinds[edge] == EdgeKind::ridge;
    });
}

namespace {

/// Boundary edges by the vertices at their ends.
using EdgesAtVertices = std::vector<std::pair<VertexId, EdgeId>>;

template <int D>
EdgesAtVertices edges_at_vertices(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds) {
    EdgesAtVertices all;
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume)
            for (const VertexId v : mesh.edges.vertices[e]) all.emplace_back(v, EdgeId(e));
    std::ranges::sort(all);
    return all;
}

/// An edge that lies on what its vertex slides on; none where it does not slide.
template <int D>
std::optional<EdgeId> edge_to_follow(const Geometry<D>& geometry, const Sites<D>& sites, const EdgesAtVertices& edges,
                                     VertexKind kind, VertexId v) {
    if (kind != VertexKind::surface && kind != VertexKind::ridge) return {};
    const EdgeKind followed = kind == VertexKind::ridge ? EdgeKind::ridge : EdgeKind::surface;
    std::optional<EdgeId> found;
    GeometryEntity entity;
    for (const auto& [vertex, edge] : std::ranges::equal_range(edges, v, {}, &EdgesAtVertices::value_type::first)) {
        if (!sites.is_prescribed(edge, geometry)) return {};
        if (sites.kinds[edge] != followed) continue;
        const GeometryEntity there = geometry->entity_at_edge(sites[edge]);
        if (there.kind == GeometryKind::none || (found && there != entity)) return {};
        found = edge;
        entity = there;
    }
    return found;
}

}  // namespace

template <int D>
Outcome<VertexOnGeometry<D>> vertex_feet_on(const Geometry<D>& geometry, const Features<D>& features,
                                            const QuadraticMesh<D>& mesh, const Execution& execution) {
    auto facets = facet_shells(mesh.edges, execution);
    if (!facets) return fail(facets.error());
    return VertexOnGeometry<D>([geometry, kinds = features.vertex_kinds,
                                sites = Sites<D>{mesh, features.edge_kinds, std::move(*facets)},
                                edges = edges_at_vertices(mesh, features.edge_kinds)](VertexId v, const Vec<D>& p) {
        const auto edge = edge_to_follow(geometry, sites, edges, kinds[v], v);
        return edge ? foot_on(geometry, sites[*edge], p) : GeometryFoot<D>{p, Sym<D>::identity()};
    });
}

template <int D>
Outcome<Column<LagrangeNode<D>>> own_nodes_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                              const QuadraticMesh<D>& mesh, RequiredBoundary required,
                                              const Execution& execution) {
    auto facets = facet_shells(mesh.edges, without_progress(execution));
    if (!facets) return fail(facets.error());
    const Sites<D> sites{mesh, boundary_kinds, std::move(*facets)};
    const Column<EdgeKind> kinds = held_kinds(mesh, boundary_kinds, required);
    auto nodes = map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        const EdgeId edge(e);
        if (kinds[e] == EdgeKind::fixed || !sites.is_prescribed(edge, geometry)) return mesh.mid_nodes[e];
        return {geometry->on_edge(sites[edge], mesh.mid_nodes[e].point).point};
    });
    if (!nodes) return fail(nodes.error());
    return Column<LagrangeNode<D>>(std::move(*nodes));
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<FootOnGeometry<D>> feet_on<D>(const Geometry<D>&, const Column<EdgeKind>&,         \
                                                   const QuadraticMesh<D>&, const Execution&);          \
    template Outcome<FootOnGeometry<D>> feet_on_any<D>(const Geometry<D>&, const Column<EdgeKind>&,     \
                                                       const QuadraticMesh<D>&, const Execution&);      \
    template Outcome<VertexOnGeometry<D>> vertex_feet_on<D>(const Geometry<D>&, const Features<D>&,     \
                                                            const QuadraticMesh<D>&, const Execution&); \
    template Outcome<Column<LagrangeNode<D>>> own_nodes_on<D>(                                          \
        const Geometry<D>&, const Column<EdgeKind>&, const QuadraticMesh<D>&, RequiredBoundary, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
