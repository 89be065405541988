// camber.edge_optimisation: computes the shortest P2 edge in a metric field without curving a mesh. Sizes are small
// along the radius and large across it, so the shortest curve between two points of a circle follows the circle.
#include <cmath>
#include <cstdio>
#include <utility>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;

/// The square [−1, 1] × [0.5, 2.5] in n × n cells of two triangles: the back mesh with the field.
static LinearMesh<2> square(std::size_t n) {
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const double h = 2.0 / static_cast<double>(n);
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(i + (n + 1) * j); };
    for (std::size_t j = 0; j <= n; ++j)
        for (std::size_t i = 0; i <= n; ++i) {
            points.push_back({{-1 + h * static_cast<double>(i), 0.5 + h * static_cast<double>(j)}});
            if (i == n || j == n) continue;
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    LinearMesh<2> mesh;
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.points = std::move(points);
    mesh.elements = {std::move(triangles), Buffer<Reference>(2 * n * n, 1), {}};
    return mesh;
}

static Outcome<bool> example(const Execution& execution) {
    const LinearMesh<2> mesh = square(40);
    // Fields store log M: LogMetric and Metric are two types, and only logarithms are interpolated.
    auto field = map_each(execution, mesh.points.size(), [&](std::size_t v) {
        const Vec<2> radial = normalised(mesh.points[v]);
        return log_metric_of_sizes<2>({{0.02, 0.2}}, {{radial, Vec<2>{{-radial[1], radial[0]}}}});
    });
    if (!field) return fail(field.error());
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    const auto back = make_back_mesh(mesh, *around, Column<LogMetric<2>>(std::move(*field)), execution);
    if (!back) return fail(back.error());

    const Vec<2> from{{-0.3, 1.2}}, to{{0.3, 1.2}};
    const EdgeMinimiserOptions options;
    const auto found = minimise_edge(*back, from, to, ElementId(std::size_t{0}), edge_rules(options), options);
    std::printf("anisotropy %.0f; length of the chord %.3f, of the P2 edge %.3f\n",
                anisotropy((*back)->vertex(VertexId(std::size_t{0})).log_metric), found.straight_length, found.length);
    std::printf("radius at the ends %.3f, of the chord's middle %.3f, of the node %.3f\n", norm(from), from[1],
                norm(found.node.point));
    return found.length < 0.9 * found.straight_length && std::abs(norm(found.node.point) - norm(from)) < 0.01;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
