module;
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
/// Execution of work: threads, progress, parallel loops, schedules.
export module camber.core:execution;
import :columns;
import :outcome;

export namespace camber {

/// How a stage may run: the one explicit way by which threads, the request to stop, and progress enter.
/// Only `each` and `tell` read it. Results do not depend on it.
struct Execution {
    /// Threads to use; 0 means all that the machine has.
    int threads = 0;
    /// Polled between chunks: a stage that sees it returns ErrorKind::stopped.
    std::stop_token stop = {};
    /// Called from one thread at a time with what is done and what there is in all: items of a loop, or shares of a
    /// stage of several (`part_of`).
    std::function<void(std::size_t done, std::size_t total)> progress = {};
};

/// The same without telling progress: for loops before the one that counts.
[[nodiscard]] inline Execution without_progress(Execution execution) {
    execution.progress = {};
    return execution;
}

/// For loops that `each` does not know.
inline void report_progress(const Execution& execution, std::size_t done, std::size_t total) {
    if (execution.progress) execution.progress(done, total);
}

/// In so many parts what is made of several loops is told.
inline constexpr std::size_t parts_told = 1'000'000'000;

/// The same for one of the several loops of what `whole` tells of: that which takes the time between these shares of
/// it. What the loop tells of itself is told as so much of the whole; parts may be made of parts.
[[nodiscard]] inline Execution part_of(Execution whole, double from, double to) {
    if (whole.progress)
        whole.progress = [tell_whole = std::move(whole.progress), from, to](std::size_t done, std::size_t total) {
            const double share = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0;
            const double parts = std::lerp(from, to, share) * static_cast<double>(parts_told);
            tell_whole(static_cast<std::size_t>(std::llround(parts)), parts_told);
        };
    return whole;
}

/// A wrapper around each step of work that has several, with which a caller keeps clocks and shows progress:
/// `around(name, body)` must call body once, with the Execution to use.
using Around =
    std::function<Outcome<Done>(std::string_view step, const std::function<Outcome<Done>(const Execution&)>& body)>;

/// Steps with that execution, and nothing around them.
[[nodiscard]] inline Around plainly(const Execution& execution) {
    return [&execution](std::string_view, const auto& body) { return body(execution); };
}

/// f(execution) → Outcome as the step of that name; at its end the whole is told.
template <class F>
std::invoke_result_t<F, const Execution&> run_step(const Around& around, std::string_view name, F&& f) {
    std::optional<std::invoke_result_t<F, const Execution&>> made;
    const auto done = around(name, [&](const Execution& execution) -> Outcome<Done> {
        made = guarded([&] { return f(execution); });
        if (!*made) return fail(made->error());
        report_progress(execution, 1, 1);
        return Done{};
    });
    if (!done) return fail(done.error());
    return std::move(*made);
}

}  // namespace camber

namespace camber {
/// Runs body(context, begin, end) over [0, n) in chunks of `grain`, in parallel. Errors: stopped; memory, in any
/// thread.
Outcome<Done> run_chunks(const Execution& execution, std::size_t n, std::size_t grain, void* context,
                         void (*body)(void*, std::size_t, std::size_t));
}  // namespace camber

export namespace camber {

/// Items a chunk holds when the caller does not say: results never depend on it but for rounding in
/// reductions, so it is fixed.
inline constexpr std::size_t default_grain = 256;

/// The error of a stage that heard the request to stop.
[[nodiscard]] inline auto stopped() { return fail(ErrorKind::stopped, "stopped on request"); }

/// The loops below fail when stopped, and with ErrorKind::memory when f, in whichever thread, or the loop itself finds
/// no memory.

/// f(begin, end) for each chunk of [0, n), in parallel; chunks are the same for any number of threads.
template <class F>
[[nodiscard]] Outcome<Done> each_chunk(const Execution& execution, std::size_t n, F&& f,
                                       std::size_t grain = default_grain) {
    using Body = std::remove_reference_t<F>;
    return run_chunks(
        execution, n, grain, const_cast<void*>(static_cast<const void*>(&f)),
        [](void* context, std::size_t begin, std::size_t end) { (*static_cast<Body*>(context))(begin, end); });
}

/// f(i) for each i in [0, n), in parallel.
template <class F>
[[nodiscard]] Outcome<Done> each(const Execution& execution, std::size_t n, F&& f, std::size_t grain = default_grain) {
    return each_chunk(
        execution, n,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) f(i);
        },
        grain);
}

/// The buffer of f(i), i in [0, n), computed in parallel.
template <class F>
[[nodiscard]] auto map_each(const Execution& execution, std::size_t n, F&& f, std::size_t grain = default_grain)
    -> Outcome<Buffer<std::decay_t<decltype(f(std::size_t{}))>>> {
    static_assert(!std::is_same_v<std::decay_t<decltype(f(std::size_t{}))>, bool>,
                  "bits cannot be written in parallel");
    using Items = Buffer<std::decay_t<decltype(f(std::size_t{}))>>;
    return guarded([&]() -> Outcome<Items> {
        Items out(n);
        return each(
                   execution, n, [&](std::size_t i) { out[i] = f(i); }, grain)
            .map([&](Done) { return std::move(out); });
    });
}

/// Folds [0, n): each chunk starts from `init` and calls accumulate(value, i); the chunks' values are joined
/// in order by join(left, right). The same bytes for any number of threads.
template <class T, class Accumulate, class Join>
[[nodiscard]] Outcome<T> reduce_each(const Execution& execution, std::size_t n, T init, Accumulate&& accumulate,
                                     Join&& join, std::size_t grain = 4096) {
    static_assert(!std::is_same_v<T, bool>, "bits cannot be written in parallel");
    return guarded([&]() -> Outcome<T> {
        std::vector<T> partial((n + grain - 1) / grain, init);
        auto done = each_chunk(
            execution, n,
            [&](std::size_t begin, std::size_t end) {
                T value = init;
                for (std::size_t i = begin; i < end; ++i) accumulate(value, i);
                partial[begin / grain] = std::move(value);
            },
            grain);
        if (!done) return fail(std::move(done.error()));
        T total = std::move(init);
        for (T& value : partial) total = join(std::move(total), std::move(value));
        return total;
    });
}

// Work on parts of a mesh that overlap, as if it were done piece by piece in a given order, but in parallel: what does
// not overlap anything before it is done at once. So the result depends on the order alone.

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
/// Luby). No two ids have the same rank.
template <class Tag>
[[nodiscard]] constexpr std::uint64_t spread_rank(Id<Tag> id) {
    return mixed_bits((id.index() + 1) * 0x9e3779b97f4a7c15ULL);
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
