module;
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.repair:rounds;
import camber.core;
import camber.validity;
import :state;

namespace camber {

/// Plans that share what work is left: so many of a round at once.
inline constexpr std::size_t plans_at_once = 32;

/// Plans one after the other in the order of their numbers, what does not overlap in parallel (`in_rounds` of
/// camber.core). `claim(item)`: the elements that its plan looks at; `plan(item, max_work)`: what is planned, for no
/// more work than that; `finished(item, planned)`. Items that are `needless` when their round comes are left out, and
/// so are all once the state's work is spent. Progress tells of the items that are done with.
template <int D, class Item, class Needless, class ClaimOf, class Plan, class Finished>
[[nodiscard]] Outcome<Done> plan_in_rounds(RepairState<D>& state, std::vector<Item> items, const Execution& execution,
                                           Needless&& needless, ClaimOf&& claim, Plan&& plan, Finished&& finished) {
    if (items.empty() || state.exhausted()) return Done{};
    const Execution quiet = without_progress(execution);
    std::ranges::sort(items);
    const auto claims = map_each(quiet, items.size(), [&](std::size_t i) { return claim(items[i]); }, 16);
    if (!claims) return fail(claims.error());
    std::vector<std::size_t> places(items.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    const auto round = [&](std::span<const std::size_t> now) -> Outcome<bool> {
        for (; !now.empty() && !state.exhausted(); now = now.subspan(std::min(plans_at_once, now.size()))) {
            const std::size_t n = std::min(plans_at_once, now.size());
            const double share = state.work_left / static_cast<double>(n);
            const auto plans = map_each(quiet, n, [&](std::size_t i) { return plan(items[now[i]], share); }, 1);
            if (!plans) return fail(plans.error());
            for (std::size_t i = 0; i < n; ++i) {
                const Planned<D>& planned = (*plans)[i];
                if (planned.plan) state.moved.apply(*planned.plan);
                state.work_left -= planned.work;
                state.work += planned.work;
                finished(items[now[i]], planned);
            }
        }
        return !state.exhausted();
    };
    return in_rounds(
        state.schedule, std::move(places), execution, [&](std::size_t i) { return needless(items[i]); },
        [&](std::size_t i) { return Claim(std::span((*claims)[i])); }, round);
}

}  // namespace camber
