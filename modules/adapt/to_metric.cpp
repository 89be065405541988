module;
#include <algorithm>
#include <cstddef>
#include <functional>
#include <string_view>
#include <utility>
module camber.adapt;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

namespace {

/// One pass after another, as long as none fails.
template <int D>
class Driving {
  public:
    Driving(Adaptation<D> state, const AdaptationGoal<D>& goal, const Around& around)
        : state_(std::move(state)), goal_(goal), around_(around) {}

    template <class Options>
    using Verb = Outcome<Adapted<D>> (*)(Adaptation<D>, const AdaptationGoal<D>&, const Options&, const Execution&);

    template <class Options>
    [[nodiscard]] Outcome<Done> pass(std::string_view name, Verb<Options> verb, const Options& options,
                                     PassStatistics& statistics) {
        return run_step(around_, name, [&](const Execution& execution) -> Outcome<Done> {
            auto done = verb(std::move(state_), goal_, options, execution);
            if (!done) return fail(done.error());
            state_ = std::move(done->state);
            statistics += done->statistics;
            return Done{};
        });
    }
    [[nodiscard]] Outcome<Done> measure(UnitMeshStatistics& out) const {
        return run_step(around_, "lengths", [&](const Execution& execution) -> Outcome<Done> {
            auto measured = unit_mesh_statistics(state_, execution);
            if (!measured) return fail(measured.error());
            out = *measured;
            return Done{};
        });
    }
    [[nodiscard]] Adaptation<D> state() && { return std::move(state_); }

  private:
    Adaptation<D> state_;
    const AdaptationGoal<D>& goal_;
    const Around& around_;
};

bool has_converged(const UnitMeshStatistics& before, const UnitMeshStatistics& after, std::size_t changed_vertices,
                   double min_change) {
    const auto vertices = static_cast<double>(after.edges) / 7;  // of tetrahedra; of triangles fewer edges each
    return after.unit_share() - before.unit_share() < min_change &&
           static_cast<double>(changed_vertices) < min_change * vertices;
}

template <int D>
Outcome<BroughtToMetric<D>> driven(Adaptation<D> state, const AdaptationGoal<D>& goal, const ToMetricOptions& options,
                                   const Around& around) {
    Driving<D> driving(std::move(state), goal, around);
    ToMetricStatistics s;
    if (auto begin = driving.measure(s.before); !begin) return fail(begin.error());
    s.after = s.before;
    bool is_converged = false;
    CollapseOptions loose = options.collapse;
    loose.longest = std::max(loose.longest, options.loose_longest);
    SplitOptions loose_split = options.split;
    loose_split.longest = std::max(loose_split.longest, options.loose_split);
    loose_split.shortest = std::max(loose_split.shortest, options.loose_shortest);
    bool is_last = false;
    while (!is_last && s.rounds < options.rounds) {
        is_last = is_converged || s.rounds + 1 == options.rounds;
        const UnitMeshStatistics before = s.after;
        const std::size_t changes = s.collapse.accepted + s.split.accepted;
        const auto done =
            driving.pass("collapse", &collapse<D>, is_last ? options.collapse : loose, s.collapse)
                .and_then([&](Done) {
                    return driving.pass("split", &split<D>, is_last ? options.split : loose_split, s.split);
                })
                .and_then([&](Done) { return driving.pass("swap", &swap<D>, options.swap, s.swap); })
                .and_then([&](Done) { return driving.pass("smooth", &smooth<D>, options.smooth, s.smooth); })
                .and_then([&](Done) { return driving.measure(s.after); });
        if (!done) return fail(done.error());
        ++s.rounds;
        is_converged =
            has_converged(before, s.after, s.collapse.accepted + s.split.accepted - changes, options.min_change);
    }
    const auto mended =
        driving.pass("mend", &mend<D>, options.mend, s.mend).and_then([&](Done) { return driving.measure(s.after); });
    if (!mended) return fail(mended.error());
    return BroughtToMetric<D>{std::move(driving).state(), s};
}

}  // namespace

template <int D>
Outcome<BroughtToMetric<D>> bring_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                            const ToMetricOptions& options, const Around& around) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&] { return driven(std::move(state), goal, options, around); });
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template Outcome<BroughtToMetric<D>> bring_to_metric<D>(Adaptation<D>, const AdaptationGoal<D>&, \
                                                            const ToMetricOptions&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
