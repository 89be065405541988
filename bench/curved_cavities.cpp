// Quadratic operations in a layer below a circle: a split, a collapse and a swap. The edges of the layer follow the
// circle.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "cavity_scene.hpp"
#include "curved_cavities.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;

namespace {

constexpr double inner = 0.45, outer = 1, opening = 5 * std::numbers::pi / 6;

/// Maps the unit square to a sector of a ring.
Vec<2> on_ring(const Vec<2>& p) {
    const double radius = inner + (outer - inner) * p[1];
    const double angle = std::numbers::pi / 2 + (0.5 - p[0]) * opening;
    return radius * Vec<2>{{std::cos(angle), std::sin(angle)}};
}

/// Returns a metric that requests long edges along the circle and short ones across it.
LogMetric<2> layer_metric(const Vec<2>& p) {
    const Vec<2> across = p / norm(p);
    return log_metric_of_sizes<2>({{0.35, 0.1}}, Mat<2>{{Vec<2>{{across[1], -across[0]}}, across}});
}

QuadraticMesh<2> bowed_layer(const Execution& execution) {
    BoxOptions<2> options;
    options.cells = {4, 4};
    options.jitter = 0.2;
    options.seed = 10;
    QuadraticMesh<2> mesh = must(elevate(must(generate(options)), execution));
    Buffer<Vec<2>> points(mesh.linear.points.begin(), mesh.linear.points.end());
    Buffer<LagrangeNode<2>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
    for (Vec<2>& p : points) p = on_ring(p);
    for (LagrangeNode<2>& node : nodes) node.point = on_ring(node.point);
    mesh.linear.points = std::move(points);
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

struct Layer {
    AdaptationGoal<2> goal;
    Adaptation<2> state;
};
Layer make_layer(const Execution& execution) {
    const QuadraticMesh<2> mesh = bowed_layer(execution);
    Buffer<LogMetric<2>> metrics(mesh.linear.points.size());
    for (std::size_t v = 0; v < metrics.size(); ++v) metrics[v] = layer_metric(mesh.linear.points[v]);
    Layer layer;
    layer.goal.field =
        must(make_back_mesh(mesh.linear, must(balls(mesh.linear, execution)), Column(std::move(metrics)), execution));
    layer.goal.geometry = Geometry<2>(AnalyticGeometry<2>{{{3, Sphere<2>{{}, inner}}, {4, Sphere<2>{{}, outer}}}});
    const FeatureOptions<2> breaks{.ridge_angle_degrees = 60};
    const auto features = must(find_features(mesh.linear, mesh.edges, breaks, execution));
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    layer.state = must(begin_adaptation(mesh, {features.edge_kinds.view(), corners}, layer.goal, execution));
    return layer;
}

/// Best candidate operation: one with elements whose straight form is inverted, otherwise the one with the best worst
/// shape.
class Best {
  public:
    explicit Best(const Layer& layer) : layer_(layer) {}
    void consider(const CavityRequest<2>& request, std::size_t min_elements, VertexId target = {}) {
        const OperationResult result = operate(layer_.state, layer_.goal, request, {}, workspace_, patch_);
        if (result.rejected != RejectionReason::none || patch_.patch().removed.elements.size() < min_elements) return;
        if (!(result.worst_shape > 0.3)) return;
        const double worth = result.worst_shape + (result.straight_inverted ? 1 : 0);
        if (!(worth > worth_)) return;
        worth_ = worth;
        best_ = patch_;
        target_ = target;
    }
    void print(const char* name) const {
        std::array<char, 40> more{};
        if (target_.valid()) std::snprintf(more.data(), more.size(), "\"goes\": %u,", target_.value);
        print_patch(name, layer_.state.mesh, best_.patch(), more.data());
    }

  private:
    const Layer& layer_;
    OperationWorkspace<2> workspace_;
    JudgedPatch<2> patch_, best_;
    double worth_ = 0;
    VertexId target_;
};

/// Splits an inner edge at its middle; the cavity grows from there.
void split_one(const Layer& layer) {
    const DynamicMesh<2>& mesh = layer.state.mesh;
    Best best(layer);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int k = 0; k < 3; ++k) {
            CavityRequest<2> request;
            cavity_of_edge(mesh, ElementId(e), k, request.cavity);
            const EdgeId edge = mesh.edges_of[ElementId(e)][k];
            const auto& [a, b] = mesh.edges[edge];
            const QuadraticEdge<2> curve{mesh.points[a], mesh.nodes[edge], mesh.points[b]};
            if (!request.cavity.facets.empty() || norm(curve.offset()) < 0.06 * norm(curve.chord())) continue;
            request.origin = midpoint(mesh.points[a], mesh.points[b]);
            request.place = curve.point(0.5);
            request.halves = {a, b};
            const FieldSample<2> sample = sample_with_recovered_gradient(layer.goal.field, request.place, {});
            request.metric = {sample.log_metric, sample.location.element};
            request.gradient = sample.gradient;
            request.fixed_element_count = request.cavity.elements.size();
            BentSpokes<2> spokes(layer.state, layer.goal);
            spokes.begin({request.place, &request.metric, &request.gradient});
            grow_delaunay(layer.state, spokes, 64, 0, request.cavity);
            best.consider(request, 4);
        }
    best.print("curved-insertion");
}

void collapse_one(const Layer& layer) {
    const DynamicMesh<2>& mesh = layer.state.mesh;
    Best best(layer);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        const VertexId v(i);
        if (mesh.states[v].place == VertexPlace::corner) continue;
        CavityRequest<2> request;
        cavity_of_vertex(mesh, v, request.cavity);
        for (const ElementId e : std::vector(request.cavity.elements))
            for (const VertexId w : mesh.elements.vertices[e])
                if (w != v) {
                    request.join_to(layer.state, w);
                    best.consider(request, 3, v);
                }
    }
    best.print("curved-collapse");
}

void swap_one(const Layer& layer) {
    const DynamicMesh<2>& mesh = layer.state.mesh;
    Best best(layer);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int k = 0; k < 3; ++k) {
            CavityRequest<2> request;
            cavity_of_edge(mesh, ElementId(e), k, request.cavity);
            if (!request.cavity.facets.empty()) continue;
            const auto [i, j] = local_edges<2>[k];
            request.join_to(layer.state, mesh.elements.vertices[ElementId(e)][3 - i - j]);
            best.consider(request, 2);
        }
    best.print("curved-swap");
}

}  // namespace

void print_curved_cavities(const Execution& execution) {
    const Layer layer = make_layer(execution);
    split_one(layer);
    collapse_one(layer);
    swap_one(layer);
}
