module;
#include <cstddef>
#include <cstdint>
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

namespace {

SoundnessReport soundness_report(const Soundness& s) {
    SoundnessReport report{.sound = s.sound(), .empty = s.empty, .findings = {}};
    for (std::size_t i = 0; i < defect_count; ++i) {
        const Defect defect{static_cast<std::uint8_t>(i)};
        const Finding& found = s[defect];
        report.findings.push_back({key(defect), found.count, found.first, found.other,
                                   gravity(defect) != Gravity::harmless,
                                   found.count > 0 ? sentence(s, defect) : std::string()});
    }
    return report;
}

}  // namespace

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

template <int D>
Outcome<State<D>> examine_stage(State<D> state, Report& report, const Execution& execution) {
    auto found = state.mesh ? examine(*state.mesh, execution) : examine(state.linear, execution);
    if (!found) return fail(found.error());
    report.soundness = soundness_report(*found);
    return state;
}

#define CAMBER_INSTANTIATE(D)                                                         \
    template Outcome<State<D>> prepare_stage<D>(State<D>, Report&, const Execution&); \
    template Outcome<State<D>> examine_stage<D>(State<D>, Report&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
