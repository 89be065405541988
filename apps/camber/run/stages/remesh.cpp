module;
#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.cavity;
import camber.metric;
import camber.operation;
import camber.adapt;
import camber.surface;
import :memory;
import :parts;
import :report;
import :runner;
import :state;
import :steps;
import :unit_mesh;

namespace camber::run {

namespace {

/// A mesh as passes take it, and how near to unit it is.
template <int D>
struct Begun {
    Adaptation<D> mesh;
    UnitMesh measured;
};

/// Those of the features, and those of embedded curves.
template <int D>
std::vector<VertexId> corners_of(const Features<D>& features, const Column<VertexId>& of_curves) {
    std::vector<VertexId> corners(of_curves.begin(), of_curves.end());
    const auto of_features = corners_of(features);
    corners.insert(corners.end(), of_features.begin(), of_features.end());
    return corners;
}
template <int D>
Outcome<Column<LogMetric<D>>> log_metrics_of(const Adaptation<D>& r, const Execution& execution) {
    auto logs =
        map_each(execution, r.vertices.metrics.size(), [&](std::size_t v) { return r.vertices.metrics[v].log_metric; });
    if (!logs) return fail(logs.error());
    return Column<LogMetric<D>>(std::move(*logs));
}

template <int D>
Outcome<Begun<D>> begun(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                        const AdaptationGoal<D>& goal, const Column<VertexId>& of_curves, const std::string& metric,
                        const Execution& execution) {
    const auto corners = corners_of(features, of_curves);
    auto made = begin_adaptation(mesh, edges, {features.edge_kinds.view(), corners}, goal, part_of(execution, 0, 0.6));
    if (!made) return fail(made.error());
    auto logs = log_metrics_of(*made, without_progress(execution));
    if (!logs) return fail(logs.error());
    auto measured = measure_unit_mesh(mesh, edges, *logs, metric, part_of(execution, 0.6, 1));
    if (!measured) return fail(measured.error());
    return Begun<D>{std::move(*made), std::move(*measured)};
}
template <int D>
Outcome<Begun<D>> begun(const QuadraticMesh<D>& mesh, const Features<D>& features, const AdaptationGoal<D>& goal,
                        const Column<VertexId>& of_curves, const std::string& metric, const Execution& execution) {
    const auto corners = corners_of(features, of_curves);
    auto made = begin_adaptation(mesh, {features.edge_kinds.view(), corners}, goal, part_of(execution, 0, 0.6));
    if (!made) return fail(made.error());
    auto logs = log_metrics_of(*made, without_progress(execution));
    if (!logs) return fail(logs.error());
    auto measured = measure_unit_mesh(mesh, *logs, metric, part_of(execution, 0.6, 1));
    if (!measured) return fail(measured.error());
    return Begun<D>{std::move(*made), std::move(*measured)};
}

/// The longest edges that the config's passes leave, in lengths in the metric; none: no pass splits.
std::optional<double> longest_edge_left(std::span<const config::Stage> stages) {
    std::optional<double> least;
    const auto see = [&](const SplitOptions& split) {
        // An edge that would be split into shorter ones than `shortest` stays.
        const double longest = std::max(split.longest, 2 * split.shortest);
        least = std::min(longest, least.value_or(longest));
    };
    for (const config::Stage& stage : stages) {
        if (const auto* split = std::get_if<config::Split>(&stage)) see(*split);
        if (const auto* remesh = std::get_if<config::Remesh>(&stage)) see(remesh->split);
    }
    return least;
}

/// Whether there is room for what passes will make of the mesh, and 32 bits can number it.
template <int D>
Outcome<std::optional<Growth>> check_growth(const Runner<D>& run, double complexity, std::size_t elements, int degree) {
    const auto longest = longest_edge_left(run.config.stages);
    if (!longest) return std::nullopt;
    Growth growth = expected_growth(complexity, *longest, elements, D, degree);
    const auto curves = [](const config::Stage& s) { return std::holds_alternative<config::Curve>(s); };
    if (growth.elements < static_cast<double>(max_entities) && std::ranges::any_of(run.config.stages, curves)) {
        const auto made = static_cast<std::size_t>(growth.elements);
        growth.peak_bytes = std::max(growth.peak_bytes, estimated_peak_bytes(made / (D == 2 ? 2 : 5), made, D));
    }
    const std::string asked =
        fmt::format("the metric asks for some {:.2g} {}", growth.elements, D == 2 ? "triangles" : "tetrahedra");
    const char* const remedy = "make it coarser: metric_operations bound or complexity, or a larger split/longest";
    constexpr double gib = 1024.0 * 1024 * 1024;
    if (growth.peak_bytes > run.memory.bytes)
        return fail(ErrorKind::memory,
                    fmt::format("{}, which need about {:.3g} GiB of memory, and {} gives {:.3g} GiB", asked,
                                static_cast<double>(growth.peak_bytes) / gib, run.memory.source,
                                static_cast<double>(run.memory.bytes) / gib),
                    {}, {}, remedy);
    if (!(growth.elements < static_cast<double>(max_entities)))
        return fail(ErrorKind::unsupported, asked + ", more than 32 bits can number", {}, {}, remedy);
    return growth;
}

/// Where new inner edges of a mesh of degree 2 have their nodes.
template <int D>
void set_objective(AdaptationGoal<D>& goal, const CurveOptions& options) {
    goal.accuracy = static_cast<const EdgeAccuracyOptions&>(options);
    goal.search.reset();
    if (options.aim != CurvingAim::accuracy) goal.search.emplace(search_options(options));
}

/// The run goes on with a mesh that changes. `curves`: its embedded ones, unless the mesh that it was remeshed from
/// told of them. `begin`: of the goal, the corners of curves and the name of the metric.
template <int D, class Curves, class Begin>
Outcome<Done> go_on_with(Runner<D>& run, OwnField<D> field, Geometry<D> geometry, Curves&& curves, Begin&& begin) {
    AdaptationGoal<D> goal{std::move(field.back), std::move(geometry)};
    const int degree = std::holds_alternative<LinearMesh<D>>(run.state.mesh) ? 1 : 2;
    goal.max_elements = std::min(max_elements_within(run.memory.bytes, D, degree), max_entities);
    set_objective(goal, run.state.curving);
    auto made = run.step("topology", [&](const Execution& e) -> Outcome<Begun<D>> {
        auto found = curves(*goal.geometry, without_progress(e));
        if (!found) return fail(found.error());
        goal.curves = run.state.inherited ? run.state.inherited->curves : *found;
        return begin(goal, found->corners, field.report.source, e);
    });
    if (!made) return fail(made.error());
    run.report(BeginsChangingReport{made->measured.report});
    run.state.mesh = Changing<D>{std::move(made->mesh), std::move(goal), std::move(field.report),
                                 histograms_of(made->measured, "given")};
    return Done{};
}

/// What passes go by: the boundary is described and the field made before anything is done, and there is room for what
/// it asks for.
template <int D>
struct Aims {
    Boundary<D> boundary;
    OwnField<D> field;
    std::optional<Growth> growth;
};
template <int D>
Outcome<Aims<D>> aims(const Runner<D>& run, Boundary<D> boundary, Outcome<OwnField<D>> field, std::size_t elements,
                      int degree) {
    if (!field) return fail(field.error());
    auto growth = check_growth(run, field->report.complexity, elements, degree);
    if (!growth) return fail(growth.error());
    return Aims<D>{std::move(boundary), std::move(*field), *growth};
}
template <int D>
Outcome<Aims<D>> aims_for(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges) {
    auto boundary = describe_boundary(run, mesh, edges);
    if (!boundary) return fail(boundary.error());
    auto field = make_own_field(run, mesh, edges, *boundary);
    return aims(run, std::move(*boundary), std::move(field), mesh.elements.size(), 1);
}
template <int D>
Outcome<Aims<D>> aims_for(Runner<D>& run, const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes) {
    auto boundary = describe_boundary(run, mesh.linear, mesh.edges, nodes);
    if (!boundary) return fail(boundary.error());
    auto field = make_own_field(run, mesh, *boundary);
    return aims(run, std::move(*boundary), std::move(field), mesh.linear.elements.size(), 2);
}
/// The nodes by which the boundary's own curves are told: none where they are not the file's.
template <int D>
std::span<const LagrangeNode<D>> own_boundary_nodes(Runner<D>& run, const QuadraticMesh<D>& mesh) {
    return run.quadratic().boundary_is_given() ? mesh.mid_nodes.view() : std::span<const LagrangeNode<D>>();
}
template <int D>
Outcome<EdgeSet<D>> edges_of(Runner<D>& run, const LinearMesh<D>& mesh) {
    return run.step("edges", [&](const Execution& e) { return unique_edges(mesh, e); });
}

/// The state's mesh becomes one that changes.
template <int D>
Outcome<Done> begin_changing(Runner<D>& run, LinearMesh<D> mesh) {
    const auto edges = edges_of(run, mesh);
    if (!edges) return fail(edges.error());
    auto by = aims_for(run, mesh, *edges);
    if (!by) return fail(by.error());
    const auto curves = [&](const Geometry<D>& geometry, const Execution& e) {
        return find_embedded_curves(mesh, *edges, by->boundary.features, geometry, {}, e);
    };
    return go_on_with(run, std::move(by->field), std::move(by->boundary.geometry), curves,
                      [&](const auto&... of) { return begun(mesh, *edges, by->boundary.features, of...); });
}
template <int D>
Outcome<Done> begin_changing(Runner<D>& run, QuadraticMesh<D> mesh) {
    const auto nodes = own_boundary_nodes(run, mesh);
    auto by = aims_for(run, mesh, nodes);
    if (!by) return fail(by.error());
    const auto curves = [&](const Geometry<D>& geometry, const Execution& e) {
        return find_embedded_curves(mesh.linear, mesh.edges, by->boundary.features, geometry, nodes, e);
    };
    return go_on_with(run, std::move(by->field), std::move(by->boundary.geometry), curves,
                      [&](const auto&... of) { return begun(mesh, by->boundary.features, of...); });
}
template <int D>
Outcome<Done> begin_changing(Runner<D>& run) {
    if (std::holds_alternative<Changing<D>>(run.state.mesh)) return Done{};
    if (auto* const straight = std::get_if<LinearMesh<D>>(&run.state.mesh)) return begin_changing(run, *straight);
    return begin_changing(run, run.quadratic().mesh);
}

PassReport pass_report(std::string_view name, const PassStatistics& s, double seconds) {
    PassReport report{.pass = std::string(name),
                      .rounds = s.rounds,
                      .proposals = s.proposals,
                      .accepted = s.accepted,
                      .corrections = s.corrections,
                      .shortened = s.shortened,
                      .drawn_back = s.drawn_back,
                      .programmes = s.programmes,
                      .straight_inverted = s.straight_inverted,
                      .straight_positive = s.straight_positive,
                      .farthest_facet = s.farthest_facet,
                      .moved_nodes = s.moved_nodes,
                      .rejected = {},
                      .seconds = seconds};
    for (const auto& reason : words(RejectionReason{}))
        if (const std::size_t n = s.of(reason.value); n > 0 && reason.value != RejectionReason::none)
            report.rejected.emplace_back(reason.word, n);
    return report;
}

/// `pass(mesh, goal, execution)` on the mesh that changes, as the step of a stage.
template <int D, class Options, class Pass>
Outcome<Done> change(Runner<D>& run, const Options& stage, const Pass& pass) {
    auto& changing = std::get<Changing<D>>(run.state.mesh);
    return run.step_of(stage, [&](const Execution& e) -> Outcome<Done> {
        auto made = run.timed([&] { return pass(std::move(changing.mesh), changing.goal, e); });
        if (!made.value) return fail(made.value.error());
        changing.mesh = std::move(made.value->state);
        constexpr std::string_view name = std::get<StageRow<Options>>(stage_rows).name;
        run.report(pass_report(name, made.value->statistics, made.seconds));
        return Done{};
    });
}

/// A pass of camber.remesh as a stage.
template <int D, class Options>
Outcome<Done> apply_pass(Runner<D>& run, const Options& options,
                         Outcome<Adapted<D>> (*pass)(Adaptation<D>, const AdaptationGoal<D>&, const Options&,
                                                     const Execution&)) {
    if (auto done = begin_changing(run); !done) return done;
    return change(run, options, [&](Adaptation<D> mesh, const AdaptationGoal<D>& goal, const Execution& e) {
        return pass(std::move(mesh), goal, options, e);
    });
}

}  // namespace

template <int D>
Outcome<std::optional<Growth>> asked_growth(Runner<D>& run) {
    const auto growth = [](Aims<D> by) { return by.growth; };
    const auto* const straight = std::get_if<LinearMesh<D>>(&run.state.mesh);
    if (straight == nullptr) {
        const QuadraticMesh<D>& mesh = run.quadratic().mesh;
        return aims_for(run, mesh, own_boundary_nodes(run, mesh)).map(growth);
    }
    const auto edges = edges_of(run, *straight);
    if (!edges) return fail(edges.error());
    return aims_for(run, *straight, *edges).map(growth);
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

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Remesh& options) {
    if (auto done = begin_changing(run); !done) return done;
    auto& changing = std::get<Changing<D>>(run.state.mesh);
    std::map<std::string, double, std::less<>> seconds;
    const AroundPass around = [&](std::string_view pass, const auto& body) {
        auto done = run.timed([&] { return run.step(pass, body); });
        seconds[std::string(pass)] += done.seconds;
        return std::move(done.value);
    };
    auto made = bring_to_metric(std::move(changing.mesh), changing.goal, options, around);
    if (!made) return fail(made.error());
    changing.mesh = std::move(made->state);
    const ToMetricStatistics& s = made->statistics;
    for (const auto& [pass, done] :
         {std::pair("collapse", &s.collapse), std::pair("split", &s.split), std::pair("swap", &s.swap),
          std::pair("smooth", &s.smooth), std::pair("mend", &s.mend)})
        run.report(pass_report(pass, *done, seconds[pass]));
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                             \
    template Outcome<std::optional<Growth>> asked_growth<D>(Runner<D>&);  \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Collapse&); \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Split&);    \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Swap&);     \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Smooth&);   \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Mend&);     \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Remesh&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
