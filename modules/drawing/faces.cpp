module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

template <int D>
bool is_of_facets(const LinearMesh<D>& mesh) {
    return D == 3 && mesh.elements.size() == 0;
}

template <int D, std::size_t N>
Vec<D> centroid(const LinearMesh<D>& mesh, const std::array<VertexId, N>& vertices) {
    Vec<D> sum{};
    for (const VertexId v : vertices) sum += mesh.points[v];
    return sum / static_cast<double>(N);
}

NodeNumber number_of(VertexId v) { return v.value; }

/// The local edge between two local vertices of a K-simplex.
template <int K>
constexpr std::size_t local_edge(int a, int b) {
    for (std::size_t e = 0; e < local_edges<K>.size(); ++e)
        if ((local_edges<K>[e][0] == a && local_edges<K>[e][1] == b) ||
            (local_edges<K>[e][0] == b && local_edges<K>[e][1] == a))
            return e;
    return 0;
}

/// The nodes of a triangle of a simplex.
template <int K>
std::array<NodeNumber, 6> nodes_of(const SimplexVertices<K>& vertices,
                                   const std::array<EdgeId, edges_per_simplex<K>>& edges,
                                   const std::array<int, 3>& local, std::size_t vertex_count) {
    std::array<NodeNumber, 6> nodes{};
    for (std::size_t i = 0; i < 3; ++i) {
        nodes[i] = number_of(vertices[local[i]]);
        const std::size_t edge = local_edge<K>(local[i], local[(i + 1) % 3]);
        nodes[3 + i] = static_cast<NodeNumber>(vertex_count + edges[edge].index());
    }
    return nodes;
}

/// Triangles that are seen themselves.
template <int K, class Edges>
Column<Face> whole_triangles(const Simplices<K>& triangles, const Edges& edges, std::size_t vertex_count,
                             std::span<const std::uint8_t> kept, FaceKind kind) {
    Buffer<Face> faces;
    faces.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        if (kept.empty() || kept[t] != 0)
            faces.push_back({nodes_of<K>(triangles.vertices[t], edges[t], {0, 1, 2}, vertex_count),
                             static_cast<std::uint32_t>(t), triangles.references[t], kind});
    return faces;
}

enum class Seen : std::uint8_t { no, boundary, uncovered };
using SeenFaces = std::array<Seen, 4>;  ///< by the local vertex opposite

/// Each face belongs to one call of the visitor, so that none writes where another does.
Outcome<Buffer<SeenFaces>> seen_faces(const LinearMesh<3>& mesh, std::span<const std::uint8_t> kept,
                                      const Execution& execution) {
    const auto balls_of = balls(mesh, part_of(execution, 0, 0.4));
    if (!balls_of) return fail(balls_of.error());
    Buffer<SeenFaces> seen(mesh.elements.size());
    std::fill(seen.begin(), seen.end(), SeenFaces{});
    const auto is_kept = [&](const FaceAround<3>& f) { return kept.empty() || kept[f.face.element.index()] != 0; };
    auto done = each_face<3>(mesh, *balls_of, part_of(execution, 0.4, 0.9), [&](std::span<const FaceAround<3>> on) {
        // More than two elements on a face are a defect, and all of them are shown.
        if (on.size() == 2 && is_kept(on[0]) == is_kept(on[1])) return;
        for (const FaceAround<3>& f : on)
            if (is_kept(f))
                seen[f.face.element.index()][f.face.opposite] = on.size() == 1 ? Seen::boundary : Seen::uncovered;
    });
    if (!done) return fail(done.error());
    return seen;
}

/// The reference of the facet with these vertices; 0: there is none.
Reference reference_of_facet(const LinearMesh<3>& mesh, const Incidence<FacetId>& facets,
                             std::array<VertexId, 3> vertices) {
    std::sort(vertices.begin(), vertices.end());
    for (const FacetId f : facets[vertices[0]]) {
        auto other = mesh.facets.vertices[f];
        std::sort(other.begin(), other.end());
        if (other == vertices) return mesh.facets.references[f];
    }
    return 0;
}

Outcome<Column<Face>> faces_of_tetrahedra(const QuadraticMesh<3>& mesh, std::span<const std::uint8_t> kept,
                                          const Execution& execution) {
    const LinearMesh<3>& linear = mesh.linear;
    const auto seen = seen_faces(linear, kept, part_of(execution, 0, 0.8));
    if (!seen) return fail(seen.error());
    const auto facets = facet_balls(linear, part_of(execution, 0.8, 0.9));
    if (!facets) return fail(facets.error());
    Buffer<Face> faces;
    for (std::size_t e = 0; e < seen->size(); ++e)
        for (int i = 0; i < 4; ++i) {
            const Seen how = (*seen)[e][i];
            if (how == Seen::no) continue;
            const auto local = face_opposite<3>(i);
            const auto& v = linear.elements.vertices[e];
            const bool is_boundary = how == Seen::boundary;
            faces.push_back({nodes_of<3>(v, mesh.edges.of_elements[e], local, linear.points.size()),
                             static_cast<std::uint32_t>(e),
                             is_boundary ? reference_of_facet(linear, *facets, {v[local[0]], v[local[1]], v[local[2]]})
                                         : linear.elements.references[e],
                             is_boundary ? FaceKind::boundary : FaceKind::uncovered});
        }
    return Column<Face>(std::move(faces));
}

}  // namespace

template <int D>
Outcome<Column<std::uint8_t>> kept_by(const Cut<D>& cut, const LinearMesh<D>& mesh, const Execution& execution) {
    const auto stays = [&](const Vec<D>& c) { return static_cast<std::uint8_t>(dot(cut.normal, c) <= cut.offset); };
    auto kept = is_of_facets(mesh)
                    ? map_each(execution, mesh.facets.size(),
                               [&](std::size_t f) { return stays(centroid(mesh, mesh.facets.vertices[f])); })
                    : map_each(execution, mesh.elements.size(),
                               [&](std::size_t e) { return stays(centroid(mesh, mesh.elements.vertices[e])); });
    if (!kept) return fail(kept.error());
    return Column<std::uint8_t>(std::move(*kept));
}

template <int D>
Outcome<Column<Face>> faces_to_draw(const QuadraticMesh<D>& mesh, std::span<const std::uint8_t> kept,
                                    const Execution& execution) {
    return guarded([&]() -> Outcome<Column<Face>> {
        const LinearMesh<D>& linear = mesh.linear;
        if constexpr (D == 2)
            return whole_triangles<2>(linear.elements, mesh.edges.of_elements, linear.points.size(), kept,
                                      FaceKind::plane);
        else if (is_of_facets(linear))
            return whole_triangles<2>(linear.facets, mesh.edges.of_facets, linear.points.size(), kept,
                                      FaceKind::boundary);
        else
            return faces_of_tetrahedra(mesh, kept, execution);
    });
}

template <int D>
Column<FaceEdge> edges_to_draw(const QuadraticMesh<D>& mesh, std::span<const Face> faces) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<std::uint32_t> counts(mesh.edges.size());
    std::fill(counts.begin(), counts.end(), 0U);
    for (const Face& face : faces)
        for (std::size_t i = 3; i < 6; ++i) ++counts[face.nodes[i] - vertices];
    Buffer<FaceEdge> edges;
    for (std::size_t e = 0; e < counts.size(); ++e)
        if (counts[e] > 0)
            edges.push_back({{number_of(mesh.edges.vertices[e][0]), number_of(mesh.edges.vertices[e][1]),
                              static_cast<NodeNumber>(vertices + e)},
                             counts[e]});
    return edges;
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<Column<std::uint8_t>> kept_by<D>(const Cut<D>&, const LinearMesh<D>&, const Execution&); \
    template Outcome<Column<Face>> faces_to_draw<D>(const QuadraticMesh<D>&, std::span<const std::uint8_t>,   \
                                                    const Execution&);                                        \
    template Column<FaceEdge> edges_to_draw<D>(const QuadraticMesh<D>&, std::span<const Face>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
