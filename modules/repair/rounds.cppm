module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
export module camber.repair:rounds;
import camber.core;
import camber.validity;
import :state;

namespace camber {

[[nodiscard]] inline Execution without_progress(const Execution& execution) {
    return {execution.threads, execution.stop, {}};
}

/// The positions of the first claims that have no element in common: by their order alone, whatever the threads.
[[nodiscard]] std::vector<std::size_t> independent(const Buffer<std::vector<ElementId>>& claims);

/// Plans that share what work is left: so many of a round at once.
inline constexpr std::size_t plans_at_once = 32;

/// Plans one after the other in rounds of such as have no element in common: a round is planned in parallel against the
/// state as it is, then applied; what overlaps waits for the next. `claim(item)`: the elements that its plan looks at;
/// `plan(item, most_work)`: what is planned, for no more work than that; `finished(item, planned)`. Items that are
/// `needless` when their round comes are left out, and so are all once the state's work is spent. Progress tells of the
/// items that are done with.
template <int D, class Item, class Needless, class Claim, class Plan, class Finished>
[[nodiscard]] Outcome<Done> in_rounds(RepairState<D>& state, std::vector<Item> items, const Execution& execution,
                                      Needless&& needless, Claim&& claim, Plan&& plan, Finished&& finished) {
    const Execution quiet = without_progress(execution);
    const std::size_t all = items.size();
    while (true) {
        std::erase_if(items, needless);
        if (execution.progress && all > 0) execution.progress(all - items.size(), all);
        if (items.empty() || state.exhausted()) return Done{};
        const auto claims = map_each(quiet, items.size(), [&](std::size_t i) { return claim(items[i]); }, 16);
        if (!claims) return fail(claims.error());
        const auto chosen = independent(*claims);
        for (std::size_t first = 0; first < chosen.size() && !state.exhausted(); first += plans_at_once) {
            const std::size_t n = std::min(plans_at_once, chosen.size() - first);
            const double share = state.work_left / static_cast<double>(n);
            const auto plans =
                map_each(quiet, n, [&](std::size_t i) { return plan(items[chosen[first + i]], share); }, 1);
            if (!plans) return fail(plans.error());
            for (std::size_t i = 0; i < n; ++i) {
                const Planned<D>& planned = (*plans)[i];
                if (planned.plan) state.moved.apply(*planned.plan);
                state.work_left -= planned.work;
                state.work += planned.work;
                finished(items[chosen[first + i]], planned);
            }
        }
        std::vector<Item> waiting;
        waiting.reserve(items.size() - chosen.size());
        for (std::size_t i = 0, next = 0; i < items.size(); ++i) {
            if (next < chosen.size() && chosen[next] == i)
                ++next;
            else
                waiting.push_back(items[i]);
        }
        items = std::move(waiting);
    }
}

}  // namespace camber
