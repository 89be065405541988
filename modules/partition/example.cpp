// Example of camber.partition: divides a square of triangles into two parts, each a separate mesh.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

import camber.core;
import camber.partition;

int main() {
    using namespace camber;
    LinearMesh<2> square;
    square.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
    square.point_references = Buffer<Reference>(4, 0);
    const auto v = [](std::size_t i) { return VertexId(i); };
    square.elements.vertices = Buffer<SimplexVertices<2>>{{v(0), v(1), v(2)}, {v(0), v(2), v(3)}};
    square.elements.references = Buffer<Reference>(2, 1);
    const auto parts = parts_of_cells(square, Buffer<std::int32_t>{0, 1}, {});
    if (!parts) return EXIT_FAILURE;
    for (const std::int32_t part : {0, 1}) {
        const auto piece = piece_of(square, *parts, part, {});
        if (!piece || piece->mesh.elements.size() != 1) return EXIT_FAILURE;
        std::printf("part %d: %zu triangle, %zu vertices\n", part, piece->mesh.elements.size(), piece->vertices.size());
    }
    return EXIT_SUCCESS;
}
