// Example of camber.solution_metric: the best metric for 2000 quadratic triangles in a boundary layer, from third
// derivatives of u = e^{−y/δ} + x³/10 on a square.
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.metric;
import camber.solution_metric;

using namespace camber;

static LinearMesh<2> square(std::size_t n) {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(j * (n + 1) + i); };
    for (std::size_t j = 0; j <= n; ++j)
        for (std::size_t i = 0; i <= n; ++i) {
            points.push_back(
                {{static_cast<double>(i) / static_cast<double>(n), static_cast<double>(j) / static_cast<double>(n)}});
            if (i == n || j == n) continue;
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(triangles.size(), 1);
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(triangles);
    return mesh;
}

static Outcome<bool> example(const Execution& execution) {
    const LinearMesh<2> mesh = square(32);
    constexpr double delta = 0.05;
    Buffer<CubicForm<2>> thirds(mesh.points.size());
    for (std::size_t v = 0; v < thirds.size(); ++v) {
        thirds[v] = {};
        thirds[v](0, 0, 0) = 0.6;
        thirds[v](1, 1, 1) = -camber::exp(-mesh.points[v][1] / delta) / (delta * delta * delta);
    }
    const auto models = cubic_models<2>(Column<CubicForm<2>>(std::move(thirds)), {}, execution);
    if (!models) return fail(models.error());
    const auto edges = unique_edges(mesh, execution);
    if (!edges) return fail(edges.error());
    SolutionMetricOptions options;
    options.amount = 2000;
    options.of = TargetQuantity::elements;
    options.max_size = 0.2;
    options.gradation = GradationOptions{.ratio = 2};
    const SolutionField<2> field{.models = models->rows, .norm = {.degree = 2, .p = 2}};
    const auto metric = make_solution_metric<2>(mesh, *edges, {&field, 1}, {}, options, execution);
    if (!metric) return fail(metric.error());
    std::printf("complexity %.1f of %.1f, after %d evaluations and %d gradations\n", metric->reached, metric->requested,
                metric->evaluations, metric->gradations);
    for (std::size_t row = 0; row <= 32; row += 8) {
        const Sym<2> l = metric->log_metrics[row * 33 + 16].l;
        std::printf("y = %.2f   sizes %.4f along, %.4f across\n", mesh.points[row * 33][1], camber::exp(-l(0, 0) / 2),
                    camber::exp(-l(1, 1) / 2));
    }
    return metric->is_reached && anisotropy(metric->log_metrics[16]) > 5;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
