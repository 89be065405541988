module;
#include <algorithm>
#include <array>
#include <cstddef>
module camber.operation:node_gain;
import camber.core;
import camber.cavity;
import camber.metric;
import :state;

/// Whether nodes come nearer to where they are wanted (AdaptationGoal::wanted).
namespace camber {

/// Whether a node moves noticeably to get there: in the metric, and of what it is short of its place.
template <int D>
[[nodiscard]] bool is_noticeable(const Adaptation<D>& r, const AdaptationGoal<D>& goal, EdgeId edge, const Vec<D>& to) {
    constexpr double length = 1e-3, share = 0.05;
    const Vec<D>& here = r.mesh.nodes[edge].point;
    return std::ranges::any_of(r.mesh.edges[edge], [&](VertexId v) {
        const MeasuringMetric<D>& metric = r.vertices.metrics[v].measure;
        const double least =
            std::max(length * length, share * share * metric.length_squared(goal.wanted[edge].point - here));
        return metric.length_squared(to - here) > least;
    });
}

/// Whether a patch that keeps its edges moves a node of its point noticeably, or brings one to its place.
template <int D>
[[nodiscard]] bool gains(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch) {
    for (const ElementId e : patch.removed.elements) {
        const auto& vertices = r.mesh.elements.vertices[e];
        const int at = local_vertex(vertices, patch.point.vertex);
        for (int i = 0; i <= D; ++i) {
            if (i == at) continue;
            const auto spoke = std::ranges::find(patch.star.boundary, vertices[i]) - patch.star.boundary.begin();
            const EdgeId edge = r.mesh.edges_of[e][edge_between<D>[i][at]];
            const LagrangeNode<D>& node = patch.nodes[static_cast<std::size_t>(spoke)];
            const bool arrives = node == goal.wanted[edge] && node != r.mesh.nodes[edge];
            if (arrives || is_noticeable(r, goal, edge, node.point)) return true;
        }
    }
    return false;
}

}  // namespace camber
