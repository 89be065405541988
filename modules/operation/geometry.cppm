// Points and facets on the geometry, distances from it, walls, minimum heights.
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

/// How far facets are from the geometry, as the largest share of the longest edge of one: at its middle and those of
/// its edges. `is_near`: none farther than it may be.
struct FacetDistance {
    double largest = 0;
    bool is_near = true;
};

/// Of the new facets of a patch, of which none may be farther than `share`, or than the facets that the patch removes
/// were of theirs; likewise its new edges on embedded lines from their curves. 0 where there is no geometry.
template <int D>
[[nodiscard]] FacetDistance distance_from_geometry(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                   const Patch<D>& patch, double share);

/// The distances of a facet from its surface, at its edges and at its middle, as shares of the goal's bound for it
/// (`distance_bounds`): above 1 the facet is too far. Of degree 2 an edge is sampled at two points, where the error of
/// a parabola is largest. 0 where the facet has no surface or no bound.
template <int D>
struct BoundShares {
    std::array<double, edges_per_simplex<D - 1>> edges{};  ///< in the order of local_edges
    double middle = 0;

    [[nodiscard]] double largest() const { return std::max(middle, *std::ranges::max_element(edges)); }
};
template <int D>
[[nodiscard]] BoundShares<D> bound_shares(const Adaptation<D>& r, const AdaptationGoal<D>& goal, FacetId f);

/// The edge of a facet that its shares have at this place; the facet has an element.
template <int D>
[[nodiscard]] EdgeId local_facet_edge(const DynamicMesh<D>& mesh, FacetId f, int e);

/// Whether the new facets of a patch keep the goal's bounds, or exceed them by no more than those that it removes.
template <int D>
[[nodiscard]] bool keeps_distance_bounds(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch);

}  // namespace camber

namespace camber {

// How low an element may be.

/// (D − 1)! times the largest face's area (2D: the longest side).
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

/// 32 roundings of the largest coordinate: what is not higher than that may be on either side.
template <int D, std::size_t N>
[[nodiscard]] double rounding_of(const std::array<Vec<D>, N>& corners) {
    constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    double largest = 0;
    for (const Vec<D>& x : corners)
        for (const double c : x.c) largest = std::max(largest, std::abs(c));
    return rounding * largest;
}

/// A determinant that is not above this is that of an element so low that coordinates, which are known to their
/// rounding only, do not tell on which side its vertices are: height by the largest face.
template <int D>
[[nodiscard]] double rounding_floor(const std::array<Vec<D>, D + 1>& corners) {
    return rounding_of(corners) * largest_face<D>(corners);
}

/// Whether a determinant is above that. Most are above what no face exceeds, the square (2D: length) of the diagonal of
/// the corners' box, and none is looked at.
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

/// The same of a triangle in space.
[[nodiscard]] inline bool is_flat(const std::array<Vec<3>, 3>& corners) {
    double longest = 0;
    for (const auto& [a, b] : local_edges<2>) longest = std::max(longest, distance(corners[a], corners[b]));
    return !(norm(facet_normal(corners)) > rounding_of(corners) * longest);
}

// Facets of meshes that change, with the nodes of their edges; of a straight mesh the middles of chords.

/// The edge of a 2D mesh that a facet is.
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

/// The one that a patch makes of a side of a removed one. `place`: of the patch's point.
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
        // Edge k of local_edges is the one opposite corner k + 2.
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

// Walls do not come to cross each other: neither positive volumes nor positive Jacobians of elements exclude it.

/// Updates the boxes of facets after a commit.
template <int D>
void follow_walls(FacetGrid<D>& walls, const DynamicMesh<D>& mesh, const IdChanges<FacetId>& facets);

/// The facets that a patch would make; of a surface alone its triangles.
template <int D>
[[nodiscard]] std::vector<NodalFacet<D>> new_facets(const DynamicMesh<D>& mesh, const Patch<D>& patch);

/// True if every facet that a patch removes or makes lies in a plane of coordinates through its point, and every line
/// on such an axis: in one plane, or in those on both sides of a ridge. Valid elements make facets that, in a plane,
/// are positive too: each point of it is covered as often as the border winds around it. That border stays, and so no
/// facet comes where none was, nor covers another.
template <int D>
[[nodiscard]] bool keeps_its_planes(const DynamicMesh<D>& mesh, const Patch<D>& patch,
                                    std::span<const NodalFacet<D>> made);

/// True if the facets that a patch makes pass through neither each other nor the mesh's other facets. Curved facets
/// must be proved to be disjoint, each from itself too; straight ones may touch.
template <int D>
[[nodiscard]] bool are_walls_clear(const Adaptation<D>& r, const Patch<D>& patch, std::span<const NodalFacet<D>> made);

/// Facets of the patches of one round, which are planned independently of one another.
template <int D>
class NewWalls {
  public:
    void clear();
    /// Takes the patch's facets, which are clear by themselves (are_walls_clear, or valid elements that keep their
    /// planes). False if they are not clear of those taken before.
    [[nodiscard]] bool take(const DynamicMesh<D>& mesh, const Patch<D>& patch);

  private:
    FacetGrid<D> grid_;
    std::vector<NodalFacet<D>> facets_;
    std::vector<FacetId> near_;
};

}  // namespace camber

export namespace camber {

// Elements with two facets on one smooth surface: flat where the surface is smooth and the facets small, and folded
// once they are curved, wherever the nodes of their edges are put.

/// Whether an element has two facets of one reference that meet where the surface does not break.
template <int D>
[[nodiscard]] bool is_wall_element(const DynamicMesh<D>& mesh, ElementId e);

/// Whether a patch makes more of them than it removes. Not so where there is no geometry, nor of a plane.
template <int D>
[[nodiscard]] bool adds_wall_elements(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch);

}  // namespace camber
