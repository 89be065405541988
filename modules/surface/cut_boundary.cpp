module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
struct Whole {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    std::vector<EdgeId> rows;           ///< rising: the boundary edges
    std::vector<VertexId> middle_of{};  ///< of each edge, where it is one of them: its node among the vertices

    /// The vertex at a place of a facet that is a corner or the middle of an edge.
    [[nodiscard]] VertexId vertex_at(FacetId f, const Barycentric<D - 1>& place) const {
        const auto at = [&](int i) { return place[static_cast<std::size_t>(i)]; };
        for (int i = 0; i < D; ++i)
            if (at(i) == 1) return mesh.facets.vertices[f][i];
        for (std::size_t k = 0; k < local_edges<D - 1>.size(); ++k)
            if (at(local_edges<D - 1>[k][0]) != 0 && at(local_edges<D - 1>[k][1]) != 0)
                return middle_of[edges.of_facets[f][k].index()];
        return {};
    }
};

template <int D>
Whole<D> whole(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features) {
    Whole<D> out{mesh, edges, features, {}, std::vector<VertexId>(edges.size())};
    for (std::size_t e = 0; e < edges.size(); ++e) {
        if (features.edge_kinds[e] == EdgeKind::volume) continue;
        out.middle_of[e] = VertexId(mesh.points.size() + out.rows.size());
        out.rows.emplace_back(e);
    }
    return out;
}

/// Breaks that the file lists: in 2D vertices, in 3D both halves of an edge.
void list_breaks(const Whole<2>& whole, LinearMesh<2>& pieces) {
    Buffer<VertexId> corners(whole.mesh.corners.begin(), whole.mesh.corners.end());
    for (const std::uint32_t f : whole.mesh.ridges)
        for (const VertexId v : whole.mesh.facets.vertices[f]) corners.push_back(v);
    pieces.corners = std::move(corners);
}
void list_breaks(const Whole<3>& whole, LinearMesh<3>& pieces) {
    pieces.corners = whole.mesh.corners;
    Buffer<SimplexVertices<1>> halves;
    for (const std::uint32_t ridge : whole.mesh.ridges) {
        const VertexId middle = whole.middle_of[whole.edges.of_edges[ridge].index()];
        if (!middle.valid()) continue;
        for (const VertexId end : whole.mesh.edges.vertices[ridge]) halves.push_back({end, middle});
    }
    Buffer<Reference> references(halves.size());
    std::ranges::fill(references, 0);
    Buffer<std::uint32_t> ridges(halves.size());
    std::iota(ridges.begin(), ridges.end(), 0U);
    pieces.edges.vertices = std::move(halves);
    pieces.edges.references = std::move(references);
    pieces.ridges = std::move(ridges);
}

template <int D>
LinearMesh<D> mesh_of_pieces(const Whole<D>& whole, std::span<const LagrangeNode<D>> nodes) {
    constexpr std::size_t pieces = CutBoundary<D>::pieces;
    Buffer<Vec<D>> points(whole.mesh.points.begin(), whole.mesh.points.end());
    points.reserve(points.size() + whole.rows.size());
    for (const EdgeId e : whole.rows) points.push_back(nodes[e.index()].point);
    Buffer<Reference> point_references(points.size());
    std::ranges::fill(point_references, 0);
    Buffer<SimplexVertices<D - 1>> vertices(pieces * whole.mesh.facets.size());
    Buffer<Reference> references(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const FacetId f(i / pieces);
        references[i] = whole.mesh.facets.references[f];
        for (std::size_t c = 0; c < D; ++c) vertices[i][c] = whole.vertex_at(f, pieces_of_facet<D - 1>[i % pieces][c]);
    }
    LinearMesh<D> out;
    out.points = std::move(points);
    out.point_references = std::move(point_references);
    out.facets.vertices = std::move(vertices);
    out.facets.references = std::move(references);
    out.geometry = whole.mesh.geometry;
    list_breaks(whole, out);
    return out;
}

template <int D>
Features<D> features_of_pieces(const Whole<D>& whole, const LinearMesh<D>& mesh, const EdgeSet<D>& edges) {
    constexpr std::size_t pieces = CutBoundary<D>::pieces;
    const Features<D>& of = whole.features;
    Features<D> out = of;
    Buffer<EdgeKind> edge_kinds(edges.size());
    std::ranges::fill(edge_kinds, EdgeKind::surface);  // as those between the pieces of a facet are
    Buffer<std::uint32_t> curves(edges.size());
    std::ranges::fill(curves, no_feature);
    Buffer<VertexKind> vertex_kinds(of.vertex_kinds.begin(), of.vertex_kinds.end());
    for (const EdgeId e : whole.rows) {
        const bool is_ridge = of.edge_kinds[e] == EdgeKind::ridge;
        vertex_kinds.push_back(is_ridge ? VertexKind::ridge : VertexKind::surface);
        for (const VertexId end : whole.edges.vertices[e]) {
            const EdgeId half = find_edge(edges, end, whole.middle_of[e.index()]);
            if (!half.valid()) continue;
            edge_kinds[half.index()] = of.edge_kinds[e];
            curves[half.index()] = of.curves[e];
            out.ridge_edges += is_ridge ? 1 : 0;
        }
    }
    Buffer<std::uint32_t> patches(mesh.facets.size());
    for (std::size_t i = 0; i < patches.size(); ++i) patches[i] = of.patches[i / pieces];
    out.edge_kinds = std::move(edge_kinds);
    out.vertex_kinds = std::move(vertex_kinds);
    out.patches = std::move(patches);
    out.curves = std::move(curves);
    out.ridge_edges -= of.ridge_edges;
    out.surface_edges = edges.size() - out.ridge_edges;
    return out;
}

}  // namespace

template <int D>
Outcome<CutBoundary<D>> cut_at_nodes(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                     std::span<const LagrangeNode<D>> nodes, const Execution& execution) {
    return guarded([&]() -> Outcome<CutBoundary<D>> {
        const Whole<D> of = whole(mesh, edges, features);
        CutBoundary<D> cut{mesh_of_pieces(of, nodes), {}, {}};
        auto halves = unique_edges(cut.mesh, execution);
        if (!halves) return fail(halves.error());
        cut.edges = std::move(*halves);
        cut.features = features_of_pieces(of, cut.mesh, cut.edges);
        return cut;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<CutBoundary<D>> cut_at_nodes(const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, \
                                                  std::span<const LagrangeNode<D>>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
