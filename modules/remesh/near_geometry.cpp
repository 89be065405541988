module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.remesh;
import camber.core;
import camber.bezier;
import camber.crossing;
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

/// By the shape functions of its nodes.
template <int D>
Vec<D> point_of(const NodalFacet<D>& facet, const Barycentric<D - 1>& xi) {
    Vec<D> p;
    for (int i = 0; i < D; ++i) p += xi[i] * (2 * xi[i] - 1) * facet.nodes[i];
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        p += 4 * xi[i] * xi[j] * facet.nodes[D + e];
    }
    return p;
}

/// The distance of a facet from its surface by its longest edge; 0 where it has none.
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

}  // namespace

template <int D>
FacetDistance distance_from_geometry(const Remeshing<D>& r, const RemeshingGoal<D>& goal, const TopologyPatch<D>& patch,
                                     double share) {
    FacetDistance out;
    if (!goal.geometry || patch.star.facets.empty()) return out;
    const Vec<D> place = place_of_point(r.mesh, patch);
    const auto& references = r.mesh.facets.references;
    for (const JoinedFacet& joined : patch.star.facets)
        out.largest = std::max(out.largest, distance_share<D>(*goal.geometry, references[joined.facet],
                                                              nodal_facet(r.mesh, patch, joined, place)));
    out.is_near = !(out.largest > share);
    for (auto f = patch.removed.facets.begin(); !out.is_near && f != patch.removed.facets.end(); ++f)
        out.is_near = !(out.largest > distance_share<D>(*goal.geometry, references[*f], nodal_facet(r.mesh, *f)));
    return out;
}

template FacetDistance distance_from_geometry<2>(const Remeshing<2>&, const RemeshingGoal<2>&, const TopologyPatch<2>&,
                                                 double);
template FacetDistance distance_from_geometry<3>(const Remeshing<3>&, const RemeshingGoal<3>&, const TopologyPatch<3>&,
                                                 double);

}  // namespace camber
