module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.curving;
import camber.metric;
import camber.recipes;
import :parts;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// A field at the vertices of a mesh, after the config's operations.
template <int D>
struct Field {
    Column<LogMetric<D>> log_metrics;
    MetricReport report;
    Notices notices;
};

/// The metric that a mesh was remeshed by, at its vertices: the operations are done.
template <int D>
SourcedMetric<D> inherited_metric(const Inherited<D>& inherited) {
    return {inherited.log_metrics,
            MetricReport{.source = inherited.metric.source, .gradations = inherited.metric.gradations},
            {}};
}

template <int D>
Outcome<SourcedMetric<D>> log_metrics_of(const MetricInput<D>& input, const config::Pipeline& config,
                                         const Execution& execution) {
    if (input.inherited) return inherited_metric(*input.inherited);
    auto made = make_log_metrics(input, config.metric, part_of(execution, 0, 0.3));
    if (made) return apply_operations(std::move(*made), input, config.metric_operations, part_of(execution, 0.3, 1));
    Error& error = made.error();
    if (error.kind == ErrorKind::usage && error.where.empty()) error.where = "/metric";
    return made;
}

template <int D>
Outcome<Field<D>> field_of(const MetricInput<D>& input, const config::Pipeline& config, const Execution& execution) {
    const LinearMesh<D>& mesh = input.mesh;
    auto made = log_metrics_of(input, config, part_of(execution, 0, 0.5));
    if (!made) return fail(made.error());
    const auto volume = complexity(mesh, made->log_metrics, part_of(execution, 0.5, 0.85));
    if (!volume) return fail(volume.error());
    made->report.complexity = *volume;
    const auto largest = largest_anisotropy(made->log_metrics, part_of(execution, 0.85, 1));
    if (!largest) return fail(largest.error());
    made->report.largest_anisotropy = *largest;
    return Field<D>{std::move(made->log_metrics), std::move(made->report), std::move(made->notices)};
}

/// Whether the config asks for the mesh's own metric: that is another where the mesh has curves, no other is.
template <int D>
bool asks_for_natural(const MetricInput<D>& input, const config::Pipeline& config) {
    if (input.inherited) return false;
    const auto is_natural = [](const config::Metric& m) { return std::holds_alternative<config::NaturalMetric>(m); };
    return is_natural(config.metric) ||
           std::ranges::any_of(config.metric_operations, [&](const config::MetricOperation& operation) {
               const auto* intersect = std::get_if<config::Intersect>(&operation);
               return intersect != nullptr && is_natural(intersect->metric);
           });
}

/// The file whose field is asked where it lies, and not at the vertices first: nothing is done to it.
template <int D>
const MetricFile* whole_field(const Runner<D>& run) {
    if (run.state.inherited || !run.config.metric_operations.empty()) return nullptr;
    return file_with_mesh(run.config, run.files);
}

template <int D>
MetricSource<D> field_of_whole(const MetricFile& file, const Column<Vec<D>>& asked, MetricTold& told) {
    return MetricField<D>{[&file, asked, &told](const Execution& e) -> Outcome<BackMesh<D>> {
        auto field = field_of_file<D>(file, asked, e);
        if (!field) return fail(field.error());
        told = {std::move(field->report), std::move(field->notices)};
        return std::move(field->back);
    }};
}

/// Told of once: a second one is of the same mesh with straight edges.
template <int D>
MetricSource<D> at_vertices(const Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                            const Boundary<D>& boundary, MetricTold& told) {
    const MetricInput<D> input{mesh,
                               edges,
                               boundary,
                               run.state.given_points,
                               run.files,
                               {},
                               run.state.inherited ? &*run.state.inherited : nullptr};
    const config::Pipeline& config = run.config;
    return MetricAtVertices<D>{
        asks_for_natural(input, config),
        [input, &config, &told](const Column<LogMetric<D>>& natural,
                                const Execution& e) -> Outcome<Column<LogMetric<D>>> {
            MetricInput<D> with_natural = input;
            with_natural.natural = natural;
            if (told.report) return log_metrics_of(with_natural, config, e).map(&SourcedMetric<D>::log_metrics);
            auto field = field_of(with_natural, config, e);
            if (!field) return fail(field.error());
            told = {std::move(field->report), std::move(field->notices)};
            return std::move(field->log_metrics);
        }};
}

template <int D>
MetricSource<D> metric_for_passes(const Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                  const Boundary<D>& boundary, MetricTold& told) {
    const MetricFile* const file = whole_field(run);
    return file ? field_of_whole<D>(*file, mesh.points, told) : at_vertices(run, mesh, edges, boundary, told);
}

template <int D>
Outcome<OwnField<D>> own_field(Runner<D>& run, const auto& mesh, const MetricSource<D>& source, MetricTold& told) {
    auto made = run.step("metric", [&](const Execution& e) { return make_field(mesh, source, e); });
    if (!made) return fail(made.error());
    MetricReport report = *told.report;
    report_metric(run, std::move(told));
    return OwnField<D>{std::move(*made), std::move(report), origin_of(source)};
}

}  // namespace

template <int D>
void report_metric(Runner<D>& run, MetricTold told) {
    if (told.report) run.report(*told.report);
    run.report(told.notices);
}

template <int D>
MetricSource<D> metric_for_curving(const Runner<D>& run, const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                   MetricTold& told) {
    // Hints are the mesh's own elements: another one's field is read at the vertices.
    const MetricFile* const file = whole_field(run);
    const bool is_of_input = file && file->mesh->of == MetricMesh::Of::input;
    return is_of_input ? field_of_whole<D>(*file, mesh.linear.points, told)
                       : at_vertices(run, mesh.linear, mesh.edges, boundary, told);
}

template <int D>
Outcome<OwnField<D>> make_own_field(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                    const Boundary<D>& boundary) {
    MetricTold told;
    return own_field<D>(run, mesh, metric_for_passes(run, mesh, edges, boundary, told), told);
}

template <int D>
Outcome<OwnField<D>> make_own_field(Runner<D>& run, const QuadraticMesh<D>& mesh, const Boundary<D>& boundary) {
    MetricTold told;
    return own_field<D>(run, mesh, metric_for_passes(run, mesh.linear, mesh.edges, boundary, told), told);
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template void report_metric<D>(Runner<D>&, MetricTold);                                                       \
    template MetricSource<D> metric_for_curving<D>(const Runner<D>&, const QuadraticMesh<D>&, const Boundary<D>&, \
                                                   MetricTold&);                                                  \
    template Outcome<OwnField<D>> make_own_field<D>(Runner<D>&, const LinearMesh<D>&, const EdgeSet<D>&,          \
                                                    const Boundary<D>&);                                          \
    template Outcome<OwnField<D>> make_own_field<D>(Runner<D>&, const QuadraticMesh<D>&, const Boundary<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
