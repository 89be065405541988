module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
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
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.crossing;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.stages;
import camber.distributed;

namespace camber::run {

namespace {

template <int D>
Outcome<Column<LogMetric<D>>> log_metrics_of(const Adaptation<D>& r, const Execution& execution) {
    auto logs =
        map_each(execution, r.vertices.metrics.size(), [&](std::size_t v) { return r.vertices.metrics[v].log_metric; });
    if (!logs) return fail(logs.error());
    return Column<LogMetric<D>>(std::move(*logs));
}

/// Length in the metric of the longest edges that the config's passes leave; none: no pass splits.
std::optional<double> longest_edge_left(std::span<const config::Stage> stages) {
    std::optional<double> least;
    const auto apply_limits = [&](const SplitOptions& split) {
        // An edge is not split if its halves would be shorter than `shortest`.
        const double longest = std::max(split.longest, 2 * split.shortest);
        least = std::min(longest, least.value_or(longest));
    };
    for (const config::Stage& stage : stages) {
        if (const auto* split = std::get_if<config::Split>(&stage)) apply_limits(*split);
        if (const auto* remesh = std::get_if<config::Remesh>(&stage)) apply_limits(remesh->split);
    }
    return least;
}

struct RemeshedSimplices {
    std::size_t count = 0;
    int dimension = 0;
};
template <int D>
RemeshedSimplices remeshed_simplices(const LinearMesh<D>& mesh) {
    if (is_standalone_surface(mesh)) return {mesh.facets.size(), 2};
    return {mesh.elements.size(), D};
}

/// Errors: the expected mesh exceeds the memory or 32-bit numbers.
template <int D>
Outcome<std::optional<Growth>> check_growth(const Runner<D>& run, double complexity, RemeshedSimplices specified,
                                            int degree) {
    const auto longest = longest_edge_left(run.config.stages);
    if (!longest) return std::nullopt;
    Growth growth = expected_growth(complexity, *longest, specified.count, specified.dimension, degree);
    const auto curves = [](const config::Stage& s) { return std::holds_alternative<config::Curve>(s); };
    if (growth.elements < static_cast<double>(max_entities) && std::ranges::any_of(run.config.stages, curves)) {
        const auto result = static_cast<std::size_t>(growth.elements);
        growth.peak_bytes =
            std::max(growth.peak_bytes,
                     estimated_peak_bytes(result / (specified.dimension == 2 ? 2 : 5), result, specified.dimension));
    }
    const std::string requested = fmt::format("the metric requires about {:.2g} {}", growth.elements,
                                              specified.dimension == 2 ? "triangles" : "tetrahedra");
    const char* const remedy = "make it coarser: metric_operations bound or complexity, or a larger split/longest";
    constexpr double gib = 1024.0 * 1024 * 1024;
    if (growth.peak_bytes > run.sources.memory.bytes)
        return fail(ErrorKind::memory,
                    fmt::format("{}, which need about {:.3g} GiB of memory, but {} allows {:.3g} GiB", requested,
                                static_cast<double>(growth.peak_bytes) / gib, run.sources.memory.source,
                                static_cast<double>(run.sources.memory.bytes) / gib),
                    {}, {}, remedy);
    if (!(growth.elements < static_cast<double>(max_entities)))
        return fail(ErrorKind::unsupported, requested + ", more than 32-bit numbers allow", {}, {}, remedy);
    return growth;
}

template <int D>
struct StartedRemeshing {
    Remeshing<D> remeshing;
    UnitMesh measured;
    std::size_t crossing = 0;  ///< crossing pairs of facets
};

template <int D>
const LinearMesh<D>& linear_of(const LinearMesh<D>& mesh) {
    return mesh;
}
template <int D>
const LinearMesh<D>& linear_of(const QuadraticMesh<D>& mesh) {
    return mesh.linear;
}

/// Prepares `mesh` for passes. begin(by, execution) and measure(log_metrics, execution) return Remeshing and UnitMesh.
template <int D, class Mesh>
Outcome<Done> start_changing(Runner<D>& run, const Mesh& mesh, OwnField<D> field, const auto& begin,
                             const auto& measure) {
    constexpr int degree = std::is_same_v<Mesh, LinearMesh<D>> ? 1 : 2;
    RemeshingBy<D> by{std::move(field.back), run.state.curving,
                      std::min(max_elements_within(run.sources.memory.bytes, D, degree), max_entities),
                      run.state.inherited ? &run.state.inherited->curves : nullptr};
    if (run.config.geometry_bound == config::GeometryBound::by_default)
        by.distance_bounds = default_distance_bounds(linear_of(mesh), degree, required_distances(run));
    static_cast<EdgeAccuracyOptions&>(by.curving) = accuracy_for(field.origin, by.curving);
    run.state.target = {};
    auto result = run.step("topology", [&](const Execution& e) -> Outcome<StartedRemeshing<D>> {
        auto started_remeshing = begin(std::move(by), part_of(e, 0, 0.6));
        if (!started_remeshing) return fail(started_remeshing.error());
        auto logs = log_metrics_of(started_remeshing->mesh, without_progress(e));
        if (!logs) return fail(logs.error());
        auto measured = measure(*logs, part_of(e, 0.6, 1));
        if (!measured) return fail(measured.error());
        const auto crossings = find_crossings(mesh, without_progress(e));
        if (!crossings) return fail(crossings.error());
        return StartedRemeshing<D>{std::move(*started_remeshing), std::move(*measured), crossings->crossing};
    });
    if (!result) return fail(result.error());
    if (!run.state.crossings_of_input) run.state.crossings_of_input = result->crossing;
    run.report.remesh = RemeshReport{result->measured.report, {}, {}, {}};
    run.state.mesh = Changing<D>{std::move(result->remeshing.mesh), std::move(result->remeshing.goal),
                                 std::move(field.report), histograms_of(result->measured, "input")};
    return Done{};
}

/// Made before the mesh changes.
template <int D>
struct Aims {
    Boundary<D> boundary;
    OwnField<D> field;
    std::optional<Growth> growth;
};
template <int D>
Outcome<Aims<D>> aims(const Runner<D>& run, Boundary<D> boundary, Outcome<OwnField<D>> field,
                      RemeshedSimplices specified, int degree) {
    if (!field) return fail(field.error());
    auto growth = check_growth(run, field->report.complexity, specified, degree);
    if (!growth) return fail(growth.error());
    return Aims<D>{std::move(boundary), std::move(*field), *growth};
}
template <int D>
Outcome<Aims<D>> aims_for(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges) {
    auto boundary = describe_boundary(run, mesh, edges);
    if (!boundary) return fail(boundary.error());
    auto field = make_own_field(run, mesh, edges, *boundary);
    return aims(run, std::move(*boundary), std::move(field), remeshed_simplices(mesh), 1);
}
template <int D>
Outcome<Done> put_nodes_onto(Runner<D>& run, const Boundary<D>& boundary) {
    Quadratic<D>& state = run.quadratic();
    if (state.planned() || run.state.inherited) return Done{};
    auto placed = run.step("nodes", [&](const Execution& e) -> Outcome<OntoGeometry<D>> {
        auto result = put_nodes_onto_geometry(state.mesh, boundary, e);
        if (!result || result->nodes == 0 || run.state.crossings_of_input) return result;
        const auto crossings = find_crossings(state.mesh, without_progress(e));
        if (!crossings) return fail(crossings.error());
        run.state.crossings_of_input = crossings->crossing;
        return result;
    });
    if (!placed) return fail(placed.error());
    if (placed->nodes == 0) return Done{};
    run.note(
        fmt::format("{} mid nodes of the boundary were off the geometry, by up to {:.4g}; they were moved onto it "
                    "before the mesh was changed",
                    placed->nodes, placed->largest));
    state.mesh = std::move(placed->mesh);
    state.plan = Unplanned<D>{};
    return Done{};
}

/// Replaces `mesh` by one whose boundary nodes are on the geometry.
template <int D>
Outcome<Aims<D>> aims_for(Runner<D>& run, QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes) {
    auto boundary = describe_boundary(run, mesh.linear, mesh.edges, nodes);
    if (!boundary) return fail(boundary.error());
    if (auto placed = put_nodes_onto(run, *boundary); !placed) return fail(placed.error());
    mesh = run.quadratic().mesh;
    auto field = make_own_field(run, mesh, *boundary);
    return aims(run, std::move(*boundary), std::move(field), remeshed_simplices(mesh.linear), 2);
}
/// Nodes that define the boundary's own curves; empty unless they are from the input.
template <int D>
std::span<const LagrangeNode<D>> own_boundary_nodes(Runner<D>& run, const QuadraticMesh<D>& mesh) {
    return run.quadratic().is_boundary_from_input() ? mesh.mid_nodes.view() : std::span<const LagrangeNode<D>>();
}
template <int D>
Outcome<EdgeSet<D>> edges_of(Runner<D>& run, const LinearMesh<D>& mesh) {
    return run.step("edges", [&](const Execution& e) { return unique_edges(mesh, e); });
}

template <int D>
Outcome<Done> begin_changing(Runner<D>& run, const LinearMesh<D>& mesh) {
    const auto edges = edges_of(run, mesh);
    if (!edges) return fail(edges.error());
    auto aim = aims_for(run, mesh, *edges);
    if (!aim) return fail(aim.error());
    const std::string metric = aim->field.report.source;
    return start_changing(
        run, mesh, std::move(aim->field),
        [&](RemeshingBy<D> by, const Execution& e) {
            return begin_remeshing(mesh, *edges, aim->boundary, std::move(by), e);
        },
        [&](const auto& logs, const Execution& e) { return measure_unit_mesh(mesh, *edges, logs, metric, e); });
}
template <int D>
Outcome<Done> begin_changing(Runner<D>& run, QuadraticMesh<D> mesh) {
    const QuadraticMesh<D> before = mesh;
    auto aim = aims_for(run, mesh, own_boundary_nodes(run, before));
    if (!aim) return fail(aim.error());
    const auto nodes = own_boundary_nodes(run, mesh);
    const std::string metric = aim->field.report.source;
    return start_changing(
        run, mesh, std::move(aim->field),
        [&](RemeshingBy<D> by, const Execution& e) {
            return begin_remeshing(mesh, nodes, aim->boundary, std::move(by), e);
        },
        [&](const auto& logs, const Execution& e) { return measure_unit_mesh(mesh, logs, metric, e); });
}
template <int D>
Outcome<Done> begin_changing(Runner<D>& run) {
    if (std::holds_alternative<Changing<D>>(run.state.mesh)) return Done{};
    // Copies the mesh, since the state gets another one during the call.
    if (auto* const straight = std::get_if<LinearMesh<D>>(&run.state.mesh)) {
        const LinearMesh<D> mesh = *straight;
        return begin_changing(run, mesh);
    }
    const QuadraticMesh<D> mesh = run.quadratic().mesh;
    return begin_changing(run, mesh);
}

template <int D, class Options, class Pass>
Outcome<Done> change(Runner<D>& run, const Options& stage, const Pass& pass) {
    auto& changing = std::get<Changing<D>>(run.state.mesh);
    return run.step_of(stage, [&](const Execution& e) -> Outcome<Done> {
        auto result = pass(std::move(changing.mesh), changing.goal, e);
        if (!result) return fail(result.error());
        changing.mesh = std::move(result->state);
        run.state.reached.reset();
        constexpr std::string_view name = std::get<Step<Options>>(step_table).name;
        add(run.report, PassReport{result->statistics, std::string(name)});
        return Done{};
    });
}

template <int D, class Options>
Outcome<Done> apply_pass(Runner<D>& run, const Options& options,
                         Outcome<Adapted<D>> (*pass)(Adaptation<D>, const AdaptationGoal<D>&, const Options&,
                                                     const Execution&)) {
    if (auto done = begin_changing(run); !done) return done;
    return change(run, options, [&](Adaptation<D> mesh, const AdaptationGoal<D>& goal, const Execution& e) {
        return pass(std::move(mesh), goal, options, e);
    });
}

void add_bound(const config::Metric& metric, std::vector<DistanceBound>& bounds) {
    const config::GeometryMetric* sizes = std::get_if<config::GeometryMetric>(&metric);
    if (const auto* solution = std::get_if<config::SolutionMetric>(&metric)) sizes = &solution->geometry;
    if (sizes != nullptr && sizes->chord_error > 0) bounds.push_back({sizes->chord_error, sizes->references});
}

}  // namespace

std::vector<DistanceBound> required_distances(const config::Pipeline& pipeline) {
    std::vector<DistanceBound> bounds;
    add_bound(pipeline.metric, bounds);
    for (const config::MetricOperation& operation : pipeline.metric_operations)
        if (const auto* intersect = std::get_if<config::Intersect>(&operation)) add_bound(intersect->metric, bounds);
    return bounds;
}

template <int D>
std::vector<DistanceBound> required_distances(const Runner<D>& run) {
    return run.sources.goal != nullptr ? run.sources.goal->distance_bounds : required_distances(run.config);
}

template <int D>
BoundedDistances bounded_distances(const Runner<D>& run) {
    if (auto required = required_distances(run); !required.empty()) return {std::move(required), true};
    BoundedDistances expected{{}, false};
    if (run.config.geometry_bound == config::GeometryBound::none) return expected;
    for (const MetricFile& file : run.files)
        expected.bounds.insert(expected.bounds.end(), file.bounds.begin(), file.bounds.end());
    return expected;
}

template <int D>
Outcome<std::optional<Growth>> requested_growth(Runner<D>& run) {
    const auto growth = [](Aims<D> by) { return by.growth; };
    const auto* const straight = std::get_if<LinearMesh<D>>(&run.state.mesh);
    if (straight == nullptr) {
        QuadraticMesh<D> mesh = run.quadratic().mesh;
        const QuadraticMesh<D> before = mesh;
        return aims_for(run, mesh, own_boundary_nodes(run, before)).map(growth);
    }
    const auto edges = edges_of(run, *straight);
    if (!edges) return fail(edges.error());
    return aims_for(run, *straight, *edges).map(growth);
}

template <int D>
Outcome<OwnField<D>> requested_field(Runner<D>& run) {
    if (const auto* const straight = std::get_if<LinearMesh<D>>(&run.state.mesh)) {
        const auto edges = edges_of(run, *straight);
        if (!edges) return fail(edges.error());
        const auto boundary = describe_boundary(run, *straight, *edges);
        return boundary ? make_own_field(run, *straight, *edges, *boundary)
                        : Outcome<OwnField<D>>(fail(boundary.error()));
    }
    const QuadraticMesh<D>& mesh = run.quadratic().mesh;
    const auto boundary = describe_boundary(run, mesh.linear, mesh.edges, own_boundary_nodes(run, mesh));
    return boundary ? make_own_field(run, mesh, *boundary) : Outcome<OwnField<D>>(fail(boundary.error()));
}

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Collapse& options) {
    return apply_pass(run, options, &collapse<D>);
}
template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Split& options) {
    return apply_pass(run, options, &split<D>);
}
template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Swap& options) {
    return apply_pass(run, options, &swap<D>);
}
template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Smooth& options) {
    return apply_pass(run, options, &smooth<D>);
}
template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Mend& options) {
    return apply_pass(run, options, &mend<D>);
}

namespace {

void set_objective(CurveOptions& curving, config::RemeshObjective objective) {
    using Objective = config::RemeshObjective;
    switch (objective) {
        case Objective::automatic: break;
        case Objective::accuracy: curving.aim = CurvingAim::accuracy; break;
        case Objective::energy: curving.aim = CurvingAim::energy; break;
        case Objective::length: curving.aim = CurvingAim::length; break;
    }
}

/// If the run ends in rows, these stay on their ranks, and the returned mesh is empty.
template <int D>
Outcome<RemeshResult<D>> remesh_by_blocks_of_run(Runner<D>& run, Changing<D>& changing, const config::Remesh& options,
                                                 std::size_t elements, const StepWrapper& around) {
    const BlockRemeshing by{elements, *run.sources.ranks};
    const auto turns = block_iterations<D>(options);
    const bool is_last = &options == std::get_if<config::Remesh>(&run.config.stages.back());
    if (run.sources.end == RunEnd::whole || !is_last)
        return remesh_by_blocks(std::move(changing.mesh), changing.goal, options, by, turns, around);
    auto remeshed = remesh_shared_rows(std::move(changing.mesh), changing.goal, options, by, turns, around);
    if (!remeshed) return fail(remeshed.error());
    const ToMetricStatistics statistics = remeshed->statistics;
    changing.shared = std::move(*remeshed);
    return RemeshResult<D>{{}, statistics};
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Remesh& options) {
    set_objective(run.state.curving, options.objective);
    if (auto done = begin_changing(run); !done) return done;
    auto& changing = std::get<Changing<D>>(run.state.mesh);
    const StepWrapper& around = run.around();
    const std::size_t elements = options.blocks > 0              ? static_cast<std::size_t>(options.blocks)
                                 : run.sources.ranks->size() > 1 ? default_block_elements
                                                                 : 0;
    auto result = elements == 0 ? remesh_to_metric(std::move(changing.mesh), changing.goal, options, around)
                                : remesh_by_blocks_of_run(run, changing, options, elements, around);
    if (!result) return fail(result.error());
    const auto [bounds, are_required] = bounded_distances(run);
    if (!bounds.empty()) {
        const BoundaryEffort effort = are_required ? BoundaryEffort::any : BoundaryEffort::near_metric;
        auto within = refine_within(std::move(*result), changing.goal, bounds, options, effort, around);
        if (!within) return fail(within.error());
        result = RemeshResult<D>{std::move(within->state), within->statistics};
        run.state.reached = within->reached;
    }
    changing.mesh = std::move(result->state);
    const ToMetricStatistics& s = result->statistics;
    for (const auto& [pass, done] :
         {std::pair("collapse", &s.collapse), std::pair("split", &s.split), std::pair("swap", &s.swap),
          std::pair("smooth", &s.smooth), std::pair("improve", &s.mend)})
        add(run.report, PassReport{*done, pass});
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                    \
    template std::vector<DistanceBound> required_distances<D>(const Runner<D>&); \
    template BoundedDistances bounded_distances<D>(const Runner<D>&);            \
    template Outcome<std::optional<Growth>> requested_growth<D>(Runner<D>&);     \
    template Outcome<OwnField<D>> requested_field<D>(Runner<D>&);                \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Collapse&);        \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Split&);           \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Swap&);            \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Smooth&);          \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Mend&);            \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Remesh&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
