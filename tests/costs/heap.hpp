// What a piece of work asks of the heap, counted: the executable's operator new and delete are those of heap.cpp, which
// Buffer and Column go through too. Count with one thread: then the counts are the same on any machine but for how the
// system's malloc rounds sizes.
#pragma once

#include <cstddef>
#include <utility>

namespace camber::testing {

/// The heap since the process began.
struct Heap {
    std::size_t allocations = 0;
    std::size_t bytes = 0;  ///< not yet given back
    std::size_t peak = 0;   ///< most of them at a time since `begin_peak`
};
[[nodiscard]] Heap heap();
/// From now on the peak is that of what follows.
void begin_peak();

/// What f() took: its allocations, and the bytes that it had at most beyond those that were there before.
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
