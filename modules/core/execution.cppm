module;
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string_view>
export module camber.core:execution;

export namespace camber {

/// How a stage may run: the one explicit way by which threads, the wish to stop, and progress enter.
/// Only `each` reads it. Results do not depend on it.
struct Execution {
    /// Threads to use; 0 means all that the machine has.
    int threads = 0;
    /// Polled between chunks: a stage that sees the wish returns ErrorKind::stopped.
    std::stop_token stop = {};
    /// Called from one thread at a time with the items done and the items in all of the loop under way.
    std::function<void(std::size_t done, std::size_t total)> progress = {};
};

/// The same without telling progress: for loops before the one that counts.
[[nodiscard]] inline Execution without_progress(Execution execution) {
    execution.progress = {};
    return execution;
}

}  // namespace camber
