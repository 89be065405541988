// camber.extension: extends the displacement of a wall into its layers of elements, which move with the wall.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.extension;

using namespace camber;

/// Mesh of layers of height 0.1 on a wall of two edges of length 1. Each cell is divided into two triangles.
static LinearMesh<2> layers(std::size_t count) {
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    for (std::size_t k = 0; k <= count; ++k)
        for (std::size_t i = 0; i < 3; ++i) points.push_back({{static_cast<double>(i), 0.1 * static_cast<double>(k)}});
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = 0; i < 2; ++i) {
            const VertexId a(3 * k + i), b(3 * k + i + 1), c(3 * k + i + 3), d(3 * k + i + 4);
            triangles.push_back({a, b, d});
            triangles.push_back({a, d, c});
        }
    LinearMesh<2> mesh;
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(triangles);
    return mesh;
}

int main() {
    const LinearMesh<2> mesh = layers(20);
    const auto edges = unique_edges(mesh, {});
    if (!edges) return 1;
    const auto around = shells(*edges, {});
    if (!around) return 1;
    // Nodes of the wall y = 0 move by 0.15, which is more than the height of a layer. All other nodes are unknowns.
    Buffer<EdgeKind> kinds;
    Buffer<LagrangeNode<2>> nodes;
    for (const auto& [a, b] : edges->vertices) {
        const Vec<2> middle = midpoint(mesh.points[a], mesh.points[b]);
        const bool is_wall = mesh.points[a][1] == 0 && mesh.points[b][1] == 0;
        kinds.push_back(is_wall ? EdgeKind::surface : EdgeKind::volume);
        nodes.push_back({is_wall ? middle + Vec<2>{{0, 0.15}} : middle});
    }
    const auto extended = extend_displacement(ExtensionDomain<2, 2>{mesh.points, mesh.elements.vertices, *edges},
                                              Column<EdgeKind>(std::move(kinds)),
                                              Column<LagrangeNode<2>>(std::move(nodes)), *around, {}, {});
    if (!extended) return 1;
    double first = 0;
    for (std::size_t e = 0; e < edges->size(); ++e) {
        const auto& [a, b] = edges->vertices[e];
        if (std::abs(mesh.points[a][1] - 0.1) < 1e-9 && std::abs(mesh.points[b][1] - 0.1) < 1e-9)
            first = extended->nodes[e].point[1] - 0.1;
    }
    std::printf("the first layer moves by %.4f after %d iterations\n", first, extended->iterations);
    return first > 0.1 && first < 0.15 ? 0 : 1;
}
