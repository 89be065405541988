// Example of camber.adapt: adapts a square to a metric. The metric requests size 0.01 across the square's middle, and
// 0.1 along it.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;

static LinearMesh<2> square(std::size_t n) {
    Buffer<Vec<2>> points((n + 1) * (n + 1));
    for (std::size_t v = 0; v < points.size(); ++v) {
        const std::size_t row = v / (n + 1);
        points[v] = Vec<2>{{static_cast<double>(v % (n + 1)), static_cast<double>(row)}} / static_cast<double>(n);
    }
    Buffer<SimplexVertices<2>> triangles;
    Buffer<SimplexVertices<1>> rim;
    Buffer<Reference> sides;
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(i + j * (n + 1)); };
    for (std::size_t j = 0; j < n; ++j)
        for (std::size_t i = 0; i < n; ++i) {
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    for (std::size_t i = 0; i < n; ++i) {
        const std::array<SimplexVertices<1>, 4> edges{
            {{at(i, 0), at(i + 1, 0)}, {at(n, i), at(n, i + 1)}, {at(i + 1, n), at(i, n)}, {at(0, i + 1), at(0, i)}}};
        for (std::size_t side = 0; side < 4; ++side) {
            rim.push_back(edges[side]);
            sides.push_back(static_cast<Reference>(side + 1));
        }
    }
    LinearMesh<2> mesh;
    mesh.points = std::move(points);
    mesh.elements = {std::move(triangles), Buffer<Reference>(2 * n * n, 1), {}};
    mesh.facets = {std::move(rim), std::move(sides), {}};
    return mesh;
}

int main() {
    const Execution all;
    const LinearMesh<2> mesh = square(40);
    Buffer<LogMetric<2>> metrics(mesh.points.size());
    for (std::size_t v = 0; v < metrics.size(); ++v)
        metrics[v] = log_metric_of_sizes<2>({{0.01 + 0.2 * std::abs(mesh.points[v][0] - 0.5), 0.1}});
    const AdaptationGoal<2> goal{make_back_mesh<2>(mesh, balls(mesh, all).value(), std::move(metrics), all).value(),
                                 {}};
    auto initial = begin_adaptation(mesh, unique_edges(mesh, all).value(), {}, goal, all).value();
    const auto [state, statistics] = remesh_to_metric<2>(std::move(initial), goal, {}, all).value();
    std::printf("%.1f %% of the edges were of unit length, %.1f %% are; %zu triangles were %zu\n",
                100 * statistics.before.unit_share(), 100 * statistics.after.unit_share(), statistics.after.elements,
                statistics.before.elements);
    return statistics.after.unit_share() > 0.9 ? 0 : 1;
}
