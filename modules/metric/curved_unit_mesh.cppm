module;
#include <span>
export module camber.metric:curved_unit_mesh;
import camber.core;
import camber.bezier;
import :distortion;
import :distortion_bound;
import :spd;

/// How near to unit the curves and the curved elements of a mesh of degree 2 are, in a metric that is known at its
/// vertices; of straight meshes see :unit_mesh.
export namespace camber {

/// Element e by its nodes, and the metric at its vertices.
template <int D>
struct ElementInMetric {
    QuadraticNodes<D> nodes;
    VertexLogMetrics<D> metrics;
};
template <int D>
[[nodiscard]] inline ElementInMetric<D> element_in_metric(const QuadraticMesh<D>& mesh,
                                                          std::span<const LogMetric<D>> log_metrics, ElementId e) {
    ElementInMetric<D> element;
    const auto& vertices = mesh.linear.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        element.nodes[i] = mesh.linear.points[vertices[i]];
        element.metrics[i] = log_metrics[vertices[i].index()];
    }
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        element.nodes[D + 1 + k] = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
    return element;
}

/// Lengths along the edges, one each (bent_length). Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Buffer<double>> bent_lengths(const QuadraticMesh<D>& mesh,
                                                   std::span<const LogMetric<D>> log_metrics,
                                                   const Execution& execution);

/// Lengths along the edges, one each; mean qualities (CurvedQuality) of the elements and bounds of their least.
struct CurvedMeasures {
    Buffer<double> lengths, qualities;
    Buffer<LeastQuality> least;
};

/// The bounds are refined where they might be the mesh's lowest: by `bisections` at most, until they are above the
/// lowest quality attained anywhere or near their own. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CurvedMeasures> measure_curved(const QuadraticMesh<D>& mesh,
                                                     std::span<const LogMetric<D>> log_metrics, int bisections,
                                                     const Execution& execution);

}  // namespace camber
