module;
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <mutex>
module camber.core;

namespace camber {

namespace {

/// Ticks of one loop, passed on from one thread at a time, in rising order; the last one says that all is done.
class Ticker {
  public:
    Ticker(const Execution& execution, std::size_t total) : execution_(execution), total_(total) {}
    void add(std::size_t items) {
        done_.fetch_add(items);
        if (!execution_.progress) return;
        // A tick that finds another under way is dropped, unless it is the last.
        std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock && done_.load() == total_) lock.lock();
        if (!lock) return;
        // Read under the lock: a count taken before it could be older than one already told.
        const std::size_t done = done_.load();
        if (done == told_) return;
        told_ = done;
        execution_.progress(done, total_);
    }

  private:
    const Execution& execution_;
    std::size_t total_;
    std::size_t told_ = 0;
    std::atomic<std::size_t> done_{0};
    std::mutex mutex_;
};

}  // namespace

Outcome<Done> run_chunks(const Execution& execution, std::size_t n, std::size_t grain, void* context,
                         void (*body)(void*, std::size_t, std::size_t)) {
    return guarded([&]() -> Outcome<Done> {
        const std::size_t chunks = (n + grain - 1) / grain;
        Ticker ticker(execution, n);
        const auto run_chunk = [&](std::size_t chunk) {
            if (execution.stop.stop_requested()) return;
            const std::size_t begin = chunk * grain;
            const std::size_t end = std::min(n, begin + grain);
            body(context, begin, end);
            ticker.add(end - begin);
        };
        if (execution.threads == 1 || chunks < 2) {
            for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
        } else {
            // More threads than the machine has would not run, but make the library print a warning.
            const int threads = std::min(execution.threads, tbb::info::default_concurrency());
            tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
            arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_chunk); });
        }
        if (execution.stop.stop_requested()) return stopped();
        return Done{};
    });
}

}  // namespace camber
