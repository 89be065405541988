module;
#include <atomic>
#include <cstddef>
#include <limits>
module camber.io:first_fault;
import camber.core;

namespace camber {

/// The first of the rows at fault, whatever thread finds it.
class FirstFault {
  public:
    void note(std::size_t row) {
        std::size_t seen = row_.load(std::memory_order_relaxed);
        while (row < seen && !row_.compare_exchange_weak(seen, row, std::memory_order_relaxed)) {
        }
    }
    [[nodiscard]] bool any() const { return row() != std::numeric_limits<std::size_t>::max(); }
    [[nodiscard]] std::size_t row() const { return row_.load(std::memory_order_relaxed); }

  private:
    std::atomic<std::size_t> row_{std::numeric_limits<std::size_t>::max()};
};

}  // namespace camber
