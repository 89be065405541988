module;
#include <optional>
#include <string>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.metric;
import camber.programmes;
import camber.validity;
import :mend;
import :parts;
import :report;
import :runner;
import :state;
import :steps;

namespace camber::run {

namespace {

template <int D>
Outcome<Column<QuadraticModel<D>>> models_for(const Column<LagrangeNode<D>>& wanted, const Incidence<ElementId>& shells,
                                              const JudgedProposal<D>& judged, const BackMesh<D>* field,
                                              const Execution& execution) {
    auto models = field ? edge_models(judged.mesh(), wanted, judged.validation(), shells, *field, execution)
                        : implied_edge_models(judged.mesh(), wanted, shells, execution);
    if (!models) return fail(models.error());
    return Column<QuadraticModel<D>>(std::move(*models));
}

template <int D>
RelaxReport relax_report(const Mended<D>& mended, config::Repair repair) {
    return {std::string(word_of(repair)), mended.corrected_elements, mended.moved_volume_nodes,
            mended.moved_surface_nodes,   mended.moved_vertices,     mended.work,
            mended.given_up.size()};
}

/// Models of what a node off its wanted place costs: in the field, or in the mesh's own metric where there is none
/// (null). None for repairs that take none.
template <int D>
Outcome<Column<QuadraticModel<D>>> models_of(const Plan<D>& plan, const JudgedProposal<D>& judged,
                                             const BackMesh<D>* field, config::Repair repair,
                                             const Execution& execution) {
    if (!needs_models(repair)) return Column<QuadraticModel<D>>();
    if (const Wanted<D>* wanted = plan.wanted())
        return models_for(wanted->curved.proposal.mid_nodes, wanted->shells, judged, field, execution);
    const auto around = shells(judged.mesh().edges, execution);
    if (!around) return fail(around.error());
    const auto wishes = own_wishes(judged, *around, execution);
    if (!wishes) return fail(wishes.error());
    return models_for(*wishes, *around, judged, field, execution);
}

/// What is not valid mended; boundary nodes may go back to their chords.
template <int D>
struct Relaxed {
    JudgedProposal<D> judged;
    CorrectionReport report;
};
template <int D>
Outcome<Relaxed<D>> relaxed(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                            const config::Relax& options, const Execution& execution) {
    auto mended = mend_or_straighten(judged, models, options, execution);
    if (!mended) return fail(mended.error());
    CorrectionReport report{relax_report(*mended, options.repair), {}, remaining_but_for_shape(*mended)};
    return Relaxed<D>{std::move(mended->judged), std::move(report)};
}

/// The same where the boundary is given: it stays, but for the options' tolerance.
template <int D>
Outcome<Relaxed<D>> relaxed_within(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                                   const config::Relax& options, const Execution& execution) {
    auto mended = mend_within(judged, models, options, execution);
    if (!mended) return fail(mended.error());
    CorrectionReport report{relax_report(*mended, options.repair),
                            kept_boundary(judged.mesh(), mended->judged.proposal(), options.boundary_tolerance),
                            remaining(*mended)};
    return Relaxed<D>{std::move(mended->judged), std::move(report)};
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
        const auto models = models_of(run.plan(), judged, run.field(), options.repair, e);
        if (!models) return fail(models.error());
        const auto relax = run.quadratic().boundary_is_given() ? relaxed_within<D> : relaxed<D>;
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
