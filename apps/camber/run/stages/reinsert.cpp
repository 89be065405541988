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
import camber.recipes;
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

/// Verdicts of the nodes as they were wanted, and in the end.
template <int D>
struct Verdicts {
    JudgedProposal<D> wanted, made;
};
template <int D>
Outcome<Verdicts<D>> judged(const QuadraticMesh<D>& mesh, const ReinsertedNodes<D>& nodes, const JacobianBound& bound,
                            const Execution& execution) {
    auto wanted = validate(mesh, nodes.wanted.curved.proposal, bound, part_of(execution, 0, 0.5));
    if (!wanted) return fail(wanted.error());
    auto made = validate(mesh, nodes.made.proposal, bound, part_of(execution, 0.5, 1));
    if (!made) return fail(made.error());
    return Verdicts<D>{std::move(*wanted), std::move(*made)};
}

template <int D>
CavitiesReport cavities_report(const Reinserted<D>& made, const Verdicts<D>& verdicts, const JacobianBound& bound,
                               RepairMethod method) {
    const PassStatistics& s = made.statistics;
    return {
        verdicts_report(verdicts.wanted.validation(), bound.is_asked).summary,
        relax_report(changes_between(verdicts.wanted, verdicts.made), 0, method),
        ReinsertReport{made.sweeps, s.rounds, s.accepted, s.of(RejectionReason::volume), s.of(RejectionReason::gain)}};
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
    MetricTold told;
    const auto metric = metric_for_curving(run, at.mesh, *boundary, told);
    Clocks clocks;
    auto nodes = reinsert_nodes<D>({at.mesh, at.nodes, *boundary}, metric,
                                   {static_cast<const ProposeOptions&>(options.curve),
                                    {.min_scaled_jacobian = bound.is_asked ? bound.value : min_bound,
                                     .target = options.relax.aim(),
                                     .max_sweeps = options.max_sweeps}},
                                   run.around(clocks));
    if (!nodes) return fail(nodes.error());
    auto verdicts = run.step("validate", [&](const Execution& e) { return judged(at.mesh, *nodes, bound, e); });
    if (!verdicts) return fail(verdicts.error());
    report_metric(run, std::move(told));
    report_curves(run, nodes->wanted, options.curve, clocks.seconds["reinsert"]);
    run.report(cavities_report(nodes->made, *verdicts, bound, options.relax.method));
    if (nodes->made.left > 0)
        run.report(
            Notices{std::to_string(nodes->made.left) + " vertices could have another sweep: max_sweeps ended it"});
    run.state.history = Corrected<D>{verdicts->wanted.validation()};
    at.mesh.mid_nodes = nodes->made.proposal.mid_nodes;
    at.plan = Plan<D>{keep_field(run, std::move(*boundary), std::move(nodes->wanted), aim),
                      CommittedPlaces<D>{std::move(nodes->made.proposal), verdicts->made.validation()}};
    report_verdicts(run, *at.validation());
    run.report(CommitReport{});
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> apply<D>(Runner<D>&, const config::Reinsert&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
