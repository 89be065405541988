module;
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
export module camber.crossing:facet;
import camber.core;
import camber.bezier;

export namespace camber {

/// A P2 facet in D dimensions (a triangle in space, an edge in the plane) by the mesh's Lagrange nodes: its vertices,
/// then the mid nodes in the order of `local_edges`.
template <int D>
struct NodalFacet {
    static constexpr int nodes_of_facet = quadratic_nodes<D - 1>;
    std::array<Vec<D>, nodes_of_facet> nodes{};
    friend bool operator==(const NodalFacet&, const NodalFacet&) = default;
};

/// The facet of these vertices with its nodes at the middle of the chords.
template <int D>
[[nodiscard]] inline NodalFacet<D> straight_facet(const std::array<Vec<D>, D>& vertices) {
    NodalFacet<D> facet;
    std::copy(vertices.begin(), vertices.end(), facet.nodes.begin());
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        facet.nodes[D + e] = midpoint(vertices[i], vertices[j]);
    }
    return facet;
}

/// Facet f of the mesh, with other places of points and mid nodes: those of a proposal.
template <int D>
[[nodiscard]] inline NodalFacet<D> nodal_facet(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                               std::span<const LagrangeNode<D>> mid_nodes, FacetId f) {
    NodalFacet<D> facet;
    for (int i = 0; i < D; ++i) facet.nodes[i] = points[mesh.linear.facets.vertices[f][i].index()];
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e)
        facet.nodes[D + e] = mid_nodes[mesh.edges.of_facets[f][e].index()].point;
    return facet;
}

/// Facet f of the mesh.
template <int D>
[[nodiscard]] inline NodalFacet<D> nodal_facet(const QuadraticMesh<D>& mesh, FacetId f) {
    return nodal_facet<D>(mesh, mesh.linear.points.view(), mesh.mid_nodes.view(), f);
}

/// A box that holds the whole facet, rounding included: of its Bézier points, which err by less than
/// 4 u of the largest coordinate; empty where a node is not finite.
template <int D>
[[nodiscard]] inline Box<D> box_of(const NodalFacet<D>& facet) {
    Box<D> box;
    double largest = 0;
    const auto include = [&](const Vec<D>& p) {
        box.include(p);
        for (const double x : p.c) largest = std::max(largest, std::abs(x));
    };
    for (int i = 0; i < D; ++i) include(facet.nodes[i]);
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        include(control_point(facet.nodes[i], {facet.nodes[D + e]}, facet.nodes[j]).point);
    }
    const double blur = 0x1p-49 * largest;
    for (int c = 0; c < D; ++c) {
        box.low[c] -= blur;
        box.high[c] += blur;
    }
    return box;
}

}  // namespace camber
