module;
#include <cmath>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <utility>
export module camber.core:execution;

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

}  // namespace camber
