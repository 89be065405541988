// Prints cavities before and after an operation as JSON for docs/pictures/draw_cavities.py: the Delaunay cavity of an
// inserted point in an anisotropic mesh, a collapse and a swap in 2D, the shell of an edge in 3D, and curved cavities.
// This program is not a timed test.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <utility>
#include <vector>

#include "cavity_scene.hpp"
#include "curved_cavities.hpp"
#include "insertion.hpp"

import camber.core;
import camber.metric;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;

namespace {

/// Returns a metric with the given sizes along a direction and across it.
LogMetric<2> metric_of(const Vec<2>& sizes) {
    const double angle = std::numbers::pi / 6;
    const Mat<2> axes{{Vec<2>{{std::cos(angle), std::sin(angle)}}, Vec<2>{{-std::sin(angle), std::cos(angle)}}}};
    return log_metric_of_sizes<2>(sizes, axes);
}

/// A square whose edges have unit length in a metric of the given sizes.
struct Square {
    AdaptationGoal<2> goal;
    Adaptation<2> state;
};
Square unit_square(const Vec<2>& sizes, const Execution& execution) {
    BoxOptions<2> options;
    options.cells = {12, 12};
    const LinearMesh<2> mesh = must(generate(options));
    Buffer<LogMetric<2>> metrics(mesh.points.size(), metric_of(sizes));
    Square square;
    square.goal.field = must(make_back_mesh(mesh, must(balls(mesh, execution)), Column(std::move(metrics)), execution));
    square.state = must(begin_adaptation(mesh, must(unique_edges(mesh, execution)), {}, square.goal, execution));
    square.state = must(remesh_to_metric<2>(std::move(square.state), square.goal, {}, execution)).state;
    return square;
}

CavityRequest<2> insertion_request(const Square& square, const Vec<2>& place) {
    CavityRequest<2> request;
    request.cavity = testing::insertion(square.state.mesh, place).value().cavity;
    request.fixed_element_count = request.cavity.elements.size();
    request.place = place;
    request.metric = {metric_of({{0.32, 0.08}}), ElementId{}};
    BentSpokes<2> spokes(square.state, square.goal);
    spokes.begin({place, &request.metric});
    grow_delaunay(square.state, spokes, 64, 0, request.cavity);
    return request;
}

/// Inserts a point with an anisotropic metric into an isotropic mesh. Among the positions near the middle with a large
/// cavity, the one farthest from the surrounding vertices is used.
void insert_one(const Square& square) {
    OperationWorkspace<2> workspace;
    JudgedPatch<2> patch, best;
    double farthest = 0;
    CavityRequest<2> best_request;
    for (int i = 0; i <= 50; ++i)
        for (int j = 0; j <= 50; ++j) {
            const CavityRequest<2> request = insertion_request(square, {{0.25 + 0.01 * i, 0.25 + 0.01 * j}});
            if (operate(square.state, square.goal, request, {}, workspace, patch).rejected != RejectionReason::none)
                continue;
            double near = 1;
            for (const VertexId v : patch.patch().star.boundary)
                near = std::min(near, distance(square.state.mesh.points[v], request.place));
            if (!(near > farthest) || patch.patch().removed.elements.size() < 8) continue;
            farthest = near;
            best = patch;
            best_request = request;
        }
    // Rows of the root R of the metric: the unit ellipse is |R (x − p)| = 1.
    const auto& rows = best_request.metric.measure.rows;
    std::array<char, 160> ellipse{};
    std::snprintf(ellipse.data(), ellipse.size(), "\"root\": [[%.6f, %.6f], [%.6f, %.6f]],", rows[0][0], rows[0][1],
                  rows[1][0], rows[1][1]);
    print_patch("insertion", square.state.mesh, best.patch(), ellipse.data());
}

/// Returns the inner vertex nearest to a position.
VertexId inner_vertex(const DynamicMesh<2>& mesh, const Vec<2>& place) {
    VertexId best;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (!mesh.is_free(VertexId(v)) && mesh.states[v].place == VertexPlace::inside)
            if (!best.valid() || distance(mesh.points[v], place) < distance(mesh.points[best], place))
                best = VertexId(v);
    return best;
}

/// Collapses the vertex onto the neighbour for which the worst new element is best.
void collapse_one(const Square& square, const Vec<2>& place) {
    const DynamicMesh<2>& mesh = square.state.mesh;
    const VertexId v = inner_vertex(mesh, place);
    JudgedPatch<2> patch, best;
    double best_shape = 0;
    CavityRequest<2> request;
    cavity_of_vertex(mesh, v, request.cavity);
    OperationWorkspace<2> workspace;
    for (const ElementId e : request.cavity.elements)
        for (const VertexId w : mesh.elements.vertices[e]) {
            if (w == v) continue;
            request.join_to(square.state, w);
            const OperationResult result = operate(square.state, square.goal, request, {}, workspace, patch);
            if (result.rejected != RejectionReason::none || !(result.worst_shape > best_shape)) continue;
            best_shape = result.worst_shape;
            best = patch;
        }
    std::array<char, 40> more{};
    std::snprintf(more.data(), more.size(), "\"goes\": %u,", v.value);
    print_patch("collapse", mesh, best.patch(), more.data());
}

/// Swaps the edge of an element whose swap gives the best elements.
void swap_one(const Square& square, const Vec<2>& place) {
    const ElementId e = testing::locate(square.state.mesh, place).value().element;
    JudgedPatch<2> patch, best;
    double best_shape = 0;
    OperationWorkspace<2> workspace;
    for (int k = 0; k < 3; ++k) {
        CavityRequest<2> request;
        cavity_of_edge(square.state.mesh, e, k, request.cavity);
        if (!request.cavity.facets.empty()) continue;
        const auto [i, j] = local_edges<2>[k];
        request.join_to(square.state, square.state.mesh.elements.vertices[e][3 - i - j]);
        const OperationResult result = operate(square.state, square.goal, request, {}, workspace, patch);
        if (result.rejected != RejectionReason::none || !(result.worst_shape > best_shape)) continue;
        best_shape = result.worst_shape;
        best = patch;
    }
    print_patch("swap", square.state.mesh, best.patch(), "");
}

/// Connects the tetrahedra around an edge to a vertex of the ring around it.
void swap_in_space() {
    constexpr std::size_t n = 5;
    Buffer<Vec<3>> points;
    points.push_back({{0.05, 0, -1}});
    points.push_back({{-0.05, 0.05, 1}});
    Buffer<SimplexVertices<3>> elements;
    Buffer<SimplexVertices<2>> facets;
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / n + 0.3;
        points.push_back({{std::cos(angle), std::sin(angle), 0.12 * std::cos(2 * angle)}});
        const VertexId a(2 + i);
        const VertexId b(2 + (i + 1) % n);
        const VertexId low(std::size_t{0});
        const VertexId high(std::size_t{1});
        elements.push_back({low, high, a, b});
        facets.push_back({low, a, b});
        facets.push_back({high, b, a});
    }
    LinearMesh<3> mesh;
    mesh.points = std::move(points);
    mesh.elements = {std::move(elements), Buffer<Reference>(n, 1), {}};
    mesh.facets = {std::move(facets), Buffer<Reference>(2 * n, 1), {}};
    const DynamicMesh<3> dynamic = must(make_dynamic(mesh, must(unique_edges(mesh, {})), {}, {}));
    Patch<3> patch{dynamic.stamp, {VertexId(3)}, {}, {}};
    cavity_of_edge(dynamic, ElementId(0), 0, patch.removed);
    StarWorkspace<3> workspace;
    if (star(dynamic, patch.removed, patch.point.vertex, workspace, patch.star) != StarFailure::none) std::exit(1);
    print_patch("shell", dynamic, patch, "");
}

}  // namespace

int main() {
    const Execution execution;
    std::printf("{");
    insert_one(unit_square({{0.14, 0.14}}, execution));
    const Square square = unit_square({{0.36, 0.12}}, execution);
    collapse_one(square, {{0.5, 0.5}});
    swap_one(square, {{0.5, 0.52}});
    swap_in_space();
    print_curved_cavities(execution);
    std::printf("}\n");
    return 0;
}
