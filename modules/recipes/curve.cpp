module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.surface;
import camber.cad;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;
import camber.stages;

namespace camber::run {

namespace {

std::string preserved_nodes_note(std::size_t edges) {
    return fmt::format("{} boundary edges have the nodes of the input", edges);
}
constexpr const char* of_volume(CurvingAim aim) {
    return aim == CurvingAim::accuracy
               ? "volume edges: new nodes are computed, and the nodes of the input are ignored"
               : "volume edges: the search starts at the node of the input, if that is the better start";
}

template <int D>
CurveReport curve_report(const QuadraticMesh<D>& mesh, const Curved<D>& curved) {
    CurveReport report{curved.statistics, mesh.edges.size()};
    if (is_standalone_surface(mesh.linear)) report.curved_edges = bent_edges(mesh, curved.proposal);
    report.before = edge_report(mesh, curved.proposal, curved.straight_lengths, curved.lengths);
    return report;
}

}  // namespace

template <int D>
void report_curves(Runner<D>& run, const ProposedCurves<D>& result, const ProposeOptions& options) {
    const Quadratic<D>& at = run.quadratic();
    if (result.input.placed)
        run.report.boundary->nodes = {*result.input.placed, std::string(word_of(options.boundary_nodes))};
    CurveReport part = curve_report(at.mesh, result.curved);
    if (result.field && result.edges.aim == CurvingAim::accuracy && !is_standalone_surface(at.mesh.linear)) {
        const CurveStatistics& s = result.curved.statistics;
        part.by = NodesByReport{std::string(word_of(result.edges.metric_kind)), share_of_sizes(result.edges, D),
                                s.by_walls, s.by_metric, s.loss_limited};
    }
    if (const auto& expected = result.expected)
        part.expected = ExpectedErrorsReport{expected->before, expected->after, static_cast<int>(expected->rounds)};
    part.objective = word_of(options.objective);
    run.report.curve = std::move(part);
    if (at.nodes != NodesOf::input) return;
    if (result.input.preserved > 0) run.note(preserved_nodes_note(result.input.preserved));
    if (result.field) run.note(of_volume(edge_options(options).aim));
}

template <int D>
CurvingTarget<D> store_field(Runner<D>& run, Boundary<D> boundary, ProposedCurves<D> result, CurvingAim aim) {
    run.state.field = std::move(result.field);
    run.state.straight_log_metrics = std::move(result.straight_log_metrics);
    return {std::move(boundary), std::move(result.input.shells), std::move(result.curved), aim,
            std::move(result.input.extended)};
}

namespace {

/// Empty: no stage needs it.
template <int D>
Outcome<SolutionInput<D>> solution_for(Runner<D>& run, const QuadraticMesh<D>& mesh) {
    if (run.sources.goal != nullptr) return run.sources.goal->solution;
    if (run.sources.solution == nullptr) return SolutionInput<D>{};
    return solution_on(*run.sources.solution, mesh, run.around());
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Curve& original) {
    auto options = static_cast<const ProposeOptions&>(original);
    options.measured = reported_lengths(run.config.output);
    Quadratic<D>& at = run.quadratic();
    auto boundary = describe_boundary(run, at.mesh.linear, at.mesh.edges);
    if (!boundary) return fail(boundary.error());
    const CurvingAim aim = has_field(options.objective) ? edge_options(options).aim : CurvingAim::energy;
    if (has_field(options.objective)) run.state.curving = edge_options(original);
    MetricReports metric_report;
    const auto metric = metric_for_curving(run, at.mesh, *boundary, metric_report);
    auto solution = solution_for(run, at.mesh);
    if (!solution) return fail(solution.error());
    auto result = propose_curves<D>({at.mesh, at.nodes, *boundary}, metric, *solution, options, run.around());
    if (!result) return fail(result.error());
    report_metric(run, std::move(metric_report));
    report_curves(run, *result, options);
    run.state.target = recommended_target(result->edges);
    Proposal<D> proposal = result->curved.proposal;
    at.plan = Plan<D>{store_field(run, std::move(*boundary), std::move(*result), aim), std::move(proposal)};
    return Done{};
}

namespace {

template <int D>
FeatureOptions<D> by_angle(const config::Features& options) {
    return {.ridge_angle_degrees = options.ridge_angle};
}

template <class T, class More>
Column<T> with(const Column<T>& rows, const More& more) {
    Buffer<T> all(rows.begin(), rows.end());
    all.reserve(rows.size() + more.size());
    for (const auto& row : more) all.push_back(T(row));
    return all;
}

/// Adds the features of the CAD model: its edges may be smooth, and its vertices may lie on smooth curves.
template <int D>
Outcome<Features<D>> with_model_features(Features<D> features, LinearMesh<D> mesh, EdgeSet<D> edges,
                                         const BuiltGeometry<D>& result, const FeatureOptions<D>& options,
                                         const Execution& execution) {
    if constexpr (D == 2) {
        return features;
    } else {
        const auto is_ridge = [&](EdgeId e) { return features.edge_kinds[e] == EdgeKind::ridge; };
        const auto is_corner = [&](VertexId v) { return features.vertex_kinds[v] == VertexKind::corner; };
        if (std::ranges::all_of(result.ridges, is_ridge) && std::ranges::all_of(result.corners, is_corner))
            return features;
        std::vector<std::uint32_t> listed(result.ridges.size());
        std::iota(listed.begin(), listed.end(), static_cast<std::uint32_t>(mesh.edges.size()));
        std::vector<std::array<VertexId, 2>> ends;
        ends.reserve(result.ridges.size());
        for (const EdgeId e : result.ridges) ends.push_back(edges.vertices[e]);
        mesh.ridges = with(mesh.ridges, listed);
        mesh.corners = with(mesh.corners, result.corners);
        mesh.edges.vertices = with(mesh.edges.vertices, ends);
        mesh.edges.references = with(mesh.edges.references, std::vector<Reference>(ends.size(), 0));
        edges.of_edges = with(edges.of_edges, result.ridges);
        return find_features(mesh, edges, options, execution);
    }
}

template <int D>
BoundaryReport features_report(const Features<D>& features) {
    return {.surface_edges = features.surface_edges,
            .ridge_edges = features.ridge_edges,
            .corners = features.corners,
            .patches = features.patch_count};
}

template <int D>
Outcome<DescribedBoundary<D>> described(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                        std::span<const LagrangeNode<D>> curves, const MeshGoal<D>& goal,
                                        const Inherited<D>* inherited, const Execution& execution) {
    BoundaryOptions<D> options = goal.boundary;
    if (inherited) options.features = listed_breaks<D>;
    auto boundary = find_boundary(mesh, edges, inherited ? std::optional(inherited->geometry) : goal.geometry, options,
                                  execution, curves);
    if (!boundary) return fail(boundary.error());
    const BoundaryReport report = features_report(boundary->features);
    return DescribedBoundary<D>{std::move(*boundary), report};
}

struct ConfigGeometry {
    const config::Pipeline& pipeline;
    const GeometrySource& source;
};

/// A remeshed mesh has its inherited geometry.
template <int D>
Outcome<DescribedBoundary<D>> described(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                        std::span<const LagrangeNode<D>> curves, const ConfigGeometry& by,
                                        const Inherited<D>* inherited, const Execution& execution) {
    const config::Features& options = by.pipeline.features;
    const FeatureOptions<D> breaks = inherited ? listed_breaks<D> : by_angle<D>(options);
    auto features = find_features(mesh, edges, breaks, part_of(execution, 0, 0.3));
    if (!features) return fail(features.error());
    auto result = inherited ? BuiltGeometry<D>{inherited->geometry}
                            : make_geometry<D>(by.pipeline.geometry, by.source, {mesh, edges, *features, curves},
                                               by_angle<D>(options), part_of(execution, 0.3, 1));
    if (!result) return fail(result.error());
    if (result->fit_error) return fail(*result->fit_error);
    features = with_model_features(std::move(*features), mesh, edges, *result, breaks, without_progress(execution));
    if (!features) return fail(features.error());
    BoundaryReport report = features_report(*features);
    report.cad = result->cad;
    report.curved_patches = result->curved_patches;
    report.off_surfaces = result->off_surfaces;
    return DescribedBoundary<D>{{std::move(*features), options.required_boundary, std::move(result->geometry)}, report};
}

}  // namespace

template <int D>
Outcome<DescribedBoundary<D>> boundary_by_config(const config::Pipeline& pipeline, const GeometrySource& source,
                                                 const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Execution& execution) {
    return described<D>(mesh, edges, {}, ConfigGeometry{pipeline, source}, nullptr, execution);
}

template <int D>
Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                       std::span<const LagrangeNode<D>> curves) {
    const Inherited<D>* const inherited = run.state.inherited ? &*run.state.inherited : nullptr;
    auto result = run.step("surface", [&](const Execution& e) {
        return run.sources.goal != nullptr
                   ? described(mesh, edges, curves, *run.sources.goal, inherited, e)
                   : described(mesh, edges, curves, ConfigGeometry{run.config, run.sources.geometry}, inherited, e);
    });
    if (!result) return fail(result.error());
    if (result->report.cad) result->report.cad->moves = run.state.cad_moves;
    add(run.report, result->report);
    return std::move(result->boundary);
}

namespace {

/// Moves the node of each edge with the mean of its ends, so that the edge keeps its shape.
template <int D>
Outcome<Column<LagrangeNode<D>>> nodes_along(const QuadraticMesh<D>& mesh, const Column<Vec<D>>& points,
                                             const Execution& execution) {
    auto nodes = map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Column<Vec<D>>& before = mesh.linear.points;
        const LagrangeNode<D>& node = mesh.mid_nodes[e];
        if (points[a] == before[a] && points[b] == before[b]) return node;
        const Vec<D> middle = midpoint(points[a], points[b]), was = midpoint(before[a], before[b]);
        return node.point == was ? LagrangeNode<D>{middle} : LagrangeNode<D>{middle + (node.point - was)};
    });
    if (!nodes) return fail(nodes.error());
    return Column<LagrangeNode<D>>(std::move(*nodes));
}

template <int D>
Outcome<CadMovesReport> move(LinearMesh<D>& mesh, const config::Cad& cad, const CadModel& model,
                             const Execution& execution) {
    const auto edges = unique_edges(mesh, without_progress(execution));
    if (!edges) return fail(edges.error());
    auto moved = moved_vertices(cad, model, mesh, *edges, execution);
    if (!moved) return fail(moved.error());
    mesh.points = std::move(moved->points);
    return moved->report;
}
template <int D>
Outcome<CadMovesReport> move(Quadratic<D>& at, const config::Cad& cad, const CadModel& model,
                             const Execution& execution) {
    QuadraticMesh<D>& mesh = at.mesh;
    auto moved = moved_vertices(cad, model, mesh.linear, mesh.edges, execution);
    if (!moved) return fail(moved.error());
    auto nodes = nodes_along(mesh, moved->points, without_progress(execution));
    if (!nodes) return fail(nodes.error());
    mesh.linear.points = std::move(moved->points);
    mesh.mid_nodes = std::move(*nodes);
    return moved->report;
}
template <int D>
Outcome<CadMovesReport> move(Changing<D>&, const config::Cad&, const CadModel&, const Execution&) {
    return fail(ErrorKind::internal, "this step is not possible after a pass");
}

}  // namespace

template <int D>
Outcome<Done> move_vertices(Runner<D>& run) {
    const auto* const cad = std::get_if<config::Cad>(&run.config.geometry);
    if (!cad || !run.sources.geometry.cad || cad->vertices == CadVertices::keep) return Done{};
    auto report = run.step("vertices", [&](const Execution& e) {
        return std::visit([&](auto& mesh) { return move<D>(mesh, *cad, *run.sources.geometry.cad, e); },
                          run.state.mesh);
    });
    if (!report) return fail(report.error());
    run.state.cad_moves = *report;
    return Done{};
}

namespace {

Outcome<Done> check_options(const config::Reinsert& options) {
    const config::Relax defaults;
    std::string foreign;
    const auto look = [&](const auto& of) {
        const bool is_own = of.name == "min_scaled_jacobian" || of.name == "target";
        if (!is_own && !(options.relax.*(of.member) == defaults.*(of.member))) foreign = of.name;
    };
    std::apply([&](const auto&... of) { (look(of), ...); }, config::Relax::options());
    if (foreign.empty()) return Done{};
    return fail(ErrorKind::usage,
                "reinsert: relax/" + foreign +
                    " is an option of repair, which works on whole meshes; a cavity moves back only the nodes at its "
                    "vertex",
                {}, {}, "remove it, or use the stages curve, validate and relax");
}

template <int D>
struct Verdicts {
    JudgedProposal<D> target, result;
};
template <int D>
Outcome<Verdicts<D>> judged(const QuadraticMesh<D>& mesh, const ReinsertedNodes<D>& nodes, const JacobianBound& bound,
                            const Execution& execution) {
    auto target = validate(mesh, nodes.target.curved.proposal, bound, part_of(execution, 0, 0.5));
    if (!target) return fail(target.error());
    auto result = validate(mesh, nodes.result.proposal, bound, part_of(execution, 0.5, 1));
    if (!result) return fail(result.error());
    return Verdicts<D>{std::move(*target), std::move(*result)};
}

template <int D>
void report_cavities(Runner<D>& run, const ReinsertionResult<D>& result, const Verdicts<D>& verdicts,
                     RepairMethod method) {
    const PassStatistics& s = result.statistics;
    run.report.validity_before = verdicts_report(verdicts.target.validation(), run.state.bound.is_explicit).summary;
    run.report.relax = relax_report(changes_between(verdicts.target, verdicts.result), 0, method);
    run.report.reinsert =
        ReinsertReport{result.sweeps, s.rounds, s.accepted, s.of(RejectionReason::volume), s.of(RejectionReason::gain)};
    if (result.left > 0)
        run.note(std::to_string(result.left) + " vertices could still be improved: the limit max_sweeps was reached");
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Reinsert& options) {
    const JacobianBound bound = bound_for(run, options.relax.min_scaled_jacobian);
    if (auto checked = check_options(options); !checked) return checked;
    const CurvingAim aim = edge_options(options.curve).aim;
    run.state.curving = edge_options(options.curve);
    Quadratic<D>& at = run.quadratic();
    auto boundary = describe_boundary(run, at.mesh.linear, at.mesh.edges);
    if (!boundary) return fail(boundary.error());
    MetricReports metric_report;
    const auto metric = metric_for_curving(run, at.mesh, *boundary, metric_report);
    auto nodes = reinsert_nodes<D>({at.mesh, at.nodes, *boundary}, metric,
                                   {static_cast<const ProposeOptions&>(options.curve),
                                    {.min_scaled_jacobian = bound.is_explicit ? bound.value : min_bound,
                                     .target = options.relax.effective_target(),
                                     .max_sweeps = options.max_sweeps}},
                                   run.around());
    if (!nodes) return fail(nodes.error());
    auto verdicts = run.step("validate", [&](const Execution& e) { return judged(at.mesh, *nodes, bound, e); });
    if (!verdicts) return fail(verdicts.error());
    report_metric(run, std::move(metric_report));
    report_curves(run, nodes->target, options.curve);
    report_cavities(run, nodes->result, *verdicts, options.relax.method);
    run.state.history = Corrected<D>{verdicts->target.validation()};
    at.mesh.mid_nodes = nodes->result.proposal.mid_nodes;
    at.plan = Plan<D>{store_field(run, std::move(*boundary), std::move(nodes->target), aim),
                      CommittedPlaces<D>{std::move(nodes->result.proposal), verdicts->result.validation()}};
    report_verdicts(run, *at.validation());
    run.report.committed = true;
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template void report_curves<D>(Runner<D>&, const ProposedCurves<D>&, const ProposeOptions&);                    \
    template CurvingTarget<D> store_field<D>(Runner<D>&, Boundary<D>, ProposedCurves<D>, CurvingAim);               \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Curve&);                                              \
    template Outcome<DescribedBoundary<D>> boundary_by_config<D>(                                                   \
        const config::Pipeline&, const GeometrySource&, const LinearMesh<D>&, const EdgeSet<D>&, const Execution&); \
    template Outcome<Boundary<D>> describe_boundary<D>(Runner<D>&, const LinearMesh<D>&, const EdgeSet<D>&,         \
                                                       std::span<const LagrangeNode<D>>);                           \
    template Outcome<Done> move_vertices<D>(Runner<D>&);                                                            \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Reinsert&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
