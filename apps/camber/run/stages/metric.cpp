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

/// A field with elements to be read in, and where nodes of volume edges begin.
template <int D>
struct MadeField {
    BackMesh<D> back;
    std::optional<Column<LogMetric<D>>> straight;  ///< of the straight mesh, where the field is another
    Column<LagrangeNode<D>> nodes;
    MetricReport report;
    Notices notices;
};

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

template <int D>
Outcome<MadeField<D>> straight_field(MetricInput<D> input, const config::Pipeline& config, const Execution& execution) {
    const auto around = balls(input.mesh, part_of(execution, 0, 0.1));
    if (!around) return fail(around.error());
    if (asks_for_natural(input, config)) {
        auto natural = natural_log_metrics(input.mesh, *around, part_of(execution, 0.1, 0.5));
        if (!natural) return fail(natural.error());
        input.natural = std::move(*natural);
    }
    auto field = field_of<D>(input, config, part_of(execution, 0.5, 0.65));
    if (!field) return fail(field.error());
    auto back = make_back_mesh(input.mesh, *around, std::move(field->log_metrics), part_of(execution, 0.65, 1));
    if (!back) return fail(back.error());
    return MadeField<D>{std::move(*back), {}, {}, std::move(field->report), std::move(field->notices)};
}

/// The field of a mesh as it is, with its curves.
template <int D>
Outcome<MadeField<D>> curved_field(MetricInput<D> input, const QuadraticMesh<D>& mesh, const config::Pipeline& config,
                                   const Execution& execution) {
    const auto around = balls(mesh.linear, part_of(execution, 0, 0.1));
    if (!around) return fail(around.error());
    if (asks_for_natural(input, config)) {
        auto natural = curved_natural_log_metrics(mesh, *around, part_of(execution, 0.1, 0.5));
        if (!natural) return fail(natural.error());
        input.natural = std::move(natural->curved);
    }
    auto field = field_of<D>(input, config, part_of(execution, 0.5, 0.65));
    if (!field) return fail(field.error());
    auto back = make_curved_back_mesh(mesh, *around, std::move(field->log_metrics), part_of(execution, 0.65, 1),
                                      KeptGradients::recovered);
    if (!back) return fail(back.error());
    return MadeField<D>{std::move(*back), {}, {}, std::move(field->report), std::move(field->notices)};
}

/// The field of the mesh with its curves, and the metric of the one with straight edges.
template <int D>
struct BothFields {
    Field<D> carried;
    Column<LogMetric<D>> straight;
};
template <int D>
Outcome<BothFields<D>> both_fields(MetricInput<D> input, const QuadraticMesh<D>& bent,
                                   const Incidence<ElementId>& around, const config::Pipeline& config,
                                   const Execution& execution) {
    NaturalLogMetrics<D> natural;
    if (asks_for_natural(input, config)) {
        auto made = curved_natural_log_metrics(bent, around, part_of(execution, 0, 0.85));
        if (!made) return fail(made.error());
        natural = std::move(*made);
        input.natural = std::move(natural.curved);
    }
    auto carried = field_of<D>(input, config, part_of(execution, asks_for_natural(input, config) ? 0.85 : 0, 1));
    if (!carried) return fail(carried.error());
    const Column<LogMetric<D>> logs = carried->log_metrics;
    if (!asks_for_natural(input, config)) return BothFields<D>{std::move(*carried), logs};
    input.natural = std::move(natural.straight);
    auto straight = log_metrics_of(input, config, without_progress(execution));
    if (!straight) return fail(straight.error());
    return BothFields<D>{std::move(*carried), std::move(straight->log_metrics)};
}

template <int D>
Outcome<MadeField<D>> carried_field(const MetricInput<D>& input, const QuadraticMesh<D>& mesh,
                                    const CurveInput<D>& curves, CurvingAim aim, const config::Pipeline& config,
                                    const Execution& execution) {
    // Shares of the time with the natural metric, of shells with layers, 1 and 5 million elements.
    const auto around = balls(mesh.linear, part_of(execution, 0, 0.05));
    if (!around) return fail(around.error());
    QuadraticMesh<D> bent = mesh;
    bent.mid_nodes = curves.extended;
    auto fields = both_fields<D>(input, bent, *around, config, part_of(execution, 0.05, 0.37));
    if (!fields) return fail(fields.error());
    auto& [field, straight] = *fields;
    auto starts = noticeable_nodes(mesh, curves.extended.view(), field.log_metrics, part_of(execution, 0.37, 0.44));
    if (!starts) return fail(starts.error());
    Column<LagrangeNode<D>> nodes(std::move(*starts));
    auto carried = carried_nodes(mesh, nodes.view(), curves.shells, part_of(execution, 0.44, 0.64));
    if (!carried) return fail(carried.error());
    bent.mid_nodes = std::move(*carried);
    auto back =
        make_curved_back_mesh(std::move(bent), *around, std::move(field.log_metrics), part_of(execution, 0.64, 1),
                              aim == CurvingAim::accuracy ? KeptGradients::seen : KeptGradients::recovered);
    if (!back) return fail(back.error());
    return MadeField<D>{std::move(*back), std::move(straight), std::move(nodes), std::move(field.report),
                        std::move(field.notices)};
}

/// Volume edges start where the field has them.
template <int D>
Column<LagrangeNode<D>> starting_at(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                    Column<LagrangeNode<D>> nodes) {
    const bool is_carried = !nodes.empty();
    Buffer<LagrangeNode<D>> base = take(is_carried ? std::move(nodes) : input.base);
    for (std::size_t e = 0; e < base.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        if (input.kinds[e] != EdgeKind::volume)
            base[e] = input.base[e];
        else if (!is_carried)
            base[e] = {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    }
    return base;
}

/// The file whose field is asked where it lies, and not at the vertices first: nothing is done to it.
template <int D>
const MetricFile* whole_field(const Runner<D>& run) {
    if (run.state.inherited || !run.config.metric_operations.empty()) return nullptr;
    return file_with_mesh(run.config, run.files);
}
template <int D>
Outcome<MadeField<D>> given_field(const MetricFile& file, const Column<Vec<D>>& asked, const Execution& execution) {
    auto field = field_of_file<D>(file, asked, execution);
    if (!field) return fail(field.error());
    return MadeField<D>{std::move(field->back), {}, {}, std::move(field->report), std::move(field->notices)};
}

template <int D>
MetricInput<D> metric_input(const Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                            const Boundary<D>& boundary) {
    return {mesh,
            edges,
            boundary,
            run.state.given_points,
            run.files,
            {},
            run.state.inherited ? &*run.state.inherited : nullptr};
}

template <int D>
Outcome<OwnField<D>> told(Runner<D>& run, Outcome<MadeField<D>> made) {
    if (!made) return fail(made.error());
    run.report(made->report);
    run.report(made->notices);
    return OwnField<D>{std::move(made->back), std::move(made->report)};
}

}  // namespace

template <int D>
Outcome<OwnField<D>> make_own_field(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                    const Boundary<D>& boundary) {
    const MetricFile* const file = whole_field(run);
    auto made = run.step("metric", [&](const Execution& e) {
        if (file) return given_field<D>(*file, mesh.points, e);
        return straight_field<D>(metric_input(run, mesh, edges, boundary), run.config, e);
    });
    return told(run, std::move(made));
}

template <int D>
Outcome<OwnField<D>> make_own_field(Runner<D>& run, const QuadraticMesh<D>& mesh, const Boundary<D>& boundary) {
    const MetricFile* const file = whole_field(run);
    auto made = run.step("metric", [&](const Execution& e) {
        if (file) return given_field<D>(*file, mesh.linear.points, e);
        return curved_field<D>(metric_input(run, mesh.linear, mesh.edges, boundary), mesh, run.config, e);
    });
    return told(run, std::move(made));
}

template <int D>
Outcome<CurveInput<D>> make_field(Runner<D>& run, const Boundary<D>& boundary, CurveInput<D> input, CurvingAim aim) {
    const QuadraticMesh<D>& mesh = run.quadratic().mesh;
    // Hints are the mesh's own elements: another one's field is read at the vertices.
    const MetricFile* file = whole_field(run);
    if (file && file->mesh->of != MetricMesh::Of::input) file = nullptr;
    auto made = run.step("metric", [&](const Execution& e) {
        if (file) return given_field<D>(*file, mesh.linear.points, e);
        const MetricInput<D> from = metric_input(run, mesh.linear, mesh.edges, boundary);
        return input.extended.empty() ? straight_field<D>(from, run.config, e)
                                      : carried_field<D>(from, mesh, input, aim, run.config, e);
    });
    if (!made) return fail(made.error());
    run.report(made->report);
    run.report(made->notices);
    run.state.field = std::move(made->back);
    run.state.straight_log_metrics = std::move(made->straight);
    // Searches begin at the nodes that a mesh was read with; what is found without one is found anew.
    if (run.quadratic().nodes != NodesOf::file || aim == CurvingAim::accuracy)
        input.base = starting_at(mesh, input, std::move(made->nodes));
    return input;
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<OwnField<D>> make_own_field<D>(Runner<D>&, const LinearMesh<D>&, const EdgeSet<D>&,      \
                                                    const Boundary<D>&);                                      \
    template Outcome<OwnField<D>> make_own_field<D>(Runner<D>&, const QuadraticMesh<D>&, const Boundary<D>&); \
    template Outcome<CurveInput<D>> make_field<D>(Runner<D>&, const Boundary<D>&, CurveInput<D>, CurvingAim);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
