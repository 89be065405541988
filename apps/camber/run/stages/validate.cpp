module;
#include <optional>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.config;
import camber.validity;
import :parts;
import :runner;
import :state;
import :steps;

namespace camber::run {

template <int D>
JacobianBound bound_for(Runner<D>& run, const JacobianBound& of_stage) {
    if (of_stage.is_asked) run.state.bound = of_stage;
    return run.state.bound;
}

template <int D>
void report_verdicts(Runner<D>& run, const Validation<D>& validation) {
    const VerdictsReport part = verdicts_report(validation, run.state.bound.is_asked);
    run.report(part);
    auto* const open = std::get_if<Uncorrected<D>>(&run.state.history);
    if (!open) return;
    open->last = validation;
    run.report(BeforeReport{part.summary});
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

#define CAMBER_INSTANTIATE(D)                                                   \
    template JacobianBound bound_for<D>(Runner<D>&, const JacobianBound&);      \
    template void report_verdicts<D>(Runner<D>&, const Validation<D>&);         \
    template Outcome<Done> judge_plan<D>(Runner<D>&, double, const Execution&); \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Validate&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
