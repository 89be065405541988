module;
#include <cstddef>
#include <functional>
#include <string_view>
#include <utility>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;

namespace camber {

namespace {

/// One pass after another, as long as none fails.
template <int D>
class Driving {
  public:
    Driving(Remeshing<D> state, const RemeshingGoal<D>& goal, const AroundPass& around)
        : state_(std::move(state)), goal_(goal), around_(around) {}

    template <class Options>
    using Verb = Outcome<Remeshed<D>> (*)(Remeshing<D>, const RemeshingGoal<D>&, const Options&, const Execution&);

    template <class Options>
    [[nodiscard]] Outcome<Done> pass(std::string_view name, Verb<Options> verb, const Options& options,
                                     PassStatistics& statistics) {
        return around_(name, [&](const Execution& execution) -> Outcome<Done> {
            auto done = verb(std::move(state_), goal_, options, execution);
            if (!done) return fail(done.error());
            state_ = std::move(done->state);
            statistics += done->statistics;
            return Done{};
        });
    }
    [[nodiscard]] Outcome<Done> measure(UnitMeshStatistics& out) const {
        return around_("lengths", [&](const Execution& execution) -> Outcome<Done> {
            auto measured = unit_mesh_statistics(state_, execution);
            if (!measured) return fail(measured.error());
            out = *measured;
            return Done{};
        });
    }
    [[nodiscard]] Remeshing<D> state() && { return std::move(state_); }

  private:
    Remeshing<D> state_;
    const RemeshingGoal<D>& goal_;
    const AroundPass& around_;
};

bool has_settled(const UnitMeshStatistics& before, const UnitMeshStatistics& after, std::size_t changed_vertices,
                 double least_change) {
    const auto vertices = static_cast<double>(after.edges) / 7;  // of tetrahedra; of triangles fewer edges each
    return after.unit_share() - before.unit_share() < least_change &&
           static_cast<double>(changed_vertices) < least_change * vertices;
}

template <int D>
Outcome<BroughtToMetric<D>> driven(Remeshing<D> state, const RemeshingGoal<D>& goal, const ToMetricOptions& options,
                                   const AroundPass& around) {
    Driving<D> driving(std::move(state), goal, around);
    ToMetricStatistics s;
    if (auto begin = driving.measure(s.before); !begin) return fail(begin.error());
    s.after = s.before;
    bool is_settled = false;
    while (!is_settled && s.rounds < options.rounds) {
        const UnitMeshStatistics before = s.after;
        const std::size_t changes = s.collapse.accepted + s.split.accepted;
        const auto done =
            driving.pass("collapse", &collapse<D>, options.collapse, s.collapse)
                .and_then([&](Done) { return driving.pass("split", &split<D>, options.split, s.split); })
                .and_then([&](Done) { return driving.pass("swap", &swap<D>, options.swap, s.swap); })
                .and_then([&](Done) { return driving.pass("smooth", &smooth<D>, options.smooth, s.smooth); })
                .and_then([&](Done) { return driving.measure(s.after); });
        if (!done) return fail(done.error());
        ++s.rounds;
        is_settled =
            has_settled(before, s.after, s.collapse.accepted + s.split.accepted - changes, options.least_change);
    }
    const auto mended =
        driving.pass("mend", &mend<D>, options.mend, s.mend).and_then([&](Done) { return driving.measure(s.after); });
    if (!mended) return fail(mended.error());
    return BroughtToMetric<D>{std::move(driving).state(), s};
}

}  // namespace

template <int D>
Outcome<BroughtToMetric<D>> bring_to_metric(Remeshing<D> state, const RemeshingGoal<D>& goal,
                                            const ToMetricOptions& options, const AroundPass& around) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&] { return driven(std::move(state), goal, options, around); });
}

template Outcome<BroughtToMetric<2>> bring_to_metric<2>(Remeshing<2>, const RemeshingGoal<2>&, const ToMetricOptions&,
                                                        const AroundPass&);
template Outcome<BroughtToMetric<3>> bring_to_metric<3>(Remeshing<3>, const RemeshingGoal<3>&, const ToMetricOptions&,
                                                        const AroundPass&);

}  // namespace camber
