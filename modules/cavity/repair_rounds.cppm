module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
export module camber.cavity:repair_rounds;
import camber.core;
import :repair_state;

namespace camber {

/// The plan becomes the state's.
template <int D>
void apply(RepairState<D>& state, const RepairPlan<D>& plan);

/// The positions of the first claims that have no element in common: by their order alone, whatever the threads.
/// `claimed`: of all elements, 0 before and after.
[[nodiscard]] std::vector<std::size_t> independent(const Buffer<std::vector<ElementId>>& claims,
                                                   std::vector<std::uint8_t>& claimed);

/// Plans one after the other in rounds of such as have no element in common: a round is planned in parallel against the
/// state as it is, then applied; what overlaps waits for the next. `claim(item)`: the elements that its plan looks at;
/// `plan(item)`: an optional plan; `finished(item, was it planned)`. Items that are `needless` when their round comes
/// are left out.
template <int D, class Item, class Needless, class Claim, class Plan, class Finished>
[[nodiscard]] Outcome<Done> in_rounds(RepairState<D>& state, std::vector<Item> items, const Execution& execution,
                                      Needless&& needless, Claim&& claim, Plan&& plan, Finished&& finished) {
    std::vector<std::uint8_t> claimed(state.mesh.linear.elements.size(), 0);
    while (true) {
        std::erase_if(items, needless);
        if (items.empty()) return Done{};
        const auto claims = map_each(execution, items.size(), [&](std::size_t i) { return claim(items[i]); }, 16);
        if (!claims) return fail(claims.error());
        const auto chosen = independent(*claims, claimed);
        const auto plans = map_each(execution, chosen.size(), [&](std::size_t i) { return plan(items[chosen[i]]); }, 1);
        if (!plans) return fail(plans.error());
        std::vector<Item> waiting;
        waiting.reserve(items.size() - chosen.size());
        for (std::size_t i = 0, next = 0; i < items.size(); ++i) {
            if (next == chosen.size() || chosen[next] != i) {
                waiting.push_back(items[i]);
                continue;
            }
            const auto& planned = (*plans)[next++];
            if (planned) apply(state, *planned);
            finished(items[i], planned.has_value());
        }
        items = std::move(waiting);
    }
}

}  // namespace camber
