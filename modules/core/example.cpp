// Example of camber.core: a mesh of immutable columns, its topology, and a sum. Pure functions return an Outcome. Only
// an Execution refers to threads.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

import camber.core;

using namespace camber;

static LinearMesh<2> polygon(std::size_t n) {
    Buffer<Vec<2>> points(n + 1, Vec<2>{});
    Buffer<SimplexVertices<2>> triangles(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        points[i + 1] = {{camber::cos(angle), camber::sin(angle)}};
        triangles[i] = {VertexId(std::size_t{0}), VertexId(i + 1), VertexId((i + 1) % n + 1)};
    }
    LinearMesh<2> mesh;
    mesh.points = std::move(points);  // the buffer is mutable, the column is not
    mesh.point_references = Buffer<Reference>(n + 1, 0);
    mesh.elements.vertices = std::move(triangles);
    mesh.elements.references = Buffer<Reference>(n, 1);
    return mesh;
}

static Outcome<bool> example(const Execution& execution) {
    const std::size_t n = 12;
    const LinearMesh<2> mesh = polygon(n);
    const auto edges = unique_edges(mesh, execution);
    if (!edges) return fail(edges.error());
    const auto around = balls(mesh, execution);  // elements at each vertex
    if (!around) return fail(around.error());
    // Chunks do not depend on the number of threads and are joined in order, so the sum always has the same bits.
    const auto area = reduce_each(
        execution, mesh.elements.size(), 0.0,
        [&](double& sum, std::size_t e) {
            const auto& [a, b, c] = mesh.elements.vertices[e];
            sum += 0.5 * det(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
        },
        [](double left, double right) { return left + right; });
    if (!area) return fail(area.error());

    const double exact = 0.5 * static_cast<double>(n) * camber::sin(2 * std::numbers::pi / static_cast<double>(n));
    std::printf("%zu vertices, %zu edges, %zu triangles\n", mesh.points.size(), edges->size(), mesh.elements.size());
    std::printf("triangles at the centre: %zu\narea: %.15f (formula: %.15f)\n", (*around)[0].size(), *area, exact);
    const bool euler = mesh.points.size() + mesh.elements.size() == edges->size() + 1;  // V − E + F = 1
    return euler && (*around)[0].size() == n && std::abs(*area - exact) < 1e-14;
}

int main() {
    const auto right = example(Execution{.threads = 2});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
