module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.ordering;
import camber.metric;
import camber.validity;
import camber.io;
import camber.shapes;
import camber.surface;
import camber.cad;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;
import camber.stages;
import camber.distributed;

namespace camber::run {

namespace {

Error at(Error error, const std::string& path) {
    if (error.where.empty() && error.kind == ErrorKind::usage) error.where = path;
    return error;
}

template <int D>
MeshReport mesh_report(const Mesh<D>& m) {
    const std::size_t facets = m.facets.template of<simplex<D - 1>>().size();
    return {D, m.degree, m.points.size(), count_nodes(m), count_elements(m), facets, m.edges.size()};
}

template <int D>
MeshReport mesh_report(const FinishedRows<D>& rows) {
    const PartTotals& all = rows.totals;
    return {D, 1, all.vertices, all.vertices, all.elements, all.facets, all.edges};
}

template <int D>
Outcome<MeshFields> shown_fields(Runner<D>& run, const std::optional<EdgeLengths>& lengths) {
    if (!shows_fields(run.config.output)) return MeshFields{};
    return run.step("fields", [&](const Execution& e) -> Outcome<MeshFields> {
        const auto* const end = std::get_if<Quadratic<D>>(&run.state.mesh);
        if (!end) return MeshFields{};
        return mesh_fields(*end, run.field(), lengths, e);
    });
}

template <int D>
Outcome<std::optional<Solution>> output_metric(Runner<D>& run) {
    if (run.config.output.metric.empty()) return std::nullopt;
    const auto some = [](Solution result) { return std::optional(std::move(result)); };
    const auto* const end = std::get_if<Quadratic<D>>(&run.state.mesh);
    if (const auto& inherited = run.state.inherited; inherited && (run.field() == nullptr || inherited->field))
        return run.step("fields", [&](const Execution& e) {
            return (end && inherited->field ? metric_solution(*inherited->field, end->mesh, e)
                                            : metric_solution<D>(inherited->log_metrics, e))
                .map(some);
        });
    if (run.field() == nullptr) {
        if (!config::is_in_memory(run.config.output.metric))
            run.note("no stage made a metric: " + run.config.output.metric + " was not written");
        return std::nullopt;
    }
    const bool at_nodes = end && file_with_mesh(run.config, run.files);
    return run.step("fields", [&](const Execution& e) {
        return (at_nodes ? metric_solution(*run.field(), end->mesh, e) : metric_solution(*run.field(), e)).map(some);
    });
}

template <int D>
Mesh<D> taken_mesh(State<D>& state) {
    if (auto* end = std::get_if<Quadratic<D>>(&state.mesh)) return as_mesh(std::move(end->mesh));
    return as_mesh(std::move(std::get<LinearMesh<D>>(state.mesh)));
}

template <int D, class Options>
Outcome<Done> finish_and_apply(Runner<D>& run, const Options& stage) {
    if constexpr (!changes_topology<Options>())
        if (auto done = finish(run); !done) return done;
    return apply(run, stage);
}

template <int D>
Outcome<GeometrySource> source_in_unit(const Mesh<D>& mesh, const config::Geometry& geometry, GeometrySource source,
                                       const StepWrapper& around) {
    const auto* const cad = std::get_if<config::Cad>(&geometry);
    if (!cad || cad->unit != CadUnit::automatic) return source;
    return run_step(around, "unit", [&](const Execution& e) {
        return in_unit_of_mesh(geometry, std::move(source), straight_simplices(mesh), e);
    });
}

template <int D>
struct PreparedRun {
    std::vector<MetricFile> files;
    Notices notices;
    std::optional<BetterOrder> order;
    State<D> state;
    RunSources<D> sources;
};
template <int D>
Outcome<PreparedRun<D>> prepared_run(StageInputs<D> input, RunSources<D> sources, const config::Pipeline& pipeline,
                                     std::span<const config::Stage> stages, const StepWrapper& around) {
    auto sound = run_step(around, "prepare", [&](const Execution& e) {
        return prepare_stage(std::move(input), stages, sources.ordering, e);
    });
    if (!sound) return fail(sound.error());
    auto geometry = source_in_unit(sound->inputs.mesh, pipeline.geometry, std::move(sources.geometry), around);
    if (!geometry) return fail(geometry.error());
    sources.geometry = std::move(*geometry);
    auto state = beginning_with(std::move(sound->inputs.mesh));
    if (!state) return fail(state.error());
    return PreparedRun<D>{std::move(sound->inputs.files), std::move(sound->notices), std::move(sound->order),
                          std::move(*state), std::move(sources)};
}

template <int D>
Outcome<MeshRun<D>> end_of(Runner<D>& run) {
    if (auto done = finish(run); !done) return fail(done.error());
    const auto lengths = measure(run);
    if (!lengths) return fail(lengths.error());
    auto fields = shown_fields(run, *lengths);
    if (!fields) return fail(fields.error());
    auto metric = output_metric(run);
    if (!metric) return fail(metric.error());
    MeshRun<D> result;
    result.rows = std::move(run.state.rows);
    if (!result.rows) result.mesh = taken_mesh(run.state);
    run.report.mesh = result.rows ? mesh_report(*result.rows) : mesh_report(result.mesh);
    result.remeshed = std::move(run.state.inherited);
    result.fields = std::move(*fields);
    result.metric = std::move(*metric);
    result.report = std::move(run.report);
    return result;
}

template <int D>
Outcome<MeshRun<D>> run_prepared(PreparedRun<D> prepared, const config::Pipeline& pipeline, const StepWrapper& around) {
    Runner<D> run(pipeline, std::move(prepared.state), std::move(prepared.sources), prepared.files, around);
    run.report.notices = prepared.notices;
    if (auto done = move_vertices(run); !done) return fail(done.error());
    for (std::size_t i = 0; i < pipeline.stages.size(); ++i) {
        auto done = std::visit([&](const auto& stage) { return finish_and_apply(run, stage); }, pipeline.stages[i]);
        if (!done) return fail(at(done.error(), "/stages/" + std::to_string(i)));
    }
    return end_of(run);
}

}  // namespace

template <int D>
Outcome<MeshRun<D>> run_steps(StageInputs<D> input, const config::Pipeline& pipeline, RunSources<D> sources,
                              const StepWrapper& around) {
    if (auto order = check_order(pipeline.stages, input.mesh.degree); !order) return fail(order.error());
    auto prepared = prepared_run(std::move(input), std::move(sources), pipeline, pipeline.stages, around);
    if (!prepared) return fail(prepared.error());
    const std::optional<BetterOrder> order = std::move(prepared->order);
    auto run = run_prepared(std::move(*prepared), pipeline, around);
    if (!order) return run;
    if (!run) return fail(in_input_order<D>(run.error(), order->renumbering));
    run->report.reordered = ReorderedReport{order->scatter};
    return run_step(around, "renumber",
                    [&](const Execution& e) { return in_input_order(std::move(*run), order->renumbering, e); });
}

namespace {

/// All metrics with rows: of files (moved out of the inputs), and made for the solution.
struct MetricRows {
    std::vector<MetricFile> files;
    std::optional<SolutionMetricReport> solution_report;  ///< of the last metric that was made
    Notices notices;
};

MetricFile file_of(NamedField metric, const config::SolutionMetric& requested, const AnyMesh& mesh) {
    const auto width = static_cast<std::size_t>(metric.field.components);
    const int dimension = std::visit([]<int D>(const Mesh<D>&) { return D; }, mesh);
    MetricFile file{"the solution's metric",
                    Solution{dimension, {metric.kind}, metric.field.values.size() / width, metric.field.values},
                    {},
                    requested};
    if (metric.field.degree == 2) file.mesh = {mesh, MetricMesh::Of::input};
    return file;
}

Error of_solution(Error error, const std::string& path, const std::string& file) {
    if (error.kind == ErrorKind::usage && !error.where.starts_with("/"))
        error.where = error.where.empty() || error.where == "solution" ? path : path + "/" + error.where;
    if (error.kind == ErrorKind::input && error.where.empty()) error.where = file;
    return error;
}

Outcome<MetricRows> metric_rows(const config::Pipeline& pipeline, Inputs& inputs, const StepWrapper& around) {
    MetricRows rows{std::move(inputs.operands), {}, {}};
    if (inputs.metric)
        rows.files.push_back({std::get<config::FilePath>(pipeline.metric).path, std::move(*inputs.metric),
                              std::move(inputs.metric_mesh)});
    for (const SolutionMetricInput& input : inputs.solution_metrics) {
        auto result = metric_of_fields(inputs.mesh.mesh, inputs.fields, input.requested, input.intersect,
                                       pipeline.features.ridge_angle, around);
        if (!result) return fail(of_solution(result.error(), input.path, pipeline.solution.file));
        std::ranges::move(solution_metric_notices(result->report), std::back_inserter(rows.notices));
        rows.solution_report = result->report;
        rows.files.push_back(file_of(std::move(result->metric), input.requested, inputs.mesh.mesh));
        rows.files.back().bounds = std::move(result->bounds);
    }
    return rows;
}

Outcome<Done> carry(Run& run, const AnyMesh& old_mesh, std::vector<NamedField> fields, const config::Pipeline& pipeline,
                    const StepWrapper& around) {
    auto carried = transfer_fields(run.mesh, old_mesh, std::move(fields), pipeline.solution, around);
    if (!carried) return fail(of_solution(carried.error(), "/solution", pipeline.solution.file));
    const bool is_evaluated = !pipeline.solution.expression.empty();
    run.solution = is_evaluated && plan_size(run.mesh).degree == 1 ? at_vertices(run.mesh, std::move(carried->fields))
                                                                   : std::move(carried->fields);
    run.report.transfer = std::move(carried->report);
    return Done{};
}

/// True if all nodes are at the middles of chords, up to the digits of text files: relative to the coordinates, which
/// may be large, and to the chords.
template <int D>
bool has_straight_edges(const Mesh<D>& mesh) {
    constexpr double of_places = 1e-15, of_chords = 1e-12;
    for (std::size_t e = 0; e < mesh.edge_nodes.size(); ++e) {
        const auto& [a, b] = mesh.entities.edges[e];
        const Vec<D>&p = mesh.points[a], &q = mesh.points[b];
        if (distance(mesh.edge_nodes[e].point, midpoint(p, q)) >
            of_places * (norm(p) + norm(q)) + of_chords * distance(p, q))
            return false;
    }
    return true;
}

/// Converts a quadratic mesh without curves to a straight one if the stages start from that. Solvers use such meshes.
void take_as_straight(const config::Pipeline& pipeline, DecodedMesh& mesh) {
    if (pipeline.stages.empty() || !std::holds_alternative<config::Elevate>(pipeline.stages.front())) return;
    const bool is_straight =
        std::visit([](const auto& m) { return m.degree == 2 && has_straight_edges(m); }, mesh.mesh);
    if (!is_straight) return;
    std::visit([](auto& m) { m = as_mesh(straight_simplices(std::move(m))); }, mesh.mesh);
    mesh.notices.push_back({"the mesh is of degree 2 and straight: new nodes of its edges are computed"});
}

template <int D>
Outcome<std::optional<Growth>> growth_on(StageInputs<D> input, const config::Pipeline& pipeline, RunSources<D> sources,
                                         const StepWrapper& around) {
    if (auto order = check_order(pipeline.stages, input.mesh.degree); !order) return fail(order.error());
    const auto first = std::ranges::find_if(
        pipeline.stages, [](const config::Stage& s) { return !std::holds_alternative<config::Elevate>(s); });
    const auto changes = []<class S>(const S&) { return changes_topology<S>(); };
    if (first == pipeline.stages.end() || !std::visit(changes, *first)) return std::nullopt;
    auto prepared = prepared_run(std::move(input), std::move(sources), pipeline, pipeline.stages, around);
    if (!prepared) return fail(prepared.error());
    Runner<D> run(pipeline, std::move(prepared->state), std::move(prepared->sources), prepared->files, around);
    if (auto done = move_vertices(run); !done) return fail(done.error());
    if (first != pipeline.stages.begin())
        if (auto done = apply(run, std::get<config::Elevate>(pipeline.stages.front())); !done)
            return fail(done.error());
    return requested_growth(run);
}

template <int D>
Outcome<MetricResult> metric_on(StageInputs<D> input, const config::Pipeline& pipeline, RunSources<D> sources,
                                const StepWrapper& around) {
    sources.ordering = {.min_elements = max_entities};
    auto prepared = prepared_run(std::move(input), std::move(sources), pipeline, {}, around);
    if (!prepared) return fail(prepared.error());
    Runner<D> run(pipeline, std::move(prepared->state), std::move(prepared->sources), prepared->files, around);
    run.report.notices = std::move(prepared->notices);
    auto field = requested_field(run);
    if (!field) return fail(field.error());
    auto rows = run.step("fields", [&](const Execution& e) { return metric_solution(field->back, e); });
    if (!rows) return fail(rows.error());
    return MetricResult{std::move(*rows), std::move(field->report), std::move(run.report.notices)};
}

template <int D>
Run run_of(MeshRun<D> result) {
    Run run{std::move(result.mesh), std::move(result.report), std::move(result.fields), std::move(result.metric)};
    if (result.rows) run.rows = std::move(*result.rows);
    return run;
}

template <int D>
RunSources<D> sources_of(Inputs& inputs, const SolutionSource* solution) {
    return {.geometry = std::move(inputs.geometry),
            .memory = std::move(inputs.memory),
            .solution = solution,
            .ranks = inputs.ranks,
            .end = inputs.end,
            .ordering = inputs.ordering};
}

}  // namespace

Outcome<MetricResult> compute_metric(const config::Pipeline& pipeline, Inputs inputs, const StepWrapper& around) {
    auto rows = metric_rows(pipeline, inputs, around);
    if (!rows) return fail(rows.error());
    const Notices of_rows = rows->notices;
    auto result = std::visit(
        [&]<int D>(Mesh<D> mesh) {
            return metric_on(StageInputs<D>{std::move(mesh), std::move(rows->files)}, pipeline,
                             sources_of<D>(inputs, nullptr), around);
        },
        std::move(inputs.mesh.mesh));
    if (result) std::ranges::copy(of_rows, std::back_inserter(result->notices));
    return result;
}

Outcome<std::optional<Growth>> planned_growth(const config::Pipeline& pipeline, Inputs inputs,
                                              const StepWrapper& around) {
    auto rows = metric_rows(pipeline, inputs, around);
    if (!rows) return fail(rows.error());
    take_as_straight(pipeline, inputs.mesh);
    return std::visit(
        [&]<int D>(Mesh<D> mesh) {
            return growth_on(StageInputs<D>{std::move(mesh), std::move(rows->files)}, pipeline,
                             sources_of<D>(inputs, nullptr), around);
        },
        std::move(inputs.mesh.mesh));
}

bool is_curved(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return !has_straight_edges(m); }, mesh);
}

const MeshFormat* format_of(const config::Output& output) {
    if (output.mesh.empty()) return nullptr;
    if (output.partition > 0 && output.mesh.ends_with(".pvtu")) return format_with_name(mesh_formats(), "vtu");
    return output.format.empty() ? format_with_extension(mesh_formats(), output.mesh)
                                 : format_with_name(mesh_formats(), output.format);
}

bool shows_fields(const config::Output& output) {
    const MeshFormat* const format = format_of(output);
    return !output.vtu.empty() || !output.page.empty() || (format != nullptr && format->for_viewers);
}

bool carries_fields(const config::Output& output) {
    const MeshFormat* const format = format_of(output);
    return !output.solution.empty() || !output.vtu.empty() || (format != nullptr && format->has_fields);
}

bool places_by_solution(const config::Pipeline& pipeline) {
    return std::ranges::any_of(pipeline.stages, [](const config::Stage& stage) {
        const auto* const curve = std::get_if<config::Curve>(&stage);
        return curve != nullptr && curve->objective == Objective::solution;
    });
}

bool may_end_in_rows(const config::Pipeline& pipeline) {
    const config::Output& output = pipeline.output;
    const char* const written_by_rows = output.partition > 0 ? ".pvtu" : ".meshb";
    const bool is_rows =
        output.mesh.ends_with(written_by_rows) && output.format.empty() && !config::is_in_memory(output.mesh);
    const bool is_alone = output.vtu.empty() && output.metric.empty() && output.solution.empty() &&
                          output.plots.empty() && output.page.empty();
    return is_rows && is_alone && required_distances(pipeline).empty() && !pipeline.stages.empty() &&
           std::holds_alternative<config::Remesh>(pipeline.stages.back());
}

bool preserves_elements(const config::Pipeline& pipeline) {
    const auto preserves = []<class Options>(const Options&) { return !changes_topology<Options>(); };
    return std::ranges::all_of(pipeline.stages,
                               [&](const config::Stage& stage) { return std::visit(preserves, stage); });
}

namespace {

void name_places(Report& report, const FileNumbers& numbers) {
    const int dimension = report.mesh.is_standalone_surface() ? 2 : report.mesh.dimension;
    for (RemainingReport& r : report.remaining) {
        const RemainingElement left{{}, r.reason, VertexId(r.at > 0 ? r.at - 1 : 0), r.is_unresolved};
        const RemainingElement without_position{{}, r.reason, {}, r.is_unresolved};
        r.reason =
            r.at > 0 ? sentence_of(left, fmt::format("{}", numbers(r.at - 1))) : sentence_of(without_position, {});
        r.tag = numbers.tag(dimension, r.element);
    }
    for (auto* const validity : {&report.validity_before, &report.validity})
        if (*validity) (*validity)->worst_tag = numbers.tag(dimension, (*validity)->worst);
    if (!report.boundary) return;
    for (auto* const deviation : {&report.boundary->node_deviation, &report.boundary->vertex_deviation})
        if (*deviation)
            for (std::size_t& v : (*deviation)->vertices)
                if (v != 0) v = numbers(v - 1);
}

}  // namespace

Outcome<Run> run_pipeline(const config::Pipeline& pipeline, Inputs inputs, const StepWrapper& around) {
    auto rows = metric_rows(pipeline, inputs, around);
    if (!rows) return fail(rows.error());
    const bool carries = !inputs.fields.empty() && carries_fields(pipeline.output);
    const std::optional<AnyMesh> specified = carries ? std::optional(inputs.mesh.mesh) : std::nullopt;
    std::optional<SolutionSource> solution;
    if (places_by_solution(pipeline))
        solution = {inputs.mesh.mesh, inputs.fields, pipeline.solution.expression, pipeline.solution.weights};
    take_as_straight(pipeline, inputs.mesh);
    const FileNumbers numbers = numbers_of(inputs.mesh);
    auto run = std::visit(
        [&]<int D>(Mesh<D> mesh) {
            return run_steps(StageInputs<D>{std::move(mesh), std::move(rows->files)}, pipeline,
                             sources_of<D>(inputs, solution ? &*solution : nullptr), around)
                .map([](MeshRun<D> result) { return run_of(std::move(result)); });
        },
        std::move(inputs.mesh.mesh));
    if (!run) return run;
    run->report.solution_metric = rows->solution_report;
    std::ranges::move(rows->notices, std::back_inserter(run->report.notices));
    if (specified)
        if (auto done = carry(*run, *specified, std::move(inputs.fields), pipeline, around); !done)
            return fail(done.error());
    for (Notice& notice : inputs.mesh.notices) run->report.notices.push_back(std::move(notice.what));
    name_places(run->report, preserves_elements(pipeline) ? numbers : FileNumbers{});
    return run;
}

Outcome<DecodedMesh> generate_shape(const config::Shape& shape, const Execution& execution) {
    return std::visit(
        [&](const auto& options) -> Outcome<DecodedMesh> {
            auto mesh = generate(options, execution);
            if (!mesh) return fail(mesh.error());
            return DecodedMesh{as_mesh(std::move(*mesh)), {}};
        },
        shape);
}

namespace {

template <int D>
Outcome<MeshRun<D>> run_recipe(Mesh<D> mesh, const MeshGoal<D>& goal, const config::Pipeline& pipeline,
                               const StepWrapper& around) {
    RunSources<D> sources;
    sources.goal = &goal;
    sources.ordering.min_elements = max_entities;  // no reordering: rows and facets of the goal refer to the input's
                                                   // order
    return run_steps(StageInputs<D>{std::move(mesh)}, pipeline, std::move(sources), around);
}

}  // namespace

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<MeshRun<D>> run_steps<D>(StageInputs<D>, const config::Pipeline&, RunSources<D>, \
                                              const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

namespace camber {

template <int D>
Outcome<run::MeshRun<D>> curve_mesh(Mesh<D> mesh, const MeshGoal<D>& goal, const CurveMeshOptions& options,
                                    const StepWrapper& around) {
    config::Pipeline pipeline;
    config::Curve curve;
    static_cast<ProposeOptions&>(curve) = options.curve;
    pipeline.stages = {config::Elevate{}, curve, config::Validate{options.repair.min_scaled_jacobian}, options.repair,
                       config::Commit{}};
    return run::run_recipe(std::move(mesh), goal, pipeline, around);
}

template <int D>
Outcome<run::MeshRun<D>> remesh_mesh(Mesh<D> mesh, const MeshGoal<D>& goal, const RemeshMeshOptions& options,
                                     const StepWrapper& around) {
    config::Pipeline pipeline;
    config::Remesh remesh;
    static_cast<ToMetricOptions&>(remesh) = options.passes;
    remesh.objective = options.objective;
    pipeline.stages = {remesh};
    pipeline.geometry_bound = options.geometry_bound;
    return run::run_recipe(std::move(mesh), goal, pipeline, around);
}

#define CAMBER_INSTANTIATE(D)                                                                               \
    template Outcome<run::MeshRun<D>> curve_mesh<D>(Mesh<D>, const MeshGoal<D>&, const CurveMeshOptions&,   \
                                                    const StepWrapper&);                                    \
    template Outcome<run::MeshRun<D>> remesh_mesh<D>(Mesh<D>, const MeshGoal<D>&, const RemeshMeshOptions&, \
                                                     const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
