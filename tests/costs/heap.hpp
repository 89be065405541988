// Counts heap allocations. heap.cpp replaces operator new and delete of the executable; `Buffer` and `Column` use them
// too. With one thread the counts are the same on every machine, except for the rounding of sizes by malloc.
#pragma once

#include <cstddef>
#include <utility>

namespace camber::testing {

/// Heap statistics since the start of the process.
struct Heap {
    std::size_t allocations = 0;
    std::size_t bytes = 0;  ///< currently allocated
    std::size_t peak = 0;   ///< maximum of `bytes` since `begin_peak`
};
[[nodiscard]] Heap heap();
/// Restarts the measurement of the peak.
void begin_peak();

/// Allocations of a call f(), and its peak memory in bytes above the memory allocated before.
struct Cost {
    std::size_t allocations = 0, peak = 0;
};
template <class F>
Cost cost_of(F&& f) {
    begin_peak();
    const Heap before = heap();
    std::forward<F>(f)();
    const Heap after = heap();
    return {after.allocations - before.allocations, after.peak - before.bytes};
}

}  // namespace camber::testing
