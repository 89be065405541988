module;
#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.metric;
import :stages;
import :state;

namespace camber::run {

namespace {

template <int D>
Outcome<double> largest_anisotropy(const Column<LogMetric<D>>& field, const Execution& execution) {
    return reduce_each(
        execution, field.size(), 1.0, [&](double& most, std::size_t v) { most = std::max(most, anisotropy(field[v])); },
        [](double a, double b) { return std::max(a, b); });
}

}  // namespace

template <int D>
Outcome<Field<D>> metric_stage(const MetricInput<D>& input, const config::Metric& metric,
                               std::span<const config::MetricOperation> operations, const Execution& execution) {
    const LinearMesh<D>& mesh = input.mesh.linear;
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto made = make_log_metrics(input, metric, execution);
    if (!made) {
        Error error = made.error();
        if (error.kind == ErrorKind::usage && error.where.empty()) error.where = "/metric";
        return fail(std::move(error));
    }
    made = operated(std::move(*made), input, operations, execution);
    if (!made) return fail(made.error());
    const auto volume = complexity(mesh, made->log_metrics, execution);
    if (!volume) return fail(volume.error());
    made->report.complexity = *volume;
    const auto largest = largest_anisotropy(made->log_metrics, execution);
    if (!largest) return fail(largest.error());
    made->report.largest_anisotropy = *largest;
    auto back = make_back_mesh(mesh, *around, std::move(made->log_metrics), execution);
    if (!back) return fail(back.error());
    return Field<D>{std::move(*back), std::move(made->report), std::move(made->notices)};
}

#define CAMBER_INSTANTIATE(D)                                                                \
    template Outcome<Field<D>> metric_stage<D>(const MetricInput<D>&, const config::Metric&, \
                                               std::span<const config::MetricOperation>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
