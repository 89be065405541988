module;
#include <array>
#include <cstddef>
#include <type_traits>
export module camber.operation:measures;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import :state;

export namespace camber {

/// The nodes of an element of degree 2.
template <int D>
[[nodiscard]] inline QuadraticNodes<D> nodes_of(const DynamicMesh<D>& mesh, ElementId e) {
    QuadraticNodes<D> nodes;
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.points[mesh.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) nodes[D + 1 + k] = mesh.nodes[mesh.edges_of[e][k]].point;
    return nodes;
}
/// Of a curved element, as metric_shape of a straight one: the power D/2 of its quality by the mean of its distortion.
template <int D>
[[nodiscard]] inline double curved_shape(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& metrics) {
    return shape_of_quality(curved_quality<D>(nodes, element_metric<D>(metrics)).mean, D);
}

/// How far the node of an edge of degree 2 is from the middle of its chord.
template <int D>
[[nodiscard]] inline Vec<D> offset_of(const DynamicMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges[edge];
    return mesh.nodes[edge].point - midpoint(mesh.points[a], mesh.points[b]);
}
template <int D>
[[nodiscard]] inline BentEnd<D> end_of(const VertexMetric<D>& metric) {
    return {metric.log_metric, metric.measure};
}

template <int D>
[[nodiscard]] inline EndSight<D> sight_of(const VertexMetric<D>& metric,
                                          const std::type_identity_t<LogGradient<D>>& gradient) {
    return {&metric.log_metric, &gradient, &metric.measure};
}

/// Of an edge of a surface alone to infinity: what nobody wants to change.
inline constexpr double length_to_infinity = 1;

/// The length of an edge in the metric, along its curve.
template <int D>
[[nodiscard]] inline double measured_length(const Adaptation<D>& r, EdgeId edge) {
    if (r.mesh.is_at_infinity(edge)) return length_to_infinity;
    const auto& [a, b] = r.mesh.edges[edge];
    if (r.mesh.is_curved())
        return bent_length<D>(end_of(r.vertices.metrics[a]), end_of(r.vertices.metrics[b]),
                              r.mesh.points[b] - r.mesh.points[a], offset_of(r.mesh, edge));
    return edge_length(r.vertices.metrics[a].measure, r.vertices.metrics[b].measure,
                       r.mesh.points[b] - r.mesh.points[a]);
}
/// The same, as it is known.
template <int D>
[[nodiscard]] inline double length_of(const Adaptation<D>& r, EdgeId edge) {
    return r.lengths.empty() ? measured_length(r, edge) : r.lengths[edge];
}
/// The shape of an element: metric_shape of a straight one, of a surface alone triangle_shape.
/// `point_at(i)`, `metric_at(i)` of the local vertices of an element.
template <int D>
[[nodiscard]] double straight_shape(const DynamicMesh<D>& mesh, auto&& point_at, auto&& metric_at) {
    if constexpr (D == 3)
        if (mesh.is_surface())
            return triangle_shape({point_at(0), point_at(1), point_at(2)}, {metric_at(0), metric_at(1), metric_at(2)});
    std::array<Vec<D>, D + 1> corners;
    std::array<const MeasuringMetric<D>*, D + 1> metrics;
    for (int i = 0; i <= D; ++i) {
        corners[i] = point_at(i);
        metrics[i] = metric_at(i);
    }
    return metric_shape<D>(corners, metrics);
}
template <int D>
[[nodiscard]] inline double straight_shape_of(const Adaptation<D>& r, ElementId e) {
    const auto& vertices = r.mesh.elements.vertices[e];
    return straight_shape(
        r.mesh, [&](int i) -> const Vec<D>& { return r.mesh.points[vertices[i]]; },
        [&](int i) { return &r.vertices.metrics[vertices[i]].measure; });
}
template <int D>
[[nodiscard]] inline double shape_of(const Adaptation<D>& r, ElementId e) {
    if (!r.mesh.is_curved()) return straight_shape_of(r, e);
    VertexLogMetrics<D> logs;
    for (int i = 0; i <= D; ++i) logs[i] = r.vertices.metrics[r.mesh.elements.vertices[e][i]].log_metric;
    return curved_shape<D>(nodes_of(r.mesh, e), logs);
}
/// The same, not measured again where it is known.
template <int D>
[[nodiscard]] inline double known_shape_of(const Adaptation<D>& r, ElementId e) {
    const double known = e.index() < r.shapes.size() ? r.shapes[e.index()] : -1.0;
    return known >= 0 ? known : shape_of(r, e);
}
/// Of a straight one, with a point in the place of a local vertex.
template <int D>
[[nodiscard]] inline double shape_with(const Adaptation<D>& r, ElementId e, int local, const Vec<D>& place,
                                       const MeasuringMetric<D>& metric) {
    const auto& vertices = r.mesh.elements.vertices[e];
    return straight_shape(
        r.mesh, [&](int i) -> const Vec<D>& { return i == local ? place : r.mesh.points[vertices[i]]; },
        [&](int i) { return i == local ? &metric : &r.vertices.metrics[vertices[i]].measure; });
}

/// How near to unit a mesh is.
struct UnitMeshStatistics {
    std::size_t edges = 0, unit_edges = 0, elements = 0;
    double shortest = 0, longest = 0, mean_length = 0;
    double worst_quality = 1, mean_quality = 0;
    [[nodiscard]] double unit_share() const {
        return edges == 0 ? 1 : static_cast<double>(unit_edges) / static_cast<double>(edges);
    }
};
template <int D>
[[nodiscard]] Outcome<UnitMeshStatistics> unit_mesh_statistics(const Adaptation<D>& r, const Execution& execution);

}  // namespace camber
