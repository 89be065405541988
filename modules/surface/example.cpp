// camber.surface: recovers a smooth boundary from a straight mesh alone. For half a disc, it finds both corners, keeps
// the diameter straight, and moves the nodes of the arc onto the circle.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

import camber.core;
import camber.bezier;
import camber.surface;

using namespace camber;

/// Upper half of the unit disc: n triangles around the centre (vertex 0), with boundary edges as facets.
static LinearMesh<2> half_disc(std::size_t n) {
    const auto v = [](std::size_t i) { return VertexId(i); };
    Buffer<Vec<2>> points{{{0, 0}}, {{1, 0}}};
    Buffer<SimplexVertices<2>> triangles;
    Buffer<SimplexVertices<1>> facets{{v(n + 1), v(0)}, {v(0), v(1)}};  // the diameter
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = std::numbers::pi * static_cast<double>(i + 1) / static_cast<double>(n);
        points.push_back({{camber::cos(angle), camber::sin(angle)}});
        triangles.push_back({v(0), v(i + 1), v(i + 2)});
        facets.push_back({v(i + 1), v(i + 2)});
    }
    LinearMesh<2> mesh;
    mesh.point_references = Buffer<Reference>(n + 2, 0);
    mesh.points = std::move(points);
    mesh.elements = {std::move(triangles), Buffer<Reference>(n, 1), {}};
    mesh.facets = {std::move(facets), Buffer<Reference>(n + 2, 1), {}};
    return mesh;
}

static Outcome<bool> example(const Execution& execution) {
    const auto mesh = elevate(half_disc(8), execution);
    if (!mesh) return fail(mesh.error());
    const auto features = find_features(mesh->linear, mesh->edges, FeatureOptions<2>{}, execution);
    if (!features) return fail(features.error());
    const auto surrogate = build_surrogate(mesh->linear, mesh->edges, *features, SurrogateOptions{}, execution);
    if (!surrogate) return fail(surrogate.error());
    const auto nodes = boundary_nodes(*mesh, *features, Geometry<2>(*surrogate), execution);
    if (!nodes) return fail(nodes.error());

    double before = 0, after = 0;  // distance of the arc's nodes from the circle
    for (const auto& edges : mesh->edges.of_facets) {
        const std::size_t e = edges[0].index();
        if (mesh->mid_nodes[e].point[1] < 1e-12) continue;  // the diameter
        before = std::fmax(before, std::abs(1 - norm(mesh->mid_nodes[e].point)));
        after = std::fmax(after, std::abs(1 - norm((*nodes)[e].point)));
    }
    std::printf("%zu corners; nodes of the arc are off the circle by %.1e, from now on by %.1e\n", features->corners,
                before, after);
    return features->corners == 2 && before > 1e-2 && after < 1e-12;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
