module;
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.metric;
import camber.programmes;
import camber.repair;
import camber.validity;
import :parts;
import :report;
import :runner;
import :state;
import :steps;

namespace camber::run {

namespace {

template <int D>
Outcome<Column<QuadraticModel<D>>> models_for(const Wanted<D>& wanted, const JudgedProposal<D>& judged,
                                              const BackMesh<D>* field, const Execution& execution) {
    const Column<LagrangeNode<D>>& nodes = wanted.curved.proposal.mid_nodes;
    auto models =
        field ? edge_models(wanted.aim, judged.mesh(), nodes, judged.validation(), wanted.shells, *field, execution)
              : implied_edge_models(judged.mesh(), nodes, wanted.shells, execution);
    if (!models) return fail(models.error());
    return Column<QuadraticModel<D>>(std::move(*models));
}

/// Models of what a node off its wanted place costs: in the field, or in the mesh's own metric where there is none
/// (null). None for methods that take none.
template <int D>
Outcome<Column<QuadraticModel<D>>> models_of(const Plan<D>& plan, const JudgedProposal<D>& judged,
                                             const BackMesh<D>* field, RepairMethod method,
                                             const Execution& execution) {
    if (!needs_models(method)) return Column<QuadraticModel<D>>();
    if (const Wanted<D>* wanted = plan.wanted()) return models_for(*wanted, judged, field, execution);
    const auto around = shells(judged.mesh().edges, execution);
    if (!around) return fail(around.error());
    return own_models(judged, *around, execution);
}

std::vector<RemainingReport> remaining_report(std::vector<RemainingElement> elements) {
    std::vector<RemainingReport> reports;
    reports.reserve(elements.size());
    for (auto& [element, reason] : elements) reports.push_back({element.index() + 1, std::move(reason)});
    return reports;
}

/// What is not valid repaired; boundary nodes may go back to their chords.
template <int D>
struct Relaxed {
    JudgedProposal<D> judged;
    CorrectionReport report;
};
template <int D>
Outcome<Relaxed<D>> relax_plan(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                               const config::Relax& options, const Execution& execution) {
    auto repaired = repair_or_straighten(judged, models, options, execution);
    if (!repaired) return fail(repaired.error());
    CorrectionReport report{relax_report(repaired->statistics, repaired->given_up.size(), options.method),
                            {},
                            remaining_report(remaining_but_for_shape(*repaired))};
    return Relaxed<D>{std::move(repaired->judged), std::move(report)};
}

/// The same where the boundary is given: it stays, but for the options' tolerance.
template <int D>
Outcome<Relaxed<D>> relax_within_boundary(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                                          const config::Relax& options, const Execution& execution) {
    auto repaired = repair_within(judged, models, options, execution);
    if (!repaired) return fail(repaired.error());
    const BoundaryShift shift = boundary_shift(judged.mesh(), repaired->judged.proposal());
    CorrectionReport report{
        relax_report(repaired->statistics, repaired->given_up.size(), options.method),
        KeptBoundaryReport{options.boundary_tolerance, shift.moved_nodes, shift.largest, shift.largest_relative},
        remaining_report(remaining(*repaired))};
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
Outcome<Done> apply(Runner<D>& run, const config::Relax& options) {
    if (auto adopted = adopt_own_nodes(run); !adopted) return adopted;
    return run.step_of(options, [&](const Execution& e) -> Outcome<Done> {
        if (auto done = judge_plan(run, options.min_scaled_jacobian, e); !done) return done;
        const JudgedProposal<D>& judged = *run.plan().judged();
        const auto models = models_of(run.plan(), judged, run.field(), options.method, e);
        if (!models) return fail(models.error());
        const auto relax = run.quadratic().boundary_is_given() ? relax_within_boundary<D> : relax_plan<D>;
        auto made = relax(judged, *models, options, e);
        if (!made) return fail(made.error());
        run.tell(made->report);
        close(run.state.history);
        run.plan().places = std::move(made->judged);
        enter(run, *run.plan().validation());
        return Done{};
    });
}

template Outcome<Done> apply<2>(Runner<2>&, const config::Relax&);
template Outcome<Done> apply<3>(Runner<3>&, const config::Relax&);

}  // namespace camber::run
