module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
Outcome<Buffer<double>> bent_lengths(const QuadraticMesh<D>& mesh, std::span<const LogMetric<D>> log_metrics,
                                     const Execution& execution) {
    const auto metrics = map_each(part_of(execution, 0, 0.5), log_metrics.size(),
                                  [&](std::size_t v) { return MeasuringMetric<D>(log_metrics[v]); });
    if (!metrics) return fail(metrics.error());
    const auto end = [&](VertexId v) { return BentEnd<D>{log_metrics[v.index()], (*metrics)[v.index()]}; };
    return map_each(part_of(execution, 0.5, 1), mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Vec<D>& p = mesh.linear.points[a];
        const Vec<D>& q = mesh.linear.points[b];
        return bent_length<D>(end(a), end(b), q - p, mesh.mid_nodes[e].point - midpoint(p, q));
    });
}

template <int D>
Outcome<CurvedMeasures> measure_curved(const QuadraticMesh<D>& mesh, std::span<const LogMetric<D>> log_metrics,
                                       int bisections, const Execution& execution) {
    auto lengths = bent_lengths(mesh, log_metrics, part_of(execution, 0, 0.1));
    if (!lengths) return fail(lengths.error());
    const std::size_t n = mesh.linear.elements.size();
    auto qualities = map_each(part_of(execution, 0.1, 0.2), n, [&](std::size_t e) {
        const ElementInMetric<D> element = element_in_metric<D>(mesh, log_metrics, ElementId(e));
        return curved_quality<D>(element.nodes, element_metric<D>(element.metrics));
    });
    if (!qualities) return fail(qualities.error());
    const auto look = [&](std::size_t e, const BoundEffort& effort) {
        const ElementInMetric<D> element = element_in_metric<D>(mesh, log_metrics, ElementId(e));
        LeastQuality found = bound_quality<D>(element.nodes, element.metrics, effort);
        found.attained = std::min(found.attained, (*qualities)[e].least);
        found.bound = std::min(found.bound, found.attained);
        return found;
    };
    auto least =
        map_each(part_of(execution, 0.2, 0.5), n, [&](std::size_t e) { return look(e, BoundEffort{.bisections = 0}); });
    if (!least) return fail(least.error());
    double lowest = 1;
    for (const LeastQuality& found : *least) lowest = std::min(lowest, found.attained);
    auto refined = each(part_of(execution, 0.5, 1), n, [&](std::size_t e) {
        LeastQuality& found = (*least)[e];
        if (lowest > 0 && found.bound < lowest) found = look(e, {.enough = lowest, .bisections = bisections});
    });
    if (!refined) return fail(refined.error());
    auto means = map_each(without_progress(execution), n, [&](std::size_t e) { return (*qualities)[e].mean; });
    if (!means) return fail(means.error());
    return CurvedMeasures{std::move(*lengths), std::move(*means), std::move(*least)};
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<Buffer<double>> bent_lengths<D>(const QuadraticMesh<D>&, std::span<const LogMetric<D>>,        \
                                                     const Execution&);                                             \
    template Outcome<CurvedMeasures> measure_curved<D>(const QuadraticMesh<D>&, std::span<const LogMetric<D>>, int, \
                                                       const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
