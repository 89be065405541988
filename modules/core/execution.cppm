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

/// Number of threads, stop request and progress callback of a stage. The results of computations do not depend on these
/// settings.
struct Execution {
    /// 0: all hardware threads
    int threads = 0;
    /// Polled between chunks. A stop request leads to ErrorKind::stopped.
    std::stop_token stop = {};
    /// Called from one thread at a time. The arguments count items of a loop or, for several loops (`part_of`),
    /// fractions of the work.
    std::function<void(std::size_t done, std::size_t total)> progress = {};
};

[[nodiscard]] inline Execution without_progress(Execution execution) {
    execution.progress = {};
    return execution;
}

inline void report_progress(const Execution& execution, std::size_t done, std::size_t total) {
    if (execution.progress) execution.progress(done, total);
}

inline constexpr std::size_t progress_resolution = 1'000'000'000;

/// Returns the execution for one of several loops of `whole`. This loop reports progress between the fractions `from`
/// and `to` of the whole. Calls may be nested.
[[nodiscard]] inline Execution part_of(Execution whole, double from, double to) {
    if (whole.progress)
        whole.progress = [report_whole = std::move(whole.progress), from, to](std::size_t done, std::size_t total) {
            const double share = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0;
            const double parts = std::lerp(from, to, share) * static_cast<double>(progress_resolution);
            report_whole(static_cast<std::size_t>(std::llround(parts)), progress_resolution);
        };
    return whole;
}

/// Function called around each step, for timing and progress. `around(name, body)` must call body once, with an
/// Execution.
using StepWrapper =
    std::function<Outcome<Done>(std::string_view step, const std::function<Outcome<Done>(const Execution&)>& body)>;

[[nodiscard]] inline StepWrapper without_wrapper(const Execution& execution) {
    return [&execution](std::string_view, const auto& body) { return body(execution); };
}

/// Runs f(execution) → Outcome as the named step, and reports full progress.
template <class F>
std::invoke_result_t<F, const Execution&> run_step(const StepWrapper& around, std::string_view name, F&& f) {
    std::optional<std::invoke_result_t<F, const Execution&>> result;
    const auto done = around(name, [&](const Execution& execution) -> Outcome<Done> {
        result = guarded([&] { return f(execution); });
        if (!*result) return fail(result->error());
        report_progress(execution, 1, 1);
        return Done{};
    });
    if (!done) return fail(done.error());
    return std::move(*result);
}

}  // namespace camber

namespace camber {
Outcome<Done> run_chunks(const Execution& execution, std::size_t n, std::size_t grain, void* context,
                         void (*body)(void*, std::size_t, std::size_t));
}  // namespace camber

export namespace camber {

/// Default chunk size. It is fixed, because rounding in reductions depends on it.
inline constexpr std::size_t default_grain = 256;

[[nodiscard]] inline auto stopped() { return fail(ErrorKind::stopped, "stopped on request"); }

/// Errors of the following loops: stopped; memory (in any thread).

/// Calls f(begin, end) for chunks of [0, n) in parallel. Chunks do not depend on the number of threads.
template <class F>
[[nodiscard]] Outcome<Done> each_chunk(const Execution& execution, std::size_t n, F&& f,
                                       std::size_t grain = default_grain) {
    using Body = std::remove_reference_t<F>;
    return run_chunks(
        execution, n, grain, const_cast<void*>(static_cast<const void*>(&f)),
        [](void* context, std::size_t begin, std::size_t end) { (*static_cast<Body*>(context))(begin, end); });
}

template <class F>
[[nodiscard]] Outcome<Done> each(const Execution& execution, std::size_t n, F&& f, std::size_t grain = default_grain) {
    return each_chunk(
        execution, n,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) f(i);
        },
        grain);
}

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

/// Parallel reduction with the same bits for any number of threads. Each chunk starts from `init` and calls
/// accumulate(value, i) for its indices i. join(left, right) then combines the values of the chunks in order.
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

// Parallel execution of work items on overlapping parts of a mesh, equivalent to sequential execution in a given order.
// An item runs as soon as it overlaps no earlier unfinished item. The result depends only on the order.

/// Elements that a work item reads and writes. None: they are unknown in advance, so the item runs alone.
using Claim = std::optional<std::span<const ElementId>>;

/// Selects items that can run concurrently. An object has a row for each element, and serves many rounds (batches of
/// concurrent items).
class Schedule {
  public:
    explicit Schedule(std::size_t elements) : first_(elements, unclaimed) {}

    /// Returns, in ascending order, the items that share no element with an earlier item; not empty for n > 0.
    /// `claim(i)`: elements of item i. Errors: stopped, memory.
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
                std::atomic_ref(first_[e.index()]).store(unclaimed, std::memory_order_relaxed);
        });
        if (!done) return fail(done.error());
        std::vector<std::size_t> chosen;
        for (std::size_t i = 0; i < n; ++i)
            if ((*is_first)[i] != 0) chosen.push_back(i);
        return chosen;
    }

  private:
    static constexpr std::uint32_t unclaimed = 0xffffffffU;

    static void lower(std::uint32_t& place, std::uint32_t value) {
        std::atomic_ref there(place);
        std::uint32_t now = there.load(std::memory_order_relaxed);
        while (value < now && !there.compare_exchange_weak(now, value, std::memory_order_relaxed)) {
        }
    }

    std::vector<std::uint32_t> first_;
};

/// Returns a pseudo-random, unique rank of an id (after Luby). If items are processed in the order of ranks, most of
/// them precede all items that they overlap.
template <class Tag>
[[nodiscard]] constexpr std::uint64_t spread_rank(Id<Tag> id) {
    return mixed_bits((id.index() + 1) * 0x9e3779b97f4a7c15ULL);
}

/// Maximum number of items examined for a batch.
inline constexpr std::size_t round_window = 8192;

/// Processes items in rounds. `round(items)` processes a batch in order; false ends the loop. Items that are `needless`
/// when examined are skipped. `claim(item)` must not change while the item waits. Errors: those of `round`, stopped.
template <class Item, class Needless, class ClaimOf, class Round>
[[nodiscard]] Outcome<Done> run_in_rounds(Schedule& schedule, std::vector<Item> items, const Execution& execution,
                                          Needless&& needless, ClaimOf&& claim, Round&& round) {
    const Execution quiet{execution.threads, execution.stop, {}};
    const std::size_t all = items.size();
    std::vector<Item> front, now;
    for (std::size_t begin = 0; true;) {
        // Takes items from the start of the list until one must run alone.
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
            // Items that must wait are stored directly before the items not yet examined.
            std::size_t next = chosen->size();
            for (std::size_t i = front.size(); i-- > 0;) {
                if (next > 0 && (*chosen)[next - 1] == i)
                    --next;
                else
                    items[--begin] = std::move(front[i]);
            }
            for (const std::size_t i : *chosen) now.push_back(std::move(front[i]));
        }
        const Outcome<bool> continues = round(std::span<const Item>(now));
        if (!continues) return fail(continues.error());
        if (!*continues) return Done{};
    }
}

}  // namespace camber
