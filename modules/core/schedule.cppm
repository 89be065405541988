module;
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.core:schedule;
import :column;
import :each;
import :execution;
import :ids;
import :outcome;

/// Work on parts of a mesh that overlap, as if it were done piece by piece in a given order, but in parallel: what does
/// not overlap anything before it is done at once. So the result depends on the order alone.
export namespace camber {

/// What a piece of work reads and writes: elements. None: it cannot tell before, and is done alone.
using Claim = std::optional<std::span<const ElementId>>;

/// Which pieces may be done at once. It has a row for each element of a mesh, and is made once for many rounds.
class Schedule {
  public:
    explicit Schedule(std::size_t elements) : first_(elements, nobody) {}

    /// The positions, rising, of those of n pieces that come before all others which claim one of their elements;
    /// never empty when n is not 0. `claim(i)`: the elements of the piece at position i. Errors: stopped, memory.
    template <class ElementsOf>
    [[nodiscard]] Outcome<std::vector<std::size_t>> disjoint(std::size_t n, ElementsOf&& claim,
                                                             const Execution& execution) {
        auto done = each(execution, n, [&](std::size_t i) {
            for (const ElementId e : claim(i)) lower(first_[e.index()], static_cast<std::uint32_t>(i));
        });
        if (!done) return fail(done.error());
        auto is_first = map_each(execution, n, [&](std::size_t i) {
            return static_cast<std::uint8_t>(
                std::ranges::all_of(claim(i), [&](ElementId e) { return first_[e.index()] == i; }));
        });
        if (!is_first) return fail(is_first.error());
        done = each(execution, n, [&](std::size_t i) {
            for (const ElementId e : claim(i))
                std::atomic_ref(first_[e.index()]).store(nobody, std::memory_order_relaxed);
        });
        if (!done) return fail(done.error());
        std::vector<std::size_t> chosen;
        for (std::size_t i = 0; i < n; ++i)
            if ((*is_first)[i] != 0) chosen.push_back(i);
        return chosen;
    }

  private:
    static constexpr std::uint32_t nobody = 0xffffffffU;

    static void lower(std::uint32_t& place, std::uint32_t value) {
        std::atomic_ref there(place);
        std::uint32_t now = there.load(std::memory_order_relaxed);
        while (value < now && !there.compare_exchange_weak(now, value, std::memory_order_relaxed)) {
        }
    }

    std::vector<std::uint32_t> first_;  ///< the first position that claims an element; nobody between two calls
};

/// An order in which neighbours in number are far apart, so that many pieces come before all that they overlap (after
/// Luby): the finaliser of a 64-bit mixer (SplitMix64). No two ids have the same rank.
template <class Tag>
[[nodiscard]] constexpr std::uint64_t spread_rank(Id<Tag> id) {
    std::uint64_t z = (id.index() + 1) * 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
}

/// So many items are looked at in a round: rounds cost this at most, however many items wait and however few are
/// chosen.
inline constexpr std::size_t round_window = 8192;

/// All items, in rounds of such as may be done at once: `round(items)` does those, in their order, and says whether to
/// go on. Items that are `needless` when their round comes are left out. `claim(item)`: see Claim; it must not change
/// while the item waits. Progress tells of the items that are done with. Errors: those of `round`, stopped.
template <class Item, class Needless, class ClaimOf, class Round>
[[nodiscard]] Outcome<Done> in_rounds(Schedule& schedule, std::vector<Item> items, const Execution& execution,
                                      Needless&& needless, ClaimOf&& claim, Round&& round) {
    const Execution quiet{execution.threads, execution.stop, {}};
    const std::size_t all = items.size();
    std::vector<Item> front, now;
    for (std::size_t begin = 0; true;) {
        // The first items, up to one that is done alone.
        front.clear();
        std::size_t end = begin;
        bool alone = false;
        for (; end < all && front.size() < round_window && !alone; ++end) {
            if (needless(items[end])) continue;
            alone = !claim(items[end]);
            if (alone && !front.empty()) break;
            front.push_back(std::move(items[end]));
        }
        if (execution.progress && all > 0) execution.progress(end - front.size(), all);
        if (front.empty()) return Done{};
        now.clear();
        begin = end;
        if (alone && front.size() == 1) {
            now.swap(front);
        } else {
            const auto chosen = schedule.disjoint(front.size(), [&](std::size_t i) { return *claim(front[i]); }, quiet);
            if (!chosen) return fail(chosen.error());
            // What waits goes back to just before what was not looked at.
            std::size_t next = chosen->size();
            for (std::size_t i = front.size(); i-- > 0;) {
                if (next > 0 && (*chosen)[next - 1] == i)
                    --next;
                else
                    items[--begin] = std::move(front[i]);
            }
            for (const std::size_t i : *chosen) now.push_back(std::move(front[i]));
        }
        const Outcome<bool> go_on = round(std::span<const Item>(now));
        if (!go_on) return fail(go_on.error());
        if (!*go_on) return Done{};
    }
}

}  // namespace camber
