module;
#include <array>
#include <cstddef>
#include <vector>
export module camber.remesh:on_geometry;
import camber.core;
import camber.dynamic;
import camber.surface;
import :state;

/// Where points of the boundary belong.
namespace camber {

template <int D>
[[nodiscard]] std::array<Vec<D>, D> corners_of(const DynamicMesh<D>& mesh, FacetId f) {
    std::array<Vec<D>, D> corners;
    for (int i = 0; i < D; ++i) corners[i] = mesh.points[mesh.facets.vertices[f][i]];
    return corners;
}
template <int D>
[[nodiscard]] FacetSite<D> site_of(const DynamicMesh<D>& mesh, FacetId f) {
    return {{}, mesh.facets.references[f], corners_of(mesh, f)};
}

/// Area times normal; 2D: length times normal.
[[nodiscard]] inline Vec<2> facet_normal(const std::array<Vec<2>, 2>& p) {
    return {{p[1][1] - p[0][1], p[0][0] - p[1][0]}};
}
[[nodiscard]] inline Vec<3> facet_normal(const std::array<Vec<3>, 3>& p) { return cross(p[1] - p[0], p[2] - p[0]); }

/// The point of the geometry for p, on or near an edge with these facets; p itself without a geometry, or inside.
template <int D>
[[nodiscard]] Vec<D> on_geometry_at_edge(const RemeshingGoal<D>& goal, const DynamicMesh<D>& mesh, EdgeId edge,
                                         const std::vector<FacetId>& facets, const Vec<D>& p) {
    if (!goal.geometry || facets.empty()) return p;
    EdgeSite<D> site;
    site.kind = mesh.line_at(edge).valid() ? EdgeKind::ridge : EdgeKind::surface;
    for (int i = 0; i < 2; ++i) site.ends[i] = mesh.points[mesh.edges[edge][i]];
    site.facets.reserve(facets.size());
    for (const FacetId f : facets) site.facets.push_back(site_of(mesh, f));
    return (*goal.geometry)->on_edge(site, p).point;
}

/// The point of the surface for p near a facet.
template <int D>
[[nodiscard]] Vec<D> on_geometry_at_facet(const RemeshingGoal<D>& goal, const DynamicMesh<D>& mesh, FacetId f,
                                          const Vec<D>& p) {
    const FacetSite<D> site = site_of(mesh, f);
    SurfaceHint hint;
    hint.reference = site.reference;
    hint.entity = (*goal.geometry)->surface_at(site);
    return (*goal.geometry)->project(hint, p).point;
}

}  // namespace camber
