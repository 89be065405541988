module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.remesh;
import camber.core;
import camber.bezier;
import camber.dynamic;
import camber.surface;

namespace camber {

namespace {

/// Its middle and those of its edges.
template <int D>
auto places_on_facet() {
    if constexpr (D == 2)
        return std::array<Barycentric<1>, 1>{{{0.5, 0.5}}};
    else
        return std::array<Barycentric<2>, 4>{
            {{1.0 / 3, 1.0 / 3, 1.0 / 3}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}};
}

/// A facet, and how far the nodes of its edges are from the middles of chords: of the edge opposite each corner; in 2D
/// the first alone.
template <int D>
struct BentFacet {
    FacetSite<D> site;
    std::array<Vec<D>, D> offsets{};
};

template <int D>
Vec<D> offset_of(const DynamicMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges[edge];
    return mesh.nodes[edge].point - midpoint(mesh.points[a], mesh.points[b]);
}
template <int D>
BentFacet<D> facet_of(const DynamicMesh<D>& mesh, FacetId f) {
    BentFacet<D> facet{site_of(mesh, f), {}};
    if (!mesh.is_curved()) return facet;
    if constexpr (D == 3) {
        for (int k = 0; k < 3; ++k) facet.offsets[k] = offset_of(mesh, facet_edge(mesh, f, k));
    } else {
        const ElementId e = mesh.sides[f][0];
        const auto& [a, b] = mesh.facets.vertices[f];
        const auto& vertices = mesh.elements.vertices[e];
        const int k = edge_between<2>[local_vertex(vertices, a)][local_vertex(vertices, b)];
        facet.offsets[0] = offset_of(mesh, mesh.edges_of[e][k]);
    }
    return facet;
}
/// A new one.
template <int D>
BentFacet<D> facet_of(const DynamicMesh<D>& mesh, const TopologyPatch<D>& patch, const JoinedFacet& joined,
                      const Vec<D>& place) {
    const int opposite = static_cast<int>(joined.opposite);
    BentFacet<D> facet{site_of(mesh, joined.facet), {}};
    facet.site.corners[opposite] = place;
    if (!mesh.is_curved()) return facet;
    const auto offset_to = [&](int corner) {
        const VertexId v = mesh.facets.vertices[joined.facet][corner];
        const auto at = std::ranges::find(patch.star.boundary, v) - patch.star.boundary.begin();
        return patch.nodes[at].point - midpoint(place, mesh.points[v]);
    };
    if constexpr (D == 3) {
        facet.offsets[opposite] = offset_of(mesh, facet_edge(mesh, joined.facet, opposite));
        for (const int k : {(opposite + 1) % 3, (opposite + 2) % 3}) facet.offsets[k] = offset_to(3 - opposite - k);
    } else {
        facet.offsets[0] = offset_to(1 - opposite);
    }
    return facet;
}

/// The distance of a facet from its surface by its longest edge; 0 where it has none.
template <int D>
double distance_share(const Geometry<D>& geometry, const BentFacet<D>& bent) {
    const FacetSite<D>& facet = bent.site;
    const auto at = places_on_facet<D>();
    std::array<Vec<D>, at.size()> points;
    std::array<double, at.size()> distances{};
    for (std::size_t n = 0; n < at.size(); ++n) {
        points[n] = {};
        for (int i = 0; i < D; ++i) points[n] += at[n][i] * facet.corners[i];
        if constexpr (D == 3)
            for (int k = 0; k < 3; ++k) points[n] += 4 * at[n][(k + 1) % 3] * at[n][(k + 2) % 3] * bent.offsets[k];
        else
            points[n] += bent.offsets[0];
    }
    if (!geometry->distances(facet, at, points, distances)) return 0;
    double longest = 0;
    for (const auto& [a, b] : local_edges<D - 1>)
        longest = std::max(longest, norm(facet.corners[b] - facet.corners[a]));
    return std::ranges::max(distances) / longest;
}

}  // namespace

template <int D>
bool is_near_geometry(const Remeshing<D>& r, const RemeshingGoal<D>& goal, const TopologyPatch<D>& patch,
                      double share) {
    if (!goal.geometry || patch.star.facets.empty()) return true;
    const VertexId point = patch.point.vertex;
    const Vec<D> place = patch.point.place ? *patch.point.place : r.mesh.points[point];
    double most = share;
    bool compared = false;
    for (const JoinedFacet& joined : patch.star.facets) {
        const double now = distance_share<D>(*goal.geometry, facet_of(r.mesh, patch, joined, place));
        if (now > most && !compared) {
            for (const FacetId f : patch.removed.facets)
                most = std::max(most, distance_share<D>(*goal.geometry, facet_of(r.mesh, f)));
            compared = true;
        }
        if (now > most) return false;
    }
    return true;
}

template bool is_near_geometry<2>(const Remeshing<2>&, const RemeshingGoal<2>&, const TopologyPatch<2>&, double);
template bool is_near_geometry<3>(const Remeshing<3>&, const RemeshingGoal<3>&, const TopologyPatch<3>&, double);

}  // namespace camber
