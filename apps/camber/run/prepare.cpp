module;
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.surface;
import camber.validity;
import camber.soundness;
import :report;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<State<D>> prepare_stage(State<D> state, Report& report, const Execution& execution) {
    const auto done = std::visit(
        [&](auto& mesh) -> Outcome<Done> {
            auto prepared = prepare(std::move(mesh), execution);
            if (!prepared) return fail(prepared.error());
            report.notices.insert(report.notices.end(), prepared->notices.begin(), prepared->notices.end());
            mesh = std::move(prepared->mesh);
            return Done{};
        },
        state.mesh);
    if (!done) return fail(done.error());
    state.given_points = state.linear().points;
    return state;
}

template Outcome<State<2>> prepare_stage<2>(State<2>, Report&, const Execution&);
template Outcome<State<3>> prepare_stage<3>(State<3>, Report&, const Execution&);

}  // namespace camber::run
