module;
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>
module camber.operation:task_queue;
import camber.core;
import :rounds;

namespace camber {

/// Tasks, the least first. Those that are there from the start are sorted once, which costs less than to keep so many
/// in a heap; the few that come later are in one.
class TaskQueue {
  public:
    explicit TaskQueue(std::vector<Task> tasks) : sorted_(std::move(tasks)) { std::ranges::sort(sorted_, later); }

    [[nodiscard]] std::size_t size() const { return sorted_.size() + heap_.size(); }
    [[nodiscard]] bool empty() const { return size() == 0; }
    void put(const Task& task) {
        heap_.push_back(task);
        std::ranges::push_heap(heap_, later);
    }
    [[nodiscard]] Task take_first() {
        const bool from_heap = sorted_.empty() || (!heap_.empty() && heap_.front() < sorted_.back());
        if (from_heap) std::ranges::pop_heap(heap_, later);
        std::vector<Task>& from = from_heap ? heap_ : sorted_;
        const Task first = from.back();
        from.pop_back();
        return first;
    }

  private:
    static bool later(const Task& a, const Task& b) { return b < a; }

    std::vector<Task> sorted_;  ///< the first at the end
    std::vector<Task> heap_;
};

}  // namespace camber
