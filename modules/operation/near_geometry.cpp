module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
module camber.operation;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.crossing;
import camber.surface;

namespace camber {

namespace {

template <int D>
auto places_on_facet() {
    if constexpr (D == 2)
        return std::array<Barycentric<1>, 1>{{{0.5, 0.5}}};
    else
        return std::array<Barycentric<2>, 4>{
            {{1.0 / 3, 1.0 / 3, 1.0 / 3}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}};
}

template <int D>
Vec<D> point_of(const NodalFacet<D>& facet, const Barycentric<D - 1>& xi) {
    Vec<D> p;
    for (int i = 0; i < D; ++i) p += vertex_shape(xi[i]) * facet.nodes[i];
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) p += edge_shape<D - 1>(xi, e) * facet.nodes[D + e];
    return p;
}

template <int D>
double distance_share(const Geometry<D>& geometry, Reference reference, const NodalFacet<D>& bent) {
    FacetSite<D> facet{{}, reference, {}};
    std::copy_n(bent.nodes.begin(), D, facet.corners.begin());
    const auto at = places_on_facet<D>();
    std::array<Vec<D>, at.size()> points;
    std::array<double, at.size()> distances{};
    for (std::size_t n = 0; n < at.size(); ++n) points[n] = point_of<D>(bent, at[n]);
    if (!geometry->distances(facet, at, points, distances)) return 0;
    double longest = 0;
    for (const auto& [a, b] : local_edges<D - 1>)
        longest = std::max(longest, norm(facet.corners[b] - facet.corners[a]));
    return std::ranges::max(distances) / longest;
}

/// Largest distance of an edge from its embedded curve, sampled at the quarter points, relative to the chord.
double distance_share(const EmbeddedCurves<3>& curves, Reference reference, const QuadraticEdge<3>& edge) {
    double largest = 0;
    for (const double t : {0.25, 0.5, 0.75}) {
        const Vec<3> p = edge.point(t);
        largest = std::max(largest, distance(p, closest_on_curves(curves, reference, p).value_or(p)));
    }
    return largest / distance(edge.p20, edge.p02);
}

bool are_lines_near(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const Patch<3>& patch, const Vec<3>& place,
                    double share) {
    if (goal.curves.pieces.empty() || patch.star.lines.empty()) return true;
    const auto& mesh = r.mesh;
    double after = 0, before = 0;
    for (const auto& [line, opposite] : patch.star.lines) {
        if (!mesh.is_embedded(line)) continue;
        const VertexId v = mesh.edges[mesh.lines[line]][1 - opposite];
        const auto at = std::ranges::find(patch.star.boundary, v) - patch.star.boundary.begin();
        const LagrangeNode<3> node = mesh.is_curved() ? patch.nodes[static_cast<std::size_t>(at)]
                                                      : LagrangeNode<3>{midpoint(place, mesh.points[v])};
        after = std::max(after, distance_share(goal.curves, mesh.line_references[line], {place, node, mesh.points[v]}));
    }
    if (!(after > share)) return true;
    for (const LineId line : patch.removed.lines) {
        if (!mesh.is_embedded(line)) continue;
        const EdgeId edge = mesh.lines[line];
        const auto& [a, b] = mesh.edges[edge];
        const LagrangeNode<3> node =
            mesh.is_curved() ? mesh.nodes[edge] : LagrangeNode<3>{midpoint(mesh.points[a], mesh.points[b])};
        before = std::max(
            before, distance_share(goal.curves, mesh.line_references[line], {mesh.points[a], node, mesh.points[b]}));
    }
    return !(after > before);
}

/// Sample positions on a facet: `PerEdge` positions on each edge, then the facet's middle.
template <int D, int PerEdge>
constexpr auto bounded_places = [] {
    constexpr int edges = edges_per_simplex<D - 1>;
    constexpr std::array<double, 2> along = PerEdge == 1 ? std::array{0.5, 0.5} : std::array{0.2113, 0.7887};
    std::array<Barycentric<D - 1>, static_cast<std::size_t>(PerEdge * edges) + 1> places{};
    for (int e = 0; e < edges; ++e)
        for (int k = 0; k < PerEdge; ++k) {
            places[PerEdge * e + k][local_edges<D - 1>[e][0]] = 1 - along[k];
            places[PerEdge * e + k][local_edges<D - 1>[e][1]] = along[k];
        }
    for (int i = 0; i < D; ++i) places.back()[i] = 1.0 / D;
    return places;
}();

template <int D>
FacetSite<D> site_of(Reference reference, const NodalFacet<D>& bent) {
    FacetSite<D> facet{{}, reference, {}};
    std::copy_n(bent.nodes.begin(), D, facet.corners.begin());
    return facet;
}

template <int PerEdge, int D>
BoundShares<D> shares_at(const Geometry<D>& geometry, Reference reference, const NodalFacet<D>& bent,
                         const DistanceLimit& limit) {
    constexpr const auto& at = bounded_places<D, PerEdge>;
    const FacetSite<D> facet = site_of<D>(reference, bent);
    std::array<Vec<D>, at.size()> points;
    std::array<double, at.size()> distances{};
    for (std::size_t n = 0; n < at.size(); ++n) points[n] = point_of<D>(bent, at[n]);
    BoundShares<D> shares;
    if (!geometry->distances(facet, at, points, distances)) return shares;
    double longest = 0;
    for (std::size_t e = 0; e < shares.edges.size(); ++e) {
        const auto& [a, b] = local_edges<D - 1>[e];
        const double length = distance(facet.corners[a], facet.corners[b]);
        longest = std::max(longest, length);
        for (int k = 0; k < PerEdge; ++k)
            shares.edges[e] =
                std::max(shares.edges[e], distances[PerEdge * e + static_cast<std::size_t>(k)] / limit.at(length));
    }
    shares.middle = distances.back() / limit.at(longest);
    return shares;
}
template <int D>
BoundShares<D> shares_of(const AdaptationGoal<D>& goal, bool is_curved, Reference reference,
                         const NodalFacet<D>& facet) {
    const DistanceLimit& limit = goal.distance_bounds.of(reference);
    if (!goal.geometry || !limit.is_finite()) return {};
    return is_curved ? shares_at<2, D>(*goal.geometry, reference, facet, limit)
                     : shares_at<1, D>(*goal.geometry, reference, facet, limit);
}

template <int D>
class BoundedPoints {
  public:
    explicit BoundedPoints(const AdaptationGoal<D>& goal) : goal_(goal) {}

    void add(Reference reference, bool is_curved, const NodalFacet<D>& facet,
             std::optional<std::uint32_t> corner = {}) {
        const DistanceLimit& limit = goal_.distance_bounds.of(reference);
        if (!limit.is_finite()) return;
        is_curved ? add<2>(surface_of(reference, facet), limit, facet, corner)
                  : add<1>(surface_of(reference, facet), limit, facet, corner);
    }
    [[nodiscard]] bool are_within() const {
        return std::ranges::all_of(surfaces_, [&](const Surface& surface) {
            return (*goal_.geometry)->are_within(surface.facet, surface.points, surface.bounds);
        });
    }

  private:
    struct Surface {
        FacetSite<D> facet;
        std::vector<Vec<D>> points = {};
        std::vector<double> bounds = {};
    };
    template <int PerEdge>
    static void add(Surface& surface, const DistanceLimit& limit, const NodalFacet<D>& facet,
                    std::optional<std::uint32_t> corner) {
        constexpr const auto& at = bounded_places<D, PerEdge>;
        double longest = 0;
        for (std::size_t e = 0; e < edges_per_simplex<D - 1>; ++e) {
            const auto& [a, b] = local_edges<D - 1>[e];
            const double length = distance(facet.nodes[a], facet.nodes[b]);
            longest = std::max(longest, length);
            for (std::size_t n = PerEdge * e; n < PerEdge * (e + 1); ++n)
                if (!corner || at[n][*corner] != 0) add(surface, point_of<D>(facet, at[n]), limit.at(length));
        }
        add(surface, point_of<D>(facet, at.back()), limit.at(longest));
    }
    static void add(Surface& surface, const Vec<D>& p, double bound) {
        if (std::ranges::find(surface.points, p) != surface.points.end()) return;
        surface.points.push_back(p);
        surface.bounds.push_back(bound);
    }
    Surface& surface_of(Reference reference, const NodalFacet<D>& facet) {
        if ((*goal_.geometry)->is_one_surface(reference))
            for (Surface& surface : surfaces_)
                if (surface.facet.reference == reference) return surface;
        return surfaces_.emplace_back(Surface{site_of<D>(reference, facet)});
    }

    const AdaptationGoal<D>& goal_;
    std::vector<Surface> surfaces_;
};

}  // namespace

template <int D>
BoundShares<D> bound_shares(const Adaptation<D>& r, const AdaptationGoal<D>& goal, FacetId f) {
    return shares_of<D>(goal, r.mesh.is_curved(), r.mesh.facets.references[f], nodal_facet(r.mesh, f));
}

template <int D>
EdgeId local_facet_edge(const DynamicMesh<D>& mesh, FacetId f, int e) {
    if constexpr (D == 2)
        return edge_of_facet(mesh, f);
    else
        return facet_edge(mesh, f, (e + 2) % 3);
}

template <int D>
bool meets_distance_bounds(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch) {
    if (!goal.geometry) return true;
    const auto& references = r.mesh.facets.references;
    const Vec<D> place = place_of_point(r.mesh, patch);
    // Edges of new facets opposite the point also belong to removed facets, so they need no check.
    BoundedPoints<D> all_new(goal), removed(goal);
    for (const JoinedFacet& joined : patch.star.facets)
        if (!r.mesh.is_at_infinity(joined.facet))
            all_new.add(references[joined.facet], r.mesh.is_curved(), nodal_facet(r.mesh, patch, joined, place),
                        joined.opposite);
    if (all_new.are_within()) return true;
    for (const FacetId f : patch.removed.facets)
        if (!r.mesh.is_at_infinity(f)) removed.add(references[f], r.mesh.is_curved(), nodal_facet(r.mesh, f));
    if (removed.are_within()) return false;
    double after = 1;
    for (const JoinedFacet& joined : patch.star.facets)
        if (!r.mesh.is_at_infinity(joined.facet))
            after = std::max(after, shares_of<D>(goal, r.mesh.is_curved(), references[joined.facet],
                                                 nodal_facet(r.mesh, patch, joined, place))
                                        .largest());
    return std::ranges::any_of(patch.removed.facets, [&](FacetId f) {
        return !r.mesh.is_at_infinity(f) && after <= bound_shares(r, goal, f).largest();
    });
}

template <int D>
FacetDistance distance_from_geometry(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch,
                                     double share) {
    FacetDistance out;
    if (!goal.geometry) return out;
    const Vec<D> place = place_of_point(r.mesh, patch);
    if constexpr (D == 3) {
        out.is_near = are_lines_near(r, goal, patch, place, share);
        if (!out.is_near) return out;
    }
    if (patch.star.facets.empty()) return out;
    const auto& references = r.mesh.facets.references;
    for (const JoinedFacet& joined : patch.star.facets)
        if (!r.mesh.is_at_infinity(joined.facet))
            out.largest = std::max(out.largest, distance_share<D>(*goal.geometry, references[joined.facet],
                                                                  nodal_facet(r.mesh, patch, joined, place)));
    out.is_near = !(out.largest > share);
    for (auto f = patch.removed.facets.begin(); !out.is_near && f != patch.removed.facets.end(); ++f)
        out.is_near = !r.mesh.is_at_infinity(*f) &&
                      !(out.largest > distance_share<D>(*goal.geometry, references[*f], nodal_facet(r.mesh, *f)));
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template FacetDistance distance_from_geometry<D>(const Adaptation<D>&, const AdaptationGoal<D>&, const Patch<D>&, \
                                                     double);                                                         \
    template BoundShares<D> bound_shares<D>(const Adaptation<D>&, const AdaptationGoal<D>&, FacetId);                 \
    template EdgeId local_facet_edge<D>(const DynamicMesh<D>&, FacetId, int);                                         \
    template bool meets_distance_bounds<D>(const Adaptation<D>&, const AdaptationGoal<D>&, const Patch<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
