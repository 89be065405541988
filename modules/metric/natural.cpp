module;
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
struct WeightedLog {
    LogMetric<D> log_metric;
    double volume = 0;
};

template <int D>
WeightedLog<D> element_log_metric(const LinearMesh<D>& mesh, std::size_t e) {
    std::array<Vec<D>, D + 1> p;
    Mat<D> j;
    for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
    for (int i = 0; i < D; ++i) j.column[i] = p[i + 1] - p[0];
    return {natural_log_metric<D>(p), std::abs(det(j))};
}

}  // namespace

template <int D>
Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution) {
    auto of_elements =
        map_each(execution, mesh.elements.size(), [&](std::size_t e) { return element_log_metric(mesh, e); });
    if (!of_elements) return fail(of_elements.error());
    return map_each(execution, mesh.points.size(), [&](std::size_t v) {
        Sym<D> sum;
        double weight = 0;
        for (const ElementId e : balls[v]) {
            const auto& [log_metric, volume] = (*of_elements)[e.index()];
            if (!std::isfinite(trace(log_metric.l))) continue;  // flat: has no metric
            sum += volume * log_metric.l;
            weight += volume;
        }
        return LogMetric<D>{weight > 0 ? sum * (1 / weight) : sum};
    });
}

template Outcome<Buffer<LogMetric<2>>> natural_log_metrics<2>(const LinearMesh<2>&, const Incidence<ElementId>&,
                                                              const Execution&);
template Outcome<Buffer<LogMetric<3>>> natural_log_metrics<3>(const LinearMesh<3>&, const Incidence<ElementId>&,
                                                              const Execution&);

}  // namespace camber
