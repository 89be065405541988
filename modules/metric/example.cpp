// Example of camber.metric: a metric field is graded and scaled to a number of triangles.
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.metric;

using namespace camber;

/// Returns the unit square: n × n cells of two triangles.
static LinearMesh<2> square(std::size_t n) {
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const double h = 1 / static_cast<double>(n);
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(i + (n + 1) * j); };
    for (std::size_t j = 0; j <= n; ++j)
        for (std::size_t i = 0; i <= n; ++i) {
            points.push_back({{h * static_cast<double>(i), h * static_cast<double>(j)}});
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
    const LinearMesh<2> mesh = square(20);
    const auto edges = unique_edges(mesh, execution);
    if (!edges) return fail(edges.error());
    // Fields store log M, since only logarithms are interpolated; `LogMetric` and `Metric` are two types. Vertex 0
    // requests a size of 0.002 along x. All other sizes are 0.1.
    auto logs = map_each(execution, mesh.points.size(), [&](std::size_t v) {
        return log_metric_of_sizes<2>({{v == 0 ? 0.002 : 0.1, 0.1}}, Mat<2>::identity());
    });
    if (!logs) return fail(logs.error());
    const Column<LogMetric<2>> field(std::move(*logs));
    const auto graded = apply_gradation(mesh, *edges, field, {.ratio = 1.3}, execution);
    if (!graded) return fail(graded.error());
    const auto scaled = scale_to_complexity(mesh, graded->log_metrics, 1000, execution);
    if (!scaled) return fail(scaled.error());
    const auto reached = complexity(mesh, *scaled, execution);
    const auto around = balls(mesh, execution);
    if (!reached) return fail(reached.error());
    if (!around) return fail(around.error());

    const auto back = make_back_mesh(mesh, *around, *scaled, execution);
    if (!back) return fail(back.error());
    const auto near = sample_value(*back, Vec<2>{{0.01, 0.01}}, ElementId(std::size_t{0}));
    std::printf("gradation changed %zu of %zu vertices in %d sweeps\n", graded->changed, mesh.points.size(),
                graded->sweeps);
    std::printf("complexity %.6f, anisotropy at the vertex %.1f, beside it %.1f\n", *reached,
                anisotropy((*scaled)[VertexId(std::size_t{0})]), anisotropy(near.log_metric));
    return graded->converged && graded->changed > 0 && std::abs(*reached - 1000) < 1e-6 &&
           anisotropy(near.log_metric) < anisotropy((*scaled)[VertexId(std::size_t{0})]);
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
