#include "heap.hpp"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> allocations{0}, bytes{0}, peak{0};

void* counted(void* memory) {
    if (memory == nullptr) throw std::bad_alloc();
    ++allocations;
    const std::size_t now = bytes += malloc_usable_size(memory);
    for (std::size_t most = peak; most < now && !peak.compare_exchange_weak(most, now);) {
    }
    return memory;
}

void release(void* memory) noexcept {
    if (memory != nullptr) bytes -= malloc_usable_size(memory);
    std::free(memory);
}

}  // namespace

// All other forms of `operator new` and `operator delete` call these.
void* operator new(std::size_t size) { return counted(std::malloc(std::max<std::size_t>(size, 1))); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    const auto a = static_cast<std::size_t>(alignment);
    return counted(std::aligned_alloc(a, (size + a - 1) / a * a));
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace camber::testing {

Heap heap() { return {allocations, bytes, peak}; }
void begin_peak() { peak = bytes.load(); }

}  // namespace camber::testing
