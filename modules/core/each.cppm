module;
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.core:each;
import :column;
import :execution;
import :guarded;
import :outcome;

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

}  // namespace camber
