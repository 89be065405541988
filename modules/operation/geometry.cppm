// Projection to the geometry, distances from it, crossing checks, and minimum heights of elements.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.operation:geometry;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.crossing;
import camber.surface;
import :state;

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

/// Normal vector, with twice the facet's area as its length (2D: the facet's length).
[[nodiscard]] inline Vec<2> facet_normal(const std::array<Vec<2>, 2>& p) {
    return {{p[1][1] - p[0][1], p[0][0] - p[1][0]}};
}
[[nodiscard]] inline Vec<3> facet_normal(const std::array<Vec<3>, 3>& p) { return cross(p[1] - p[0], p[2] - p[0]); }

/// Projects `p` to the curve of an embedded line and then, if the edge has facets, to their surface.
template <int D>
[[nodiscard]] SurfacePoint<D> on_embedded_curve(const AdaptationGoal<D>& goal, EdgeSite<D> site, Reference reference,
                                                const Vec<D>& p) {
    const Vec<D> near = closest_on_curves(goal.curves, reference, p).value_or(p);
    if (!goal.geometry || site.facets.empty()) return {.point = near, .normal = {}};
    site.kind = EdgeKind::surface;
    return (*goal.geometry)->on_edge(site, near);
}

/// Projects `p`, a point near the edge, to the geometry or, for an embedded line, to its curve. Returns `p` for inner
/// edges and without a geometry.
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

/// Projects `p`, a point near the facet, to the geometry. `known`: the geometric entity of a vertex of the facet, if
/// known.
template <int D>
[[nodiscard]] SurfacePoint<D> on_geometry_at_facet(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh, FacetId f,
                                                   const GeometryEntity& known, const Vec<D>& p) {
    const FacetSite<D> site = site_of(mesh, f);
    SurfaceHint hint;
    hint.reference = site.reference;
    hint.entity = known.kind == GeometryKind::surface ? known : (*goal.geometry)->surface_at(site);
    return (*goal.geometry)->project(hint, p);
}

/// Projects a boundary vertex to the geometry. `around`: all elements at the vertex. `known`: its geometric entity, if
/// known. Empty if the geometry has no entity for the vertex.
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

/// Geometric entity of a vertex after it moved by `share` of its way to the projection `foot`. Includes parameters only
/// if `share` is 1.
template <int D>
[[nodiscard]] GeometryPosition place_after(double share, const SurfacePoint<D>& foot) {
    return share == 1 ? place_of(foot) : GeometryPosition{foot.entity};
}

template <int D>
[[nodiscard]] bool is_at_foot(const DynamicMesh<D>& mesh, const Cavity<D>& around, const Vec<D>& here,
                              const Vec<D>& foot) {
    constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    constexpr double tolerance = 1e-9;  // accuracy of projections, relative to a facet edge
    const auto& [a, b] = around.facets.empty() ? mesh.edges[mesh.lines[around.lines.front()]]
                                               : std::array{mesh.facets.vertices[around.facets.front()][0],
                                                            mesh.facets.vertices[around.facets.front()][1]};
    double largest = 0;
    for (const double x : here.c) largest = std::max(largest, std::abs(x));
    return norm(foot - here) <= tolerance * norm(mesh.points[b] - mesh.points[a]) + rounding * largest;
}

/// Largest distance of facets from the geometry, sampled at the middles of facets and edges, relative to each facet's
/// longest edge. `is_near`: the distance does not exceed the limit.
struct FacetDistance {
    double largest = 0;
    bool is_near = true;
};

/// Distance of the patch's new facets from the geometry; 0 without a geometry. The limit, relative to a facet's longest
/// edge, is `share` or, if larger, the distance of the farthest removed facet. Edges on embedded lines are checked in
/// the same way against their curves.
template <int D>
[[nodiscard]] FacetDistance distance_from_geometry(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                   const Patch<D>& patch, double share);

/// Distances of a facet from its surface, divided by the facet's bounds (`distance_bounds`). Curved edges have two
/// samples each, where the error of a parabola is largest. All values are 0 if the facet has no surface or no bound.
template <int D>
struct BoundShares {
    std::array<double, edges_per_simplex<D - 1>> edges{};
    double middle = 0;

    [[nodiscard]] double largest() const { return std::max(middle, *std::ranges::max_element(edges)); }
};
template <int D>
[[nodiscard]] BoundShares<D> bound_shares(const Adaptation<D>& r, const AdaptationGoal<D>& goal, FacetId f);

/// The edge of the mesh that has index `e` in `BoundShares::edges`. Precondition: the facet has an element.
template <int D>
[[nodiscard]] EdgeId local_facet_edge(const DynamicMesh<D>& mesh, FacetId f, int e);

template <int D>
[[nodiscard]] bool meets_distance_bounds(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch);

}  // namespace camber

namespace camber {

// Minimum heights of elements.

template <int D>
[[nodiscard]] double largest_face(const std::array<Vec<D>, D + 1>& corners) {
    double largest = 0;
    for (int face = 0; face <= D; ++face) {
        const auto local = face_opposite<D>(face);
        std::array<Vec<D>, D> q;
        for (int i = 0; i < D; ++i) q[i] = corners[local[i]];
        largest = std::max(largest, norm_squared(facet_normal(q)));
    }
    return std::sqrt(largest);
}

template <int D, std::size_t N>
[[nodiscard]] double rounding_of(const std::array<Vec<D>, N>& corners) {
    constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    double largest = 0;
    for (const Vec<D>& x : corners)
        for (const double c : x.c) largest = std::max(largest, std::abs(c));
    return rounding * largest;
}

/// Rounding bound of an element's determinant. At or below the bound, rounded coordinates do not determine on which
/// side of a face the opposite vertex lies.
template <int D>
[[nodiscard]] double rounding_floor(const std::array<Vec<D>, D + 1>& corners) {
    return rounding_of(corners) * largest_face<D>(corners);
}

/// True if the determinant exceeds `rounding_floor`. A cheaper test with a larger bound is tried first.
template <int D>
[[nodiscard]] bool is_above_rounding(double determinant, const std::array<Vec<D>, D + 1>& corners) {
    Vec<D> low = corners[0], high = corners[0];
    for (int i = 1; i <= D; ++i)
        for (int c = 0; c < D; ++c) {
            low[c] = std::min(low[c], corners[i][c]);
            high[c] = std::max(high[c], corners[i][c]);
        }
    const double square = norm_squared(high - low);
    return determinant > rounding_of(std::array{low, high}) * (D == 2 ? std::sqrt(square) : square) ||
           determinant > rounding_floor<D>(corners);
}

[[nodiscard]] inline bool is_flat(const std::array<Vec<3>, 3>& corners) {
    double longest = 0;
    for (const auto& [a, b] : local_edges<2>) longest = std::max(longest, distance(corners[a], corners[b]));
    return !(norm(facet_normal(corners)) > rounding_of(corners) * longest);
}

// Facets with their edge nodes; in a straight mesh, these nodes are chord middles.

[[nodiscard]] inline EdgeId edge_of_facet(const DynamicMesh<2>& mesh, FacetId f) {
    const ElementId e = mesh.sides[f][0];
    const auto& [a, b] = mesh.facets.vertices[f];
    const auto& vertices = mesh.elements.vertices[e];
    return mesh.edges_of[e][edge_between<2>[local_vertex(vertices, a)][local_vertex(vertices, b)]];
}

template <int D>
[[nodiscard]] NodalFacet<D> nodal_facet(const DynamicMesh<D>& mesh, FacetId f) {
    NodalFacet<D> facet = straight_facet<D>(corners_of(mesh, f));
    if (!mesh.is_curved() || !mesh.sides[f][0].valid()) return facet;
    if constexpr (D == 3) {
        for (int k = 0; k < 3; ++k) facet.nodes[3 + (k + 1) % 3] = mesh.nodes[facet_edge(mesh, f, k)].point;
    } else {
        facet.nodes[2] = mesh.nodes[edge_of_facet(mesh, f)].point;
    }
    return facet;
}

/// The new facet: a removed facet with the patch's point at `place` instead of vertex `joined.opposite`.
template <int D>
[[nodiscard]] NodalFacet<D> nodal_facet(const DynamicMesh<D>& mesh, const Patch<D>& patch, const JoinedFacet& joined,
                                        const Vec<D>& place) {
    const int opposite = static_cast<int>(joined.opposite);
    auto corners = corners_of(mesh, joined.facet);
    corners[opposite] = place;
    NodalFacet<D> facet = straight_facet<D>(corners);
    if (!mesh.is_curved()) return facet;
    const auto node_to = [&](int corner) {
        const VertexId v = mesh.facets.vertices[joined.facet][corner];
        const auto at = std::ranges::find(patch.star.boundary, v) - patch.star.boundary.begin();
        return patch.nodes[static_cast<std::size_t>(at)].point;
    };
    if constexpr (D == 3) {
        // Edge k of `local_edges` is opposite corner (k + 2) mod 3.
        for (int k = 0; k < 3; ++k) {
            const int without = (k + 2) % 3;
            facet.nodes[3 + k] = without == opposite ? mesh.nodes[facet_edge(mesh, joined.facet, opposite)].point
                                                     : node_to(3 - opposite - without);
        }
    } else {
        facet.nodes[2] = node_to(1 - opposite);
    }
    return facet;
}

template <int D>
[[nodiscard]] Vec<D> place_of_point(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    return patch.point.place ? *patch.point.place : mesh.points[patch.point.vertex];
}

// Crossing checks of the boundary. They are necessary because facets can cross although volumes or Jacobians are
// positive.

template <int D>
void update_facet_grid(FacetGrid<D>& walls, const DynamicMesh<D>& mesh, const IdChanges<FacetId>& facets);

template <int D>
[[nodiscard]] std::vector<NodalFacet<D>> new_facets(const DynamicMesh<D>& mesh, const Patch<D>& patch);

/// True if removed and new facets lie in axis-parallel planes through the patch's point, and removed and new lines on
/// axis-parallel lines through it. If the elements are valid, the new facets then cross no facet:
/// - In its plane, each facet has positive area. So the facets cover a point as often as their border winds around it.
/// - The border does not change. So the new facets cover the same points as the removed facets, without overlap.
template <int D>
[[nodiscard]] bool preserves_planes(const DynamicMesh<D>& mesh, const Patch<D>& patch,
                                    std::span<const NodalFacet<D>> added_facets);

/// True if the new facets cross neither each other nor other facets. Curved facets must be proved disjoint and free of
/// self-crossings. Straight facets may touch.
template <int D>
[[nodiscard]] bool are_facets_clear(const Adaptation<D>& r, const Patch<D>& patch,
                                    std::span<const NodalFacet<D>> added_facets);

/// Collects new facets of patches that were planned independently, to find crossings between the patches.
template <int D>
class NewFacets {
  public:
    void clear();
    /// Adds a patch's facets, which passed `are_facets_clear` or `preserves_planes`. Returns false if they cross facets
    /// of a patch added before.
    [[nodiscard]] bool take(const DynamicMesh<D>& mesh, const Patch<D>& patch);

  private:
    FacetGrid<D> grid_;
    std::vector<NodalFacet<D>> facets_;
    std::vector<FacetId> near_;
};

}  // namespace camber

export namespace camber {

// A two-facet element has two facets on one smooth surface. If these facets are small, the element is almost flat. If
// the surface is curved, the element then folds for all positions of its edge nodes.

template <int D>
[[nodiscard]] bool is_two_facet_element(const DynamicMesh<D>& mesh, ElementId e);

/// True if a patch increases the number of two-facet elements. False without a geometry, and if all facets at the point
/// lie in planes.
template <int D>
[[nodiscard]] bool adds_two_facet_elements(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                           const Patch<D>& patch);

}  // namespace camber
