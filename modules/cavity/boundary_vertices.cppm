module;
#include <cstddef>
#include <cstdint>
export module camber.cavity:boundary_vertices;
import camber.core;
import camber.validity;
import :repair;

namespace camber {

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

/// 1 for vertices that repair must not move: all of them, or those on the boundary and required ones.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> held_vertices(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                        VertexMoves moves) {
    if (moves == VertexMoves::never) return Buffer<std::uint8_t>(mesh.linear.points.size(), 1);
    Buffer<std::uint8_t> marks = boundary_vertices(mesh, kinds);
    const auto required = required_vertices(mesh.linear);
    for (std::size_t v = 0; v < marks.size(); ++v)
        if (required[v] != 0) marks[v] = 1;
    return marks;
}

}  // namespace camber
