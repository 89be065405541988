module;
#include <string>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.surface;
import camber.validity;
import :report;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<State<D>> prepare_stage(State<D> state, Report& report, const Execution& execution) {
    const auto enter = [&](std::vector<std::string>& notices) {
        report.notices.insert(report.notices.end(), notices.begin(), notices.end());
    };
    if (state.mesh) {
        state.linear = {};
        auto prepared = prepare(std::move(*state.mesh), execution);
        if (!prepared) return fail(prepared.error());
        enter(prepared->notices);
        state.linear = prepared->mesh.linear;
        state.mesh = std::move(prepared->mesh);
    } else {
        auto prepared = prepare(std::move(state.linear), execution);
        if (!prepared) return fail(prepared.error());
        enter(prepared->notices);
        state.linear = std::move(prepared->mesh);
    }
    return state;
}

template Outcome<State<2>> prepare_stage<2>(State<2>, Report&, const Execution&);
template Outcome<State<3>> prepare_stage<3>(State<3>, Report&, const Execution&);

}  // namespace camber::run
