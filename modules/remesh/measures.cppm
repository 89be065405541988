module;
#include <array>
#include <cstddef>
export module camber.remesh:measures;
import camber.core;
import camber.metric;
import camber.dynamic;
import :state;

export namespace camber {

/// The length of an edge in the metric, and the metric_shape of an element.
template <int D>
[[nodiscard]] inline double length_of(const Remeshing<D>& r, EdgeId edge) {
    const auto& [a, b] = r.mesh.edges[edge];
    return edge_length(r.metrics[a].measure, r.metrics[b].measure, r.mesh.points[b] - r.mesh.points[a]);
}
template <int D>
[[nodiscard]] inline double shape_of(const Remeshing<D>& r, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    std::array<const MeasuringMetric<D>*, D + 1> metrics;
    const auto& vertices = r.mesh.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        corners[i] = r.mesh.points[vertices[i]];
        metrics[i] = &r.metrics[vertices[i]].measure;
    }
    return metric_shape<D>(corners, metrics);
}
/// The same with a point in the place of a local vertex.
template <int D>
[[nodiscard]] inline double shape_with(const Remeshing<D>& r, ElementId e, int local, const Vec<D>& place,
                                       const MeasuringMetric<D>& metric) {
    std::array<Vec<D>, D + 1> corners;
    std::array<const MeasuringMetric<D>*, D + 1> metrics;
    const auto& vertices = r.mesh.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        corners[i] = i == local ? place : r.mesh.points[vertices[i]];
        metrics[i] = i == local ? &metric : &r.metrics[vertices[i]].measure;
    }
    return metric_shape<D>(corners, metrics);
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
[[nodiscard]] Outcome<UnitMeshStatistics> unit_mesh_statistics(const Remeshing<D>& r, const Execution& execution);

}  // namespace camber
