module;
#include <cstddef>
#include <cstdint>
#include <utility>
export module camber.core:required;
import :column;
import :ids;
import :mesh;
import :words;

/// What a file says must not change (GMF's Required entities).
export namespace camber {

/// One mark an edge: 1 for a required one, and for the edges of required facets and elements.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> required_edges(const QuadraticMesh<D>& mesh) {
    Buffer<std::uint8_t> marks(mesh.edges.size(), 0);
    for (const std::uint32_t s : mesh.linear.elements.required)
        for (const EdgeId e : mesh.edges.of_elements[s]) marks[e.index()] = 1;
    for (const std::uint32_t f : mesh.linear.facets.required)
        for (const EdgeId e : mesh.edges.of_facets[f]) marks[e.index()] = 1;
    for (const std::uint32_t e : mesh.linear.edges.required)
        if (e < mesh.edges.of_edges.size()) marks[mesh.edges.of_edges[e].index()] = 1;
    return marks;
}

/// One mark a vertex: 1 for a required one, and for the vertices of required edges, facets and elements.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> required_vertices(const LinearMesh<D>& mesh) {
    Buffer<std::uint8_t> marks(mesh.points.size(), 0);
    for (const VertexId v : mesh.required_vertices) marks[v.index()] = 1;
    const auto mark = [&](const auto& simplices) {
        for (const std::uint32_t s : simplices.required)
            for (const VertexId v : simplices.vertices[s]) marks[v.index()] = 1;
    };
    mark(mesh.elements);
    mark(mesh.facets);
    mark(mesh.edges);
    return marks;
}

/// Whether edges of the boundary are held where they are required, or those of the volume alone.
enum class RequiredBoundary : std::uint8_t { keep, geometry };
[[nodiscard]] constexpr auto words(RequiredBoundary) {
    return words_of(Word{RequiredBoundary::keep, "keep"}, Word{RequiredBoundary::geometry, "geometry"});
}

/// The kinds with the required edges `fixed`: their nodes stay.
template <int D>
[[nodiscard]] inline Column<EdgeKind> held_kinds(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                 RequiredBoundary boundary) {
    const auto required = required_edges(mesh);
    Buffer<EdgeKind> held(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < held.size(); ++e)
        if (required[e] != 0 && (boundary == RequiredBoundary::keep || kinds[e] == EdgeKind::volume))
            held[e] = EdgeKind::fixed;
    return Column<EdgeKind>(std::move(held));
}

/// The mesh without what it requires of its facets, feature edges and elements.
template <int D>
[[nodiscard]] inline QuadraticMesh<D> without_required(QuadraticMesh<D> mesh) {
    mesh.linear.elements.required = {};
    mesh.linear.facets.required = {};
    mesh.linear.edges.required = {};
    return mesh;
}

/// 1 for vertices on the boundary: at an end of an edge that is not of the volume.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> boundary_vertices(const QuadraticMesh<D>& mesh,
                                                            const Column<EdgeKind>& kinds) {
    Buffer<std::uint8_t> marks(mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume)
            for (const VertexId v : mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

}  // namespace camber
