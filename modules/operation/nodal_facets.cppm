module;
#include <algorithm>
#include <array>
#include <cstddef>
module camber.operation:nodal_facets;
import camber.core;
import camber.crossing;
import camber.cavity;
import :on_geometry;
import :state;

/// Facets of meshes that change, with the nodes of their edges; of a straight mesh the middles of chords.
namespace camber {

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

}  // namespace camber
