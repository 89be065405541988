// Example of camber.operation: a cavity operation moves the hub of a wheel of ten triangles to the centre. `operate`
// creates and checks the new elements; `commit` applies them.
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <utility>

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;

using namespace camber;

int main() {
    const Execution all;
    Buffer<Vec<2>> points(11);
    Buffer<SimplexVertices<2>> triangles(10);
    Buffer<SimplexVertices<1>> rim(10);
    for (std::size_t i = 0; i < 10; ++i) {
        const double angle = static_cast<double>(i) * std::numbers::pi / 5;
        points[i] = {{camber::cos(angle), camber::sin(angle)}};
        rim[i] = {VertexId(i), VertexId((i + 1) % 10)};
        triangles[i] = {VertexId(10), rim[i][0], rim[i][1]};
    }
    points[10] = {{0.8, 0}};
    LinearMesh<2> wheel;
    wheel.points = std::move(points);
    wheel.elements = {std::move(triangles), Buffer<Reference>(10, 1), {}};
    wheel.facets = {std::move(rim), Buffer<Reference>(10, 1), {}};
    Buffer<LogMetric<2>> metrics(11, log_metric_of_sizes<2>({{1, 1}}));
    const AdaptationGoal<2> goal{make_back_mesh<2>(wheel, balls(wheel, all).value(), std::move(metrics), all).value(),
                                 {}};
    Adaptation<2> state = begin_adaptation(wheel, unique_edges(wheel, all).value(), {}, goal, all).value();
    const auto worst = [&] { return unit_mesh_statistics(state, all).value().worst_quality; };
    const double before = worst();

    const VertexId hub(std::size_t{10});
    CavityRequest<2> request;
    cavity_of_vertex(state.mesh, hub, request.cavity);
    request.join_to(state, hub);
    request.place = {};
    OperationWorkspace<2> workspace;
    JudgedPatch<2> patch;
    const OperationResult result = operate(state, goal, request, {}, workspace, patch);
    if (result.rejected != RejectionReason::none) return 1;
    state = commit<2>(std::move(state), {patch}).value().state;
    std::printf("the worst quality was %.2f and is %.2f\n", before, worst());
    return worst() > before ? 0 : 1;
}
