module;
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.cavity;
import camber.config;
import camber.metric;
import camber.repair;
import camber.validity;
import :parts;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// What the walk over the vertices made.
template <int D>
struct Walked {
    Reinserted<D> done;
    Validation<D> wanted, validation;  ///< of the targets, and in the end
    CurveReport curve;
    CavitiesReport report;
    Notices notices;
};
template <int D>
Outcome<Walked<D>> walk_cavities(const QuadraticMesh<D>& mesh, const CurveInput<D>& input, const BackMesh<D>& field,
                                 const config::Reinsert& options, const Execution& execution) {
    const ReinsertAllOptions all{{edge_options(options.curve), options.relax}, options.max_turns};
    auto done = reinsert_all(mesh, input.kinds, input.base, field, all, part_of(execution, 0, 0.98));
    if (!done) return fail(done.error());
    const double bound = options.relax.min_scaled_jacobian;
    const auto judged = validate(mesh, done->wanted.proposal, bound, part_of(execution, 0.98, 0.99));
    if (!judged) return fail(judged.error());
    const Validation<D>& wanted = judged->validation();
    const auto now = validate(mesh, done->proposal, bound, part_of(execution, 0.99, 1));
    if (!now) return fail(now.error());

    const ReinsertStatistics& s = done->statistics;
    CavitiesReport report{verdicts_report(wanted, options.relax.min_scaled_jacobian.is_asked).summary,
                          relax_report(changes_between(*judged, *now), 0, options.relax.method),
                          ReinsertReport{s.turns, s.rounds, s.patches, s.not_valid, s.no_gain}};
    Notices notices;
    if (s.left > 0) notices.push_back(std::to_string(s.left) + " vertices could have another turn: max_turns ended it");
    CurveReport curve = curve_report(mesh, done->wanted);
    return Walked<D>{std::move(*done),  wanted, now->validation(), std::move(curve), std::move(report),
                     std::move(notices)};
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Reinsert& given) {
    config::Reinsert options = given;
    options.relax.min_scaled_jacobian = bound_for(run, given.relax.min_scaled_jacobian);
    if (options.curve.objective == config::Objective::shape)
        return fail(ErrorKind::usage, "reinsert: the objective shape is of whole meshes, not of cavities", {}, {},
                    "take the stage curve, or another objective");
    run.state.curving = edge_options(options.curve);
    if (std::holds_alternative<Changing<D>>(run.state.mesh)) return reinsert_between_passes(run, options);
    auto boundary = describe_boundary(run, run.quadratic().mesh.linear, run.quadratic().mesh.edges);
    if (!boundary) return fail(boundary.error());
    auto input = begin_curving(run, *boundary, options.curve);
    if (!input) return fail(input.error());
    input = make_field(run, *boundary, std::move(*input), edge_options(options.curve).aim);
    if (!input) return fail(input.error());
    return run.step_of(given, [&](const Execution& e) -> Outcome<Done> {
        Quadratic<D>& at = run.quadratic();
        input = moved_input(run, *boundary, std::move(*input), *run.field(), options.curve, without_progress(e));
        if (!input) return fail(input.error());
        run.tell(input->notices);
        auto timed = run.timed([&] { return walk_cavities(at.mesh, *input, *run.field(), options, e); });
        if (!timed.value) return fail(timed.value.error());
        Walked<D>& made = *timed.value;
        run.tell(made.report);
        run.tell(made.notices);
        tell_curve(run, made.curve, timed.seconds);
        run.state.history = Corrected<D>{std::move(made.wanted)};
        at.mesh = std::move(made.done.mesh);
        at.plan = Plan<D>{Wanted<D>{std::move(*boundary), std::move(input->shells), std::move(made.done.wanted),
                                    edge_options(options.curve).aim, std::move(input->extended)},
                          Settled<D>{std::move(made.done.proposal), std::move(made.validation)}};
        enter(run, *at.validation());
        run.tell(CommitReport{});
        return Done{};
    });
}

template Outcome<Done> apply<2>(Runner<2>&, const config::Reinsert&);
template Outcome<Done> apply<3>(Runner<3>&, const config::Reinsert&);

}  // namespace camber::run
