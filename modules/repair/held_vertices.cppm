module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
module camber.repair:held_vertices;
import camber.core;
import camber.validity;
import :options;

namespace camber {

/// How a vertex may move while a mesh is repaired.
enum class VertexFreedom : std::uint8_t {
    held,     ///< it stays
    free,     ///< in the volume
    sliding,  ///< on the boundary: as far as it slides on the geometry
};

/// All vertices are held, or required ones, those at edges that are, and those of the boundary where none slides.
template <int D>
[[nodiscard]] inline Buffer<VertexFreedom> vertex_freedoms(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                           VertexMoves moves, VertexFreedom of_boundary) {
    Buffer<VertexFreedom> freedoms(mesh.linear.points.size());
    std::ranges::fill(freedoms, moves == VertexMoves::never ? VertexFreedom::held : VertexFreedom::free);
    if (moves == VertexMoves::never) return freedoms;
    for (const bool is_fixed : {false, true})
        for (std::size_t e = 0; e < kinds.size(); ++e)
            if (kinds[e] != EdgeKind::volume && (kinds[e] == EdgeKind::fixed) == is_fixed)
                for (const VertexId v : mesh.edges.vertices[e])
                    freedoms[v.index()] = is_fixed ? VertexFreedom::held : of_boundary;
    const auto required = required_vertices(mesh.linear);
    for (std::size_t v = 0; v < freedoms.size(); ++v)
        if (required[v] != 0) freedoms[v] = VertexFreedom::held;
    return freedoms;
}

}  // namespace camber
