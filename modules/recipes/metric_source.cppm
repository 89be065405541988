module;
#include <cstdint>
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

/// Whether a metric is the mesh's own, or made of it.
enum class MetricOrigin : std::uint8_t { natural, given };
template <int D>
[[nodiscard]] MetricOrigin origin_of(const MetricSource<D>& metric) {
    const auto* const at_vertices = std::get_if<MetricAtVertices<D>>(&metric);
    return at_vertices != nullptr && at_vertices->of_natural ? MetricOrigin::natural : MetricOrigin::given;
}

/// How nodes for accuracy follow a metric: the mesh's own is noisy, others are taken at their word; a kind that is not
/// stated is known of the mesh's own.
[[nodiscard]] inline EdgeAccuracyOptions accuracy_for(MetricOrigin origin, const EdgeAccuracyOptions& asked) {
    EdgeAccuracyOptions options = asked;
    const bool is_natural = origin == MetricOrigin::natural;
    options.change = is_natural ? ChangeAlong::recovered : ChangeAlong::of_ends;
    if (is_natural && options.metric_kind == MetricKind::automatic) options.metric_kind = MetricKind::natural;
    return options;
}

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
