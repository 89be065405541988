module;
#include <cstddef>
#include <utility>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;

namespace camber {

template <int D>
Outcome<Remeshed<D>> mend(Remeshing<D> state, const RemeshingGoal<D>& goal, const MendOptions& options,
                          const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Remeshed<D> out{std::move(state), {}};
    for (int turn = 0; turn < options.turns; ++turn) {
        const std::size_t before = out.statistics.accepted;
        auto swapped = swap<D>(std::move(out.state), goal, {.wanted = options.wanted}, execution);
        if (!swapped) return fail(swapped.error());
        out.statistics += swapped->statistics;
        auto moved = smooth<D>(std::move(swapped->state), goal, {.wanted = options.wanted}, execution);
        if (!moved) return fail(moved.error());
        out.statistics += moved->statistics;
        out.state = std::move(moved->state);
        if (out.statistics.accepted == before) break;
    }
    return out;
}

template Outcome<Remeshed<2>> mend<2>(Remeshing<2>, const RemeshingGoal<2>&, const MendOptions&, const Execution&);
template Outcome<Remeshed<3>> mend<3>(Remeshing<3>, const RemeshingGoal<3>&, const MendOptions&, const Execution&);

}  // namespace camber
