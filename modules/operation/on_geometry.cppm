module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>
export module camber.operation:on_geometry;
import camber.core;
import camber.cavity;
import camber.surface;
import :state;

/// Where points of the boundary belong.
export namespace camber {

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

/// The point of an embedded curve next to p, on the surface of the edge's facets, if it has one.
template <int D>
[[nodiscard]] SurfacePoint<D> on_embedded_curve(const AdaptationGoal<D>& goal, EdgeSite<D> site, Reference reference,
                                                const Vec<D>& p) {
    const Vec<D> near = closest_on_curves(goal.curves, reference, p).value_or(p);
    if (!goal.geometry || site.facets.empty()) return {.point = near, .normal = {}};
    site.kind = EdgeKind::surface;
    return (*goal.geometry)->on_edge(site, near);
}

/// The point of the geometry for p, on or near an edge with these facets; p itself without a geometry, or inside. On an
/// embedded line that of its curve.
template <int D>
[[nodiscard]] SurfacePoint<D> on_geometry_at_edge(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh,
                                                  EdgeId edge, const std::vector<FacetId>& facets, const Vec<D>& p) {
    const LineId line = mesh.line_at(edge);
    EdgeSite<D> site;
    site.kind = line.valid() ? EdgeKind::ridge : EdgeKind::surface;
    for (int i = 0; i < 2; ++i) site.ends[i] = mesh.points[mesh.edges[edge][i]];
    site.facets.reserve(facets.size());
    for (const FacetId f : facets)
        if (!mesh.is_at_infinity(f)) site.facets.push_back(site_of(mesh, f));
    if (mesh.is_embedded(line)) return on_embedded_curve(goal, std::move(site), mesh.line_references[line], p);
    if (!goal.geometry || facets.empty()) return {.point = p, .normal = {}};
    return (*goal.geometry)->on_edge(site, p);
}

/// The point of the surface for p near a facet; `known`: what a vertex of the facet lies on, if that is known.
template <int D>
[[nodiscard]] SurfacePoint<D> on_geometry_at_facet(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh, FacetId f,
                                                   const GeometryEntity& known, const Vec<D>& p) {
    const FacetSite<D> site = site_of(mesh, f);
    SurfaceHint hint;
    hint.reference = site.reference;
    hint.entity = known.kind == GeometryKind::surface ? known : (*goal.geometry)->surface_at(site);
    return (*goal.geometry)->project(hint, p);
}

/// The geometry's point for a vertex of a surface or a line, with its whole ball: nothing where it has none there.
/// `known`: what it lies on, if that is known.
template <int D>
[[nodiscard]] std::optional<SurfacePoint<D>> foot_of(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh,
                                                     const Cavity<D>& around, VertexId v, const GeometryEntity& known) {
    if (!goal.geometry) return {};
    const Vec<D> here = mesh.points[v];
    if constexpr (D == 3)
        if (mesh.states[v].place == VertexPlace::line) {
            if (around.lines.empty()) return {};
            const EdgeId edge = mesh.lines[around.lines.front()];
            if (around.facets.empty() && !mesh.is_embedded(around.lines.front())) return {};
            std::vector<FacetId> facets;
            facets_with(mesh, around.elements, edge, facets);
            return on_geometry_at_edge(goal, mesh, edge, facets, here);
        }
    if (around.facets.empty()) return {};
    const FacetId f = around.facets.front();
    if (!(*goal.geometry)->has_surface_at(site_of(mesh, f))) return {};
    return on_geometry_at_facet(goal, mesh, f, known, here);
}

/// Where a point is that went this share of its way foot: short of it, it has no parameters.
template <int D>
[[nodiscard]] GeometryPlace place_after(double share, const SurfacePoint<D>& foot) {
    return share == 1 ? place_of(foot) : GeometryPlace{foot.entity};
}

/// Whether a point is at its foot, but for rounding and what projections leave.
template <int D>
[[nodiscard]] bool is_at_foot(const DynamicMesh<D>& mesh, const Cavity<D>& around, const Vec<D>& here,
                              const Vec<D>& foot) {
    constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    constexpr double tolerance = 1e-9;  // of the size of facets: projections are so to rounding
    const auto& [a, b] = around.facets.empty() ? mesh.edges[mesh.lines[around.lines.front()]]
                                               : std::array{mesh.facets.vertices[around.facets.front()][0],
                                                            mesh.facets.vertices[around.facets.front()][1]};
    double largest = 0;
    for (const double x : here.c) largest = std::max(largest, std::abs(x));
    return norm(foot - here) <= tolerance * norm(mesh.points[b] - mesh.points[a]) + rounding * largest;
}

}  // namespace camber
