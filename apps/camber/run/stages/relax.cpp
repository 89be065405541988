module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import camber.validity;
import :parts;
import :report;
import :runner;
import :state;
import :steps;

namespace camber::run {

namespace {

/// What repair goes by.
template <int D>
Outcome<RepairGuide<D>> guide_for(const Plan<D>& plan, const JudgedProposal<D>& judged, const BackMesh<D>* field,
                                  RepairMethod method, const Execution& execution) {
    std::optional<WantedNodes<D>> nodes;
    if (const Wanted<D>* wanted = plan.wanted())
        nodes.emplace(WantedNodes<D>{wanted->curved, wanted->shells, wanted->extended, wanted->aim, field});
    return make_guide(judged, nodes, plan.boundary(), method, execution);
}

/// Nodes of the boundary that repair moved, and that are on the geometry still, are counted apart; vertices of the
/// boundary slide at most.
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

/// Those that are a failure: what is only below a bound that nobody asked for is counted.
template <int D>
std::vector<RemainingReport> remaining_report(std::vector<RemainingElement> elements, const Validation<D>& validation,
                                              const JacobianBound& bound) {
    std::vector<RemainingReport> reports;
    for (const RemainingElement& remaining : elements)
        if (bound.is_asked || std::ranges::binary_search(validation.not_positive, remaining.element, {},
                                                         [](const auto& entry) { return entry.first; }))
            reports.push_back({remaining.element.index() + 1, remaining.reason,
                               remaining.at.valid() ? remaining.at.index() + 1 : 0, remaining.is_given_up});
    return reports;
}

/// Elements that are not valid are repaired; boundary nodes may go back to their chords.
template <int D>
struct Relaxed {
    JudgedProposal<D> judged;
    CorrectionReport report;
    MovedBack<D> uncrossed = {};  ///< nodes that were moved back because walls crossed
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
    CorrectionReport report{relax_report(repaired->statistics, repaired->given_up.size(), options.method),
                            {},
                            remaining_report(remaining_but_for_shape(*repaired), repaired->judged.validation(),
                                             options.min_scaled_jacobian)};
    count_slides(judged, repaired->judged, guide.onto, report.relax);
    return Relaxed<D>{std::move(repaired->judged), std::move(report), uncrossed->moved,
                      std::move(uncrossed->crossings)};
}

/// Whether everything that was asked holds.
template <int D>
bool holds(const Repaired<D>& repaired, const JacobianBound& bound) {
    const Validation<D>& validation = repaired.judged.validation();
    return validation.not_positive.empty() && (!bound.is_asked || validation.invalid + validation.undecided == 0);
}

/// In three digits, not below x.
double rounded_up(double x) {
    const double digit = pow(10, std::floor(log10(x)) - 2);
    return std::ceil(x / digit) * digit;
}

/// A tolerance of the boundary by which all elements become valid: what repair needs where it may take any, tried
/// again. None: it does not, or nothing has to move.
template <int D>
std::optional<double> tolerance_that_would_do(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
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

/// The same where the boundary is given: it stays, but for the options' tolerance.
template <int D>
Outcome<Relaxed<D>> relax_within_boundary(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                                          const config::Relax& options, const Execution& execution) {
    auto repaired = repair_within(judged, guide, options, execution);
    if (!repaired) return fail(repaired.error());
    const BoundaryShift shift = boundary_shift(judged.mesh(), repaired->judged.proposal());
    CorrectionReport report{
        relax_report(repaired->statistics, repaired->given_up.size(), options.method),
        KeptBoundaryReport{options.boundary_tolerance, {}, shift.moved_nodes, shift.largest, shift.largest_relative},
        remaining_report(remaining(*repaired), repaired->judged.validation(), options.min_scaled_jacobian)};
    count_slides(judged, repaired->judged, guide.onto, report.relax);
    if (!report.remaining.empty() && !guide.onto)
        report.kept_boundary->would_do = tolerance_that_would_do(judged, guide, options, without_progress(execution));
    return Relaxed<D>{std::move(repaired->judged), std::move(report)};
}

/// Verdicts that come are of what was corrected.
template <int D>
void close(History<D>& history) {
    if (auto* open = std::get_if<Uncorrected<D>>(&history)) {
        Validation<D> before = std::move(open->last).value();
        history = Corrected<D>{std::move(before)};
    }
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Relax& given) {
    if (auto adopted = adopt_own_nodes(run); !adopted) return adopted;
    return run.step_of(given, [&](const Execution& e) -> Outcome<Done> {
        config::Relax options = given;
        options.min_scaled_jacobian = bound_for(run, given.min_scaled_jacobian);
        if (auto done = judge_plan(run, options.min_scaled_jacobian, part_of(e, 0, 0.05)); !done) return done;
        const JudgedProposal<D>& judged = *run.plan().judged();
        const auto guide = guide_for(run.plan(), judged, run.field(), options.method, part_of(e, 0.05, 0.1));
        if (!guide) return fail(guide.error());
        const auto relax = run.quadratic().boundary_is_given() ? relax_within_boundary<D> : relax_plan<D>;
        auto made = relax(judged, *guide, options, part_of(e, 0.1, 1));
        if (!made) return fail(made.error());
        run.report(made->report);
        if (const MovedBack<D>& moved = made->uncrossed; moved.nodes > 0)
            run.state.relaxed_walls = relaxed_walls_report(moved);
        if (made->crossings)
            run.state.crossings = KnownCrossings<D>{made->judged.proposal().points, made->judged.proposal().mid_nodes,
                                                    std::move(*made->crossings)};
        close(run.state.history);
        run.plan().places = std::move(made->judged);
        report_verdicts(run, *run.plan().validation());
        return Done{};
    });
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> apply<D>(Runner<D>&, const config::Relax&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
