module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;
import camber.stages;
import camber.distributed;

namespace camber::run {

namespace {

template <int D>
Outcome<RepairGuide<D>> guide_for(const Plan<D>& plan, const JudgedProposal<D>& judged, const BackMesh<D>* field,
                                  const RepairOptions& options, const Execution& execution) {
    std::optional<TargetNodes<D>> nodes;
    if (const CurvingTarget<D>* target = plan.target())
        nodes.emplace(TargetNodes<D>{target->curved, target->shells, target->extended, target->aim, field});
    return make_guide(judged, nodes, plan.boundary(), options, execution);
}

/// Counts separately the boundary nodes that repair moved along the geometry. Boundary vertices only slide.
template <int D>
void count_slides(const JudgedProposal<D>& before, const JudgedProposal<D>& after, const FootOnGeometry<D>& onto,
                  RelaxReport& report) {
    if (!onto) return;
    constexpr double rounding = 1e-12;
    const QuadraticMesh<D>& mesh = before.mesh();
    const Column<EdgeKind>& kinds = before.proposal().kinds;
    const auto on_boundary = boundary_vertices(mesh, kinds);
    for (std::size_t v = 0; v < on_boundary.size(); ++v)
        report.slid_vertices += on_boundary[v] != 0 && after.proposal().points[v] != before.proposal().points[v];
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        const Vec<D>& node = after.proposal().mid_nodes[e].point;
        if (kinds[e] == EdgeKind::volume || node == before.proposal().mid_nodes[e].point) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        if (distance(onto(EdgeId(e), node).point, node) >
            rounding * distance(mesh.linear.points[a], mesh.linear.points[b]))
            continue;
        ++report.slid_surface_edges;
        --report.relaxed_surface_edges;
    }
}

/// Elements below a bound that is not required are only counted.
template <int D>
std::vector<RemainingReport> remaining_report(std::vector<RemainingElement> elements, const Validation<D>& validation,
                                              const JacobianBound& bound) {
    std::vector<RemainingReport> reports;
    for (const RemainingElement& remaining : elements)
        if (bound.is_explicit || std::ranges::binary_search(validation.not_positive, remaining.element, {},
                                                            [](const auto& entry) { return entry.first; }))
            reports.push_back({remaining.element.index() + 1, remaining.reason,
                               remaining.at.valid() ? remaining.at.index() + 1 : 0, remaining.is_unresolved});
    return reports;
}

/// Boundary nodes may move back to their chords.
template <int D>
struct Relaxed {
    JudgedProposal<D> judged;
    CorrectionReport report;
    MoveBackStatistics<D> uncrossed = {};  ///< nodes that were moved back because walls crossed
    std::optional<Crossings> crossings = {};
};
template <int D>
Outcome<Relaxed<D>> relax_plan(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                               const config::Relax& options, const Execution& execution) {
    auto repaired = repair_or_straighten(judged, guide, options, part_of(execution, 0, 0.95));
    if (!repaired) return fail(repaired.error());
    auto uncrossed = uncross_walls(repaired->judged, guide, options, part_of(execution, 0.95, 1));
    if (!uncrossed) return fail(uncrossed.error());
    if (uncrossed->moved.nodes > 0) {
        repaired->judged = std::move(uncrossed->judged);
        repaired = with_all_changes(judged, std::move(*repaired));
    }
    CorrectionReport report{
        relax_report(repaired->statistics, repaired->unresolved.size(), options.method),
        {},
        remaining_report(remaining_by_limits(*repaired), repaired->judged.validation(), options.min_scaled_jacobian)};
    count_slides(judged, repaired->judged, guide.onto, report.relax);
    return Relaxed<D>{std::move(repaired->judged), std::move(report), uncrossed->moved,
                      std::move(uncrossed->crossings)};
}

template <int D>
bool holds(const Repaired<D>& repaired, const JacobianBound& bound) {
    const Validation<D>& validation = repaired.judged.validation();
    return validation.not_positive.empty() && (!bound.is_explicit || validation.invalid + validation.undecided == 0);
}

double rounded_up(double x) {
    const double digit = pow(10, std::floor(log10(x)) - 2);
    return std::ceil(x / digit) * digit;
}

/// Returns a boundary tolerance with which all elements become valid: the shift that repair without limit needs,
/// verified by a second repair. None: that repair fails, or no larger tolerance is needed.
template <int D>
std::optional<double> tolerance_if_sufficient(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                                              const config::Relax& options, const Execution& execution) {
    Box<D> box;
    for (const Vec<D>& p : judged.mesh().linear.points) box.include(p);
    config::Relax freer = options;
    freer.boundary_tolerance = distance(box.low, box.high);
    const auto free = repair_within(judged, guide, freer, execution);
    if (!free || !holds(*free, options.min_scaled_jacobian)) return std::nullopt;
    const double needed = boundary_shift(judged.mesh(), free->judged.proposal()).largest;
    if (!(needed > options.boundary_tolerance)) return std::nullopt;
    freer.boundary_tolerance = rounded_up(needed);
    const auto again = repair_within(judged, guide, freer, execution);
    if (!again || !holds(*again, options.min_scaled_jacobian)) return std::nullopt;
    return freer.boundary_tolerance;
}

/// The same for a boundary from the input, whose nodes move by at most the tolerance.
template <int D>
Outcome<Relaxed<D>> relax_within_boundary(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                                          const config::Relax& options, const Execution& execution) {
    auto repaired = repair_within(judged, guide, options, execution);
    if (!repaired) return fail(repaired.error());
    const BoundaryShift shift = boundary_shift(judged.mesh(), repaired->judged.proposal());
    CorrectionReport report{
        relax_report(repaired->statistics, repaired->unresolved.size(), options.method),
        InputBoundaryReport{options.boundary_tolerance, {}, shift.moved_nodes, shift.largest, shift.largest_relative},
        remaining_report(remaining(*repaired), repaired->judged.validation(), options.min_scaled_jacobian)};
    count_slides(judged, repaired->judged, guide.onto, report.relax);
    if (!report.remaining.empty() && !guide.onto)
        report.input_boundary->sufficient_tolerance =
            tolerance_if_sufficient(judged, guide, options, without_progress(execution));
    return Relaxed<D>{std::move(repaired->judged), std::move(report)};
}

/// Later verdicts are of corrected elements.
template <int D>
void close(History<D>& history) {
    if (auto* open = std::get_if<Uncorrected<D>>(&history)) {
        Validation<D> before = std::move(open->last).value();
        history = Corrected<D>{std::move(before)};
    }
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Relax& original) {
    if (auto adopted = adopt_own_nodes(run); !adopted) return adopted;
    return run.step_of(original, [&](const Execution& e) -> Outcome<Done> {
        config::Relax options = with_target(original, run.state.target);
        options.min_scaled_jacobian = bound_for(run, original.min_scaled_jacobian);
        if (auto done = judge_plan(run, options.min_scaled_jacobian, part_of(e, 0, 0.05)); !done) return done;
        const JudgedProposal<D>& judged = *run.plan().judged();
        const auto guide = guide_for(run.plan(), judged, run.field(), options, part_of(e, 0.05, 0.1));
        if (!guide) return fail(guide.error());
        const auto relax = run.quadratic().is_boundary_from_input() ? relax_within_boundary<D> : relax_plan<D>;
        auto result = relax(judged, *guide, options, part_of(e, 0.1, 1));
        if (!result) return fail(result.error());
        add(run.report, result->report);
        if (const MoveBackStatistics<D>& moved = result->uncrossed; moved.nodes > 0)
            run.state.relaxed_walls = relaxed_walls_report(moved);
        if (result->crossings)
            run.state.crossings = KnownCrossings<D>{result->judged.proposal().points,
                                                    result->judged.proposal().mid_nodes, std::move(*result->crossings)};
        close(run.state.history);
        run.plan().places = std::move(result->judged);
        report_verdicts(run, *run.plan().validation());
        return Done{};
    });
}

template <int D>
JacobianBound bound_for(Runner<D>& run, const JacobianBound& of_stage) {
    if (of_stage.is_explicit) run.state.bound = of_stage;
    return run.state.bound;
}

template <int D>
void report_verdicts(Runner<D>& run, const Validation<D>& validation) {
    add(run.report, verdicts_report(validation, run.state.bound.is_explicit));
    auto* const open = std::get_if<Uncorrected<D>>(&run.state.history);
    if (!open) return;
    open->last = validation;
    run.report.validity_before = run.report.validity;
}

template <int D>
Outcome<Done> judge_plan(Runner<D>& run, double bound, const Execution& execution) {
    Plan<D>& plan = run.plan();
    const JudgedProposal<D>* const there = plan.judged();
    if (!there || there->validation().bound != bound) {
        auto judged = validate(run.quadratic().mesh, plan.proposal(), bound, execution);
        if (!judged) return fail(judged.error());
        plan.places = std::move(*judged);
    }
    report_verdicts(run, *plan.validation());
    return Done{};
}

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Validate& options) {
    return run.step_of(options, [&](const Execution& e) -> Outcome<Done> {
        const double bound = bound_for(run, options.min_scaled_jacobian);
        if (run.quadratic().planned()) return judge_plan(run, bound, e);
        auto validation = validate(run.quadratic().mesh, bound, e);
        if (!validation) return fail(validation.error());
        report_verdicts(run, *validation);
        run.quadratic().plan = Unplanned<D>{std::move(*validation)};
        return Done{};
    });
}

namespace {

RemeshedNodesReport remeshed_nodes(CurvingAim aim) {
    const Objective objective = aim == CurvingAim::accuracy ? Objective::accuracy
                                : aim == CurvingAim::energy ? Objective::energy
                                                            : Objective::length;
    return {.objective = std::string(word_of(objective))};
}

bool places_nodes_anew(const config::Pipeline& pipeline) {
    bool anew = false;
    for (const config::Stage& stage : pipeline.stages)
        std::visit(
            [&]<class Options>(const Options&) {
                if (changes_topology<Options>()) anew = false;
                if (std::is_same_v<Options, config::Curve> || std::is_same_v<Options, config::Reinsert>) anew = true;
            },
            stage);
    return anew;
}

std::vector<Histogram> with_after(std::vector<Histogram> histograms, const std::vector<Histogram>& after) {
    for (std::size_t i = 0; i < histograms.size(); ++i) histograms[i].series.push_back(after[i].series.front());
    return histograms;
}

template <int D>
Outcome<Done> finish_rows(Runner<D>& run, Changing<D>& changing) {
    RemeshedRows<D> remeshed = std::move(*changing.shared);
    std::optional<UnitMeshOfRanks> measured;
    auto result = run.step("finish", [&](const Execution& e) -> Outcome<FinishedRows<D>> {
        const auto own = measured_rows(remeshed.shared, *run.sources.ranks, part_of(e, 0, 0.5));
        if (!own) return fail(own.error());
        auto all = unit_mesh_of_ranks(changing.metric.source, *own, *run.sources.ranks);
        if (!all) return fail(all.error());
        measured = std::move(*all);
        return finished_rows(std::move(remeshed.shared), remeshed.original, *run.sources.ranks);
    });
    if (!result) return fail(result.error());
    run.report.remesh->after = std::move(measured->report);
    add(run.report.histograms, with_after(std::move(changing.histograms), measured->histograms));
    run.state.rows = std::move(*result);
    run.state.mesh = LinearMesh<D>{};
    return Done{};
}

}  // namespace

template <int D>
Outcome<Done> finish(Runner<D>& run) {
    auto* const changing = std::get_if<Changing<D>>(&run.state.mesh);
    if (changing == nullptr) return Done{};
    if (changing->shared) return finish_rows(run, *changing);
    UnitMesh measured;
    std::optional<VerdictsReport> verdicts;  // degree 2: earlier verdicts are of the mesh before the passes
    std::optional<RemeshedNodesReport> placed_for;
    std::optional<BoundedFacetsReport> bounded;
    auto result = run.step("finish", [&](const Execution& e) -> Outcome<FinishedMesh<D>> {
        const auto facets = bounded_facets(changing->mesh, changing->goal, without_progress(e));
        if (!facets) return fail(facets.error());
        if (facets->limited + facets->far > 0) bounded = BoundedFacetsReport{facets->limited, facets->far};
        auto mesh = finished(changing->mesh, part_of(e, 0, 0.6));
        if (!mesh) return mesh;
        changing->mesh = {};  // frees memory as large as the finished mesh
        const auto& [linear, edges, nodes, maps] = mesh->compact;
        const Execution rest = part_of(e, 0.6, 1);
        const std::string& metric = changing->metric.source;
        if (!nodes.empty()) {
            auto validation = validate(QuadraticMesh<D>{linear, edges, nodes}, run.state.bound, without_progress(e));
            if (!validation) return fail(validation.error());
            verdicts = verdicts_report(*validation, run.state.bound.is_explicit);
            if (!places_nodes_anew(run.config)) placed_for = remeshed_nodes(run.state.curving.aim);
        }
        auto in_metric =
            nodes.empty() ? measure_unit_mesh(linear, edges, mesh->log_metrics, metric, rest)
                          : measure_unit_mesh(QuadraticMesh<D>{linear, edges, nodes}, mesh->log_metrics, metric, rest);
        if (!in_metric) return fail(in_metric.error());
        measured = std::move(*in_metric);
        return mesh;
    });
    if (!result) return fail(result.error());
    auto histograms = with_after(std::move(changing->histograms), histograms_of(measured, "remeshed"));
    if (bounded && bounded->limited > 0)
        run.note(std::to_string(bounded->limited) +
                 " boundary facets are finer than the metric requests, so that the boundary stays close to its "
                 "geometry; --geometry-error sets another bound, or none");
    RemeshReport& remesh = *run.report.remesh;
    remesh.after = std::move(measured.report);
    remesh.bounded_facets = bounded;
    if (placed_for) remesh.nodes = std::move(placed_for);
    add(run.report.histograms, std::move(histograms));
    if (verdicts) add(run.report, std::move(*verdicts));
    const bool has_mesh = file_with_mesh(run.config, run.files) != nullptr;
    run.state.inherited = Inherited<D>{
        std::move(*changing->goal.geometry), std::move(result->log_metrics), std::move(changing->metric),
        has_mesh ? std::optional(std::move(changing->goal.field)) : std::nullopt, std::move(changing->goal.curves)};
    run.state.input_points = result->compact.mesh.points;
    run.state.input_nodes = {};
    auto& [linear, edges, nodes, maps] = result->compact;
    if (nodes.empty())
        run.state.mesh = std::move(linear);
    else {
        run.state.input_nodes = Column<LagrangeNode<D>>(std::move(nodes));
        run.state.mesh = Quadratic<D>{{std::move(linear), std::move(edges), run.state.input_nodes}, NodesOf::input, {}};
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                   \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Relax&);          \
    template JacobianBound bound_for<D>(Runner<D>&, const JacobianBound&);      \
    template void report_verdicts<D>(Runner<D>&, const Validation<D>&);         \
    template Outcome<Done> judge_plan<D>(Runner<D>&, double, const Execution&); \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Validate&);       \
    template Outcome<Done> finish<D>(Runner<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
