module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.ordering;
import camber.metric;
import camber.solution_metric;
import camber.validity;
import camber.soundness;
import camber.io;
import camber.fields;
import camber.surface;
import camber.repair;
import camber.stages;

namespace camber::run {

namespace {

template <int D>
SourcedMetric<D> sourced(Column<LogMetric<D>> logs, std::string source) {
    return {std::move(logs), MetricReport{.source = std::move(source), .gradations = {}}, {}};
}

template <int D>
Outcome<LogMetric<D>> constant_log_metric(const config::ConstantMetric& constant) {
    if (!constant.sizes.empty()) {
        if (constant.sizes.size() != 1 && constant.sizes.size() != D)
            return fail(ErrorKind::usage, "expected 1 or " + std::to_string(D) + " sizes", "/metric/constant/sizes");
        Vec<D> sizes;
        for (std::size_t i = 0; i < D; ++i) sizes[i] = constant.sizes[constant.sizes.size() == 1 ? 0 : i];
        return log_metric_of_sizes(sizes);
    }
    if (constant.tensor.size() != sym_size<D>)
        return fail(ErrorKind::usage, "expected " + std::to_string(sym_size<D>) + " numbers",
                    "/metric/constant/tensor");
    auto logs = log_metrics_of_tensors<D>(constant.tensor, TensorPrecision::eight_bytes, Execution{.threads = 1});
    if (!logs) return fail(ErrorKind::usage, logs.error().what, "/metric/constant/tensor");
    return logs->log_metrics.front();
}

}  // namespace

template <int D>
Outcome<SourcedMetric<D>> log_metrics_of_file(const MetricFile& file, std::size_t vertices,
                                              const Execution& execution) {
    const Solution& s = file.solution;
    const auto refuse = [&](const std::string& what, const std::string& remedy) {
        return fail(ErrorKind::input, what, file.name, {}, remedy);
    };
    if (s.dimension != D)
        return refuse("is in " + std::to_string(s.dimension) + "D, the mesh in " + std::to_string(D) + "D",
                      "give the metric of this mesh");
    if (s.rows != vertices)
        return refuse("has " + std::to_string(s.rows) + " rows, the mesh " + std::to_string(vertices) + " vertices",
                      "give the metric of this mesh, one row per vertex");
    if (s.fields == std::vector{FieldKind::scalar}) {
        // One size per vertex is an isotropic metric, as in Mmg and refine.
        Buffer<LogMetric<D>> logs(vertices);
        for (std::size_t v = 0; v < vertices; ++v) {
            if (!(s.values[v] > 0) || !std::isfinite(s.values[v]))
                return fail(ErrorKind::input, "is not a positive size", file.name, Entity{"size at vertex", v + 1});
            logs[v] = {-2 * log(s.values[v]) * Sym<D>::identity()};
        }
        return sourced(Column<LogMetric<D>>(std::move(logs)), file.name);
    }
    if (s.fields != std::vector{FieldKind::symmetric_tensor})
        return refuse("is no metric: it must have one symmetric tensor (type 3) or one size (type 1) per vertex", "");
    auto logs = log_metrics_of_tensors<D>(
        s.values.view(), s.single_precision ? TensorPrecision::four_bytes : TensorPrecision::eight_bytes, execution);
    if (!logs) {
        Error error = logs.error();
        error.where = file.name;
        return fail(std::move(error));
    }
    SourcedMetric<D> metric = sourced(Column<LogMetric<D>>(std::move(logs->log_metrics)), file.name);
    metric.report.floored = logs->floored;
    if (logs->floored > 0)
        metric.notices.push_back(
            fmt::format("{} of the {} tensors of {} are flat to the rounding of their numbers. The sizes in their flat "
                        "directions were reduced to the largest that rounding can resolve",
                        logs->floored, vertices, file.name));
    return metric;
}

namespace {

/// Evaluates a field, known at the vertices as read, at their current positions.
template <int D>
Outcome<Column<LogMetric<D>>> at_moved_vertices(Column<LogMetric<D>> field, const MetricInput<D>& input,
                                                const Execution& execution) {
    const Column<Vec<D>>& points = input.mesh.points;
    if (points == input.input_points) return field;
    LinearMesh<D> specified = input.mesh;
    specified.points = input.input_points;
    const auto around = balls(specified, part_of(execution, 0, 0.2));
    if (!around) return fail(around.error());
    const auto back = make_back_mesh(specified, *around, field, part_of(execution, 0.2, 0.7));
    if (!back) return fail(back.error());
    auto moved = map_each(part_of(execution, 0.7, 1), points.size(), [&](std::size_t v) {
        if (points[v] == specified.points[v] || (*around)[v].empty()) return field[v];
        return sample_value(*back, points[v], (*around)[v].front()).log_metric;
    });
    if (!moved) return fail(moved.error());
    return Column<LogMetric<D>>(std::move(*moved));
}

/// Files are already read.
template <int D>
struct Source {
    const MetricInput<D>& input;
    const Execution& execution;

    Outcome<SourcedMetric<D>> operator()(const config::NaturalMetric&) const {
        return sourced(input.natural, "natural");
    }
    Outcome<SourcedMetric<D>> operator()(const config::ConstantMetric& constant) const {
        const auto value = constant_log_metric<D>(constant);
        if (!value) return fail(value.error());
        Buffer<LogMetric<D>> logs(input.mesh.points.size());
        std::fill(logs.begin(), logs.end(), *value);
        return sourced(Column<LogMetric<D>>(std::move(logs)), "constant");
    }
    Outcome<SourcedMetric<D>> operator()(const config::SurfaceMetric& surface) const {
        return sourced_metric(make_surface_metric(surface, input, execution), "surface");
    }
    Outcome<SourcedMetric<D>> operator()(const config::FieldMetric& field) const {
        return sourced_metric(make_field_metric(field, input.mesh, execution), "field");
    }
    Outcome<SourcedMetric<D>> operator()(const MetricExpression& expression) const {
        return sourced_metric(log_metrics_of<D>(expression, input.mesh.points.view(), execution), "expression");
    }
    Outcome<SourcedMetric<D>> operator()(const config::SizesMetric& requested) const {
        auto sizes = sizes_by_reference(input.mesh, requested.sizes);
        if (!sizes) return fail(sizes.error());
        return sourced_metric(within_domain({std::move(*sizes)}), "sizes");
    }
    Outcome<SourcedMetric<D>> operator()(const config::GeometryMetric& requested) const {
        auto sizes = geometry_sizes(input.mesh, input.boundary.features, requested, diameter(input.mesh),
                                    part_of(execution, 0, 0.8));
        if (!sizes) return fail(sizes.error());
        return sourced_metric(within_domain(*sizes), "geometry");
    }
    Outcome<SourcedMetric<D>> operator()(const config::FilePath& path) const { return rows_of(path); }
    Outcome<SourcedMetric<D>> operator()(const config::SolutionMetric& solution) const { return rows_of(solution); }

  private:
    [[nodiscard]] Outcome<SourcedMetric<D>> rows_of(const config::Metric& requested) const {
        const auto file = std::ranges::find_if(input.files, [&](const MetricFile& f) { return f.is_of(requested); });
        if (file == input.files.end()) return fail(ErrorKind::internal, "the rows of the metric were not read");
        if (file->mesh) return sampled_file<D>(*file, input.mesh.points, execution);
        auto metric = log_metrics_of_file<D>(*file, input.mesh.points.size(), part_of(execution, 0, 0.6));
        if (!metric) return metric;
        auto here = at_moved_vertices(std::move(metric->log_metrics), input, part_of(execution, 0.6, 1));
        if (!here) return fail(here.error());
        metric->log_metrics = std::move(*here);
        return metric;
    }
    /// Elsewhere the size is that of the domain.
    [[nodiscard]] Outcome<Column<LogMetric<D>>> within_domain(const std::vector<MetricsAtVertices<D>>& sizes) const {
        return fixed_metric<D>(input.mesh, sizes, {}, diameter(input.mesh), without_progress(execution));
    }
    static Outcome<SourcedMetric<D>> sourced_metric(Outcome<Column<LogMetric<D>>> logs, const char* source) {
        if (!logs) return fail(logs.error());
        return sourced(std::move(*logs), source);
    }
};

}  // namespace

template <int D>
Outcome<SourcedMetric<D>> make_log_metrics(const MetricInput<D>& input, const config::Metric& metric,
                                           const Execution& execution) {
    auto result = std::visit(Source<D>{input, execution}, metric);
    if (!result || std::holds_alternative<config::NaturalMetric>(metric)) return result;
    if (auto sizes = check_sizes(result->log_metrics, without_progress(execution)); !sizes) {
        Error error = sizes.error();
        const auto* file = std::get_if<config::FilePath>(&metric);
        if (file) error.where = file->path;
        if (!file && error.kind == ErrorKind::input) error.kind = ErrorKind::usage;
        return fail(std::move(error));
    }
    return result;
}

template Outcome<SourcedMetric<2>> log_metrics_of_file<2>(const MetricFile&, std::size_t, const Execution&);
template Outcome<SourcedMetric<3>> log_metrics_of_file<3>(const MetricFile&, std::size_t, const Execution&);

namespace {

/// Prepares the mesh in the faster order. None if there are messages on the mesh, which refer to the input's order.
template <int D>
Outcome<std::optional<Sound<D>>> sound_in_order(const StageInputs<D>& specified, BetterOrder order,
                                                const Execution& execution) {
    auto inputs = in_working_order(specified, order.renumbering, part_of(execution, 0, 0.2));
    if (!inputs) return fail(inputs.error());
    auto result = prepare(std::move(inputs->mesh), part_of(execution, 0.2, 1));
    if (!result || !result->notices.empty()) return std::nullopt;
    return Sound<D>{{std::move(result->mesh), std::move(inputs->files)}, {}, std::move(order)};
}

}  // namespace

template <int D>
Outcome<Sound<D>> prepare_stage(StageInputs<D> specified, std::span<const config::Stage> stages,
                                const OrderingOptions& ordering, const Execution& execution) {
    auto order = working_order(specified, stages, ordering, part_of(execution, 0, 0.02));
    if (!order) return fail(order.error());
    const bool is_bad = order->has_value();
    if (is_bad) {
        auto sound = sound_in_order(specified, std::move(**order), part_of(execution, 0.02, 0.9));
        if (!sound) return fail(sound.error());
        if (*sound) return std::move(**sound);
    }
    auto result = prepare(std::move(specified.mesh), part_of(execution, is_bad ? 0.9 : 0.02, 1));
    if (!result) return fail(result.error());
    specified.mesh = std::move(result->mesh);
    Sound<D> sound{std::move(specified), std::move(result->notices), {}};
    if (!is_bad) return sound;
    // The order is computed again, since elements may have been removed.
    auto now = working_order(sound.inputs, stages, ordering, without_progress(execution));
    if (!now) return fail(now.error());
    if (!*now) return sound;
    auto inputs = in_working_order(std::move(sound.inputs), (*now)->renumbering, without_progress(execution));
    if (!inputs) return fail(inputs.error());
    return Sound<D>{std::move(*inputs), std::move(sound.notices), std::move(*now)};
}

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Elevate& options) {
    auto mesh =
        run.step_of(options, [&](const Execution& e) { return elevate(std::get<LinearMesh<D>>(run.state.mesh), e); });
    if (!mesh) return fail(mesh.error());
    run.state.mesh = Quadratic<D>{std::move(*mesh), NodesOf::elevation, Unplanned<D>{}};
    return Done{};
}

namespace {

/// Nodes of a curved input mesh as a plan, with the features of its boundary.
template <int D>
struct Adopted {
    OwnNodes<D> own;
    Proposal<D> proposal;
    BoundaryReport report;
};
template <int D>
Outcome<Adopted<D>> own_nodes(const QuadraticMesh<D>& mesh, const BoundaryOptions<D>& options,
                              const Execution& execution) {
    auto features = find_features(mesh.linear, mesh.edges, options.features, execution);
    if (!features) return fail(features.error());
    Proposal<D> proposal = proposal_from_mesh(mesh, features->edge_kinds, options.required);
    const BoundaryReport report{
        features->surface_edges, features->ridge_edges, features->corners, features->patch_count, {}, {}};
    return Adopted<D>{{std::move(*features)}, std::move(proposal), report};
}

/// The same with prescribed surfaces, onto which the boundary's nodes move.
template <int D>
Outcome<Plan<D>> own_nodes_on_geometry(Runner<D>& run) {
    const QuadraticMesh<D>& mesh = run.quadratic().mesh;
    const std::span<const LagrangeNode<D>> curves(mesh.mid_nodes.data(), mesh.mid_nodes.size());
    auto boundary = describe_boundary(run, mesh.linear, mesh.edges, curves);
    if (!boundary) return fail(boundary.error());
    return run.step("nodes", [&](const Execution& e) -> Outcome<Plan<D>> {
        const Column<EdgeKind>& kinds = boundary->features.edge_kinds;
        auto nodes = mesh_nodes_on(boundary->geometry, kinds, mesh, boundary->required, e);
        if (!nodes) return fail(nodes.error());
        Proposal<D> proposal = proposal_from_mesh(mesh, kinds, boundary->required);
        proposal.mid_nodes = std::move(*nodes);
        return Plan<D>{OwnNodes<D>{boundary->features, *boundary}, std::move(proposal)};
    });
}

template <int D>
bool prescribes_geometry(const Runner<D>& run) {
    if (const MeshGoal<D>* goal = run.sources.goal) return goal->geometry && (*goal->geometry)->prescribes_any();
    const config::Geometry& geometry = run.config.geometry;
    return std::holds_alternative<config::Cad>(geometry) || std::holds_alternative<config::Analytic>(geometry) ||
           std::holds_alternative<config::FilePath>(geometry);
}

}  // namespace

template <int D>
Outcome<Done> adopt_own_nodes(Runner<D>& run) {
    if (run.quadratic().planned()) return Done{};
    if (prescribes_geometry(run)) {
        auto plan = own_nodes_on_geometry(run);
        if (!plan) return fail(plan.error());
        run.quadratic().plan = std::move(*plan);
        return Done{};
    }
    const config::Features& features = run.config.features;
    const BoundaryOptions<D> options =
        run.sources.goal != nullptr
            ? run.sources.goal->boundary
            : BoundaryOptions<D>{{.ridge_angle_degrees = features.ridge_angle}, features.required_boundary};
    auto result = run.step("features", [&](const Execution& e) { return own_nodes(run.quadratic().mesh, options, e); });
    if (!result) return fail(result.error());
    add(run.report, result->report);
    run.quadratic().plan = Plan<D>{std::move(result->own), std::move(result->proposal)};
    return Done{};
}

namespace {

/// Commits the proposal, valid or not. The report and the exit code show invalid elements.
template <int D>
Outcome<QuadraticMesh<D>> committed(const JudgedProposal<D>& judged) {
    if (!judged.validation().certified()) return commit_uncertified(judged).mesh;
    auto done = commit(judged);
    if (!done) return fail(done.error());
    return std::move(done->mesh);
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Commit& options) {
    if (auto adopted = adopt_own_nodes(run); !adopted) return adopted;
    return run.step_of(options, [&](const Execution& e) -> Outcome<Done> {
        if (!run.plan().judged())
            if (auto done = judge_plan(run, bound_for(run, {}), e); !done) return done;
        const JudgedProposal<D> judged = *run.plan().judged();
        auto mesh = committed(judged);
        if (!mesh) return fail(mesh.error());
        run.quadratic().mesh = std::move(*mesh);
        run.plan().places = CommittedPlaces<D>{judged.proposal(), judged.validation()};
        run.report.committed = true;
        return Done{};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<SourcedMetric<D>> make_log_metrics<D>(const MetricInput<D>&, const config::Metric&, \
                                                           const Execution&);                            \
    template Outcome<Sound<D>> prepare_stage<D>(StageInputs<D>, std::span<const config::Stage>,          \
                                                const OrderingOptions&, const Execution&);               \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Elevate&);                                 \
    template Outcome<Done> adopt_own_nodes<D>(Runner<D>&);                                               \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Commit&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
