module;
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <mutex>
module camber.core;

namespace camber {

namespace {

/// Ticks of one loop, passed on at most from one thread at a time.
class Ticker {
  public:
    Ticker(const Execution& execution, std::size_t total) : execution_(execution), total_(total) {}
    void add(std::size_t items) {
        const std::size_t done = done_.fetch_add(items) + items;
        if (!execution_.progress) return;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock) execution_.progress(done, total_);
    }

  private:
    const Execution& execution_;
    std::size_t total_;
    std::atomic<std::size_t> done_{0};
    std::mutex mutex_;
};

}  // namespace

bool run_chunks(const Execution& execution, std::size_t n, std::size_t grain, void* context,
                void (*body)(void*, std::size_t, std::size_t)) {
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
        tbb::task_arena arena(execution.threads > 0 ? execution.threads : tbb::task_arena::automatic);
        arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_chunk); });
    }
    return !execution.stop.stop_requested();
}

}  // namespace camber
