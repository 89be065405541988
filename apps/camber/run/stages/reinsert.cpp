module;
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.cavity;
import camber.metric;
import camber.operation;
import camber.adapt;
import camber.repair;
import camber.surface;
import camber.validity;
import :parts;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// Options of `relax` that a cavity has no use for are refused where they are not the defaults.
Outcome<Done> check_options(const config::Reinsert& options) {
    if (options.curve.objective == config::Objective::shape)
        return fail(ErrorKind::usage, "reinsert: the objective shape is of whole meshes, not of cavities", {}, {},
                    "take the stage curve, or another objective");
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
                    " is of repair, which works on whole meshes; a cavity draws back the nodes "
                    "at its point",
                {}, {}, "leave it out, or take the stages curve, validate and relax");
}

/// What the walk over the vertices made.
template <int D>
struct Walked {
    Curved<D> wanted;  ///< the targets of all edges: what `curve` would propose
    Proposal<D> proposal;
    Validation<D> before, after;  ///< of the targets, and in the end
    CurveReport curve;
    CavitiesReport report;
    Notices notices;
};
template <int D>
Outcome<Walked<D>> walk_cavities(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary, const CurveInput<D>& input,
                                 const BackMesh<D>& field, const config::Reinsert& options,
                                 const Execution& execution) {
    auto wanted = curve(mesh, input.kinds, input.base, input.shells, field, edge_options(options.curve),
                        part_of(execution, 0, 0.2));
    if (!wanted) return fail(wanted.error());
    const JacobianBound& bound = options.relax.min_scaled_jacobian;
    const ReinsertionOptions by{.min_scaled_jacobian = bound.is_asked ? bound.value : min_bound,
                                .target = options.relax.aim(),
                                .max_turns = options.max_turns};
    const auto corners = corners_of(boundary.features);
    auto made = reinsert(mesh, wanted->proposal, {boundary.features.edge_kinds.view(), corners}, field, by,
                         part_of(execution, 0.2, 0.98));
    if (!made) return fail(made.error());
    const auto judged = validate(mesh, wanted->proposal, bound, part_of(execution, 0.98, 0.99));
    if (!judged) return fail(judged.error());
    const auto now = validate(mesh, made->proposal, bound, part_of(execution, 0.99, 1));
    if (!now) return fail(now.error());

    const PassStatistics& s = made->statistics;
    CavitiesReport report{
        verdicts_report(judged->validation(), bound.is_asked).summary,
        relax_report(changes_between(*judged, *now), 0, options.relax.method),
        ReinsertReport{made->turns, s.rounds, s.accepted, s.of(RejectionReason::volume), s.of(RejectionReason::gain)}};
    Notices notices;
    if (made->left > 0)
        notices.push_back(std::to_string(made->left) + " vertices could have another turn: max_turns ended it");
    CurveReport curve = curve_report(mesh, *wanted);
    return Walked<D>{std::move(*wanted), std::move(made->proposal), judged->validation(), now->validation(),
                     std::move(curve),   std::move(report),         std::move(notices)};
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Reinsert& given) {
    config::Reinsert options = given;
    options.relax.min_scaled_jacobian = bound_for(run, given.relax.min_scaled_jacobian);
    if (auto checked = check_options(given); !checked) return checked;
    run.state.curving = edge_options(options.curve);
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
        run.report(input->notices);
        auto timed = run.timed([&] { return walk_cavities(at.mesh, *boundary, *input, *run.field(), options, e); });
        if (!timed.value) return fail(timed.value.error());
        Walked<D>& made = *timed.value;
        run.report(made.report);
        run.report(made.notices);
        report_curve(run, made.curve, timed.seconds);
        run.state.history = Corrected<D>{std::move(made.before)};
        at.mesh.mid_nodes = made.proposal.mid_nodes;
        at.plan = Plan<D>{Wanted<D>{std::move(*boundary), std::move(input->shells), std::move(made.wanted),
                                    edge_options(options.curve).aim, std::move(input->extended)},
                          CommittedPlaces<D>{std::move(made.proposal), std::move(made.after)}};
        report_verdicts(run, *at.validation());
        run.report(CommitReport{});
        return Done{};
    });
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> apply<D>(Runner<D>&, const config::Reinsert&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
