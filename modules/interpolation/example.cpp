// Example of camber.interpolation: compares a curved ring mesh with straight triangles for a function with circular
// level sets.
#include <array>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <span>
#include <utility>

import camber.core;
import camber.bezier;
import camber.interpolation;

using namespace camber;

/// Returns a ring between radii 1 and 2 with 24 sectors and 4 layers.
static LinearMesh<2> ring() {
    constexpr std::size_t sectors = 24, layers = 4;
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const auto at = [](std::size_t layer, std::size_t sector) { return VertexId(layer * sectors + sector % sectors); };
    for (std::size_t l = 0; l <= layers; ++l)
        for (std::size_t s = 0; s < sectors; ++s) {
            const double r = 1 + static_cast<double>(l) / layers;
            const double angle = 2 * std::numbers::pi * static_cast<double>(s) / sectors;
            points.push_back({{r * camber::cos(angle), r * camber::sin(angle)}});
            if (l == layers) continue;
            triangles.push_back({at(l, s), at(l + 1, s), at(l + 1, s + 1)});
            triangles.push_back({at(l, s), at(l + 1, s + 1), at(l, s + 1)});
        }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(triangles.size(), 1);
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(triangles);
    return mesh;
}

/// A function that is steep along the radius.
static PointFunction<2> layer() {
    return [](std::span<const Vec<2>> points, std::span<double> values) {
        for (std::size_t i = 0; i < points.size(); ++i) values[i] = camber::exp(-(norm(points[i]) - 1) / 0.3);
    };
}

static Outcome<bool> example(const Execution& execution) {
    auto mesh = elevate(ring(), execution);
    if (!mesh) return fail(mesh.error());
    auto nodes = take(std::move(mesh->mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh->edges.vertices[e];
        const double radius = (norm(mesh->linear.points[a]) + norm(mesh->linear.points[b])) / 2;
        nodes[e].point = normalised(nodes[e].point) * radius;  // the mean radius of both ends
    }
    mesh->mid_nodes = std::move(nodes);
    const auto error = interpolation_error<2>(as_mesh(*mesh), layer, {}, execution);
    if (!error) return fail(error.error());
    std::printf("           L2           H1\ndegree 1   %.4e   %.4e\nstraight   %.4e   %.4e\ncurved     %.4e   %.4e\n",
                error->linear.l2.value, error->linear.h1.value, error->straight.l2.value, error->straight.h1.value,
                error->curved.l2.value, error->curved.h1.value);
    return error->curved.l2.value < error->straight.l2.value && error->straight.l2.value < error->linear.l2.value &&
           error->unresolved == 0;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
