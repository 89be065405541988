module;
#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.metric;
import :parts;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// A field at the vertices of the straight mesh, after the config's operations.
template <int D>
struct Field {
    BackMesh<D> back;
    MetricReport report;
    Notices notices;
};

template <int D>
Outcome<double> largest_anisotropy(const Column<LogMetric<D>>& field, const Execution& execution) {
    return reduce_each(
        execution, field.size(), 1.0, [&](double& most, std::size_t v) { most = std::max(most, anisotropy(field[v])); },
        [](double a, double b) { return std::max(a, b); });
}

template <int D>
Outcome<Field<D>> field_of(const MetricInput<D>& input, const config::Metric& metric,
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
    made = apply_operations(std::move(*made), input, operations, execution);
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

}  // namespace

template <int D>
Outcome<Done> make_field(Runner<D>& run, const Boundary<D>& boundary) {
    auto made = run.step("metric", [&](const Execution& e) {
        const MetricInput<D> input{run.quadratic().mesh, boundary, run.state.given_points, run.files};
        return field_of<D>(input, run.config.metric, run.config.metric_operations, e);
    });
    if (!made) return fail(made.error());
    run.tell(made->report);
    run.tell(made->notices);
    run.state.field = std::move(made->back);
    return Done{};
}

template Outcome<Done> make_field<2>(Runner<2>&, const Boundary<2>&);
template Outcome<Done> make_field<3>(Runner<3>&, const Boundary<3>&);

}  // namespace camber::run
