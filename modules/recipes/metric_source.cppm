module;
#include <functional>
#include <utility>
#include <variant>
export module camber.recipes:metric_source;
import camber.core;
import camber.metric;

export namespace camber {

/// A metric at the vertices of the mesh, one row a vertex. `make` gets the mesh's natural metric, empty where
/// `of_natural` says that it does not look. A mesh whose walls sag asks twice: for the mesh with its curves, and then
/// for the straight one.
template <int D>
struct MetricAtVertices {
    bool of_natural = true;
    std::function<Outcome<Column<LogMetric<D>>>(const Column<LogMetric<D>>& natural, const Execution&)> make;
};

/// A field with a mesh of its own, asked where it lies.
template <int D>
struct MetricField {
    std::function<Outcome<BackMesh<D>>(const Execution&)> make;
};

/// What edges follow.
template <int D>
using MetricSource = std::variant<MetricAtVertices<D>, MetricField<D>>;

/// The mesh's own (paper §1.2.1).
template <int D>
[[nodiscard]] MetricSource<D> natural_metric() {
    return MetricAtVertices<D>{
        true,
        [](const Column<LogMetric<D>>& natural, const Execution&) -> Outcome<Column<LogMetric<D>>> { return natural; }};
}

/// Given: one row a vertex.
template <int D>
[[nodiscard]] MetricSource<D> metric_at_vertices(Column<LogMetric<D>> log_metrics) {
    return MetricAtVertices<D>{
        false, [log_metrics = std::move(log_metrics)](const auto&, const Execution&) -> Outcome<Column<LogMetric<D>>> {
            return log_metrics;
        }};
}

}  // namespace camber
