module;
#include <cstddef>
#include <cstdint>
export module camber.repair:held_vertices;
import camber.core;
import camber.validity;
import :options;

namespace camber {

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
