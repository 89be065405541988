module;
#include <atomic>
#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.core:column;
import :ids;

namespace camber {
/// Memory for an array, aligned for any type; a large one on large pages where the system has them, whose first touch
/// costs a fraction (writing a mesh of 10 million tetrahedra anew 9.4 -> 5.6 s). Throws std::bad_alloc.
void* allocate_array(std::size_t bytes);
void release_array(void* array, std::size_t bytes);
}  // namespace camber

export namespace camber {

/// Leaves new elements of trivial types uninitialised, so that a parallel loop touches each page first and once.
template <class T>
struct Uninitialised : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = Uninitialised<U>;
    };
    [[nodiscard]] T* allocate(std::size_t n) {
        static_assert(alignof(T) <= alignof(std::max_align_t));
        if (n > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(allocate_array(n * sizeof(T)));
    }
    void deallocate(T* array, std::size_t n) { release_array(array, n * sizeof(T)); }
    template <class U, class... Args>
    void construct(U* p, Args&&... args) {
        if constexpr (sizeof...(Args) == 0 && std::is_trivially_copyable_v<U>)
            ;
        else
            std::construct_at(p, std::forward<Args>(args)...);
    }
};

/// The mutable array that a column is made from; `Buffer<T>(n)` of plain values is uninitialised.
template <class T>
using Buffer = std::vector<T, Uninitialised<T>>;

/// An immutable shared array: copying costs a reference count. To change one, `take` its buffer (moved
/// out when nobody else holds it, copied once otherwise) and make a new column of it.
template <class T>
class Column {
  public:
    using value_type = T;

    Column() = default;
    Column(Buffer<T> buffer)  // NOLINT(*-explicit-*)
        : array_(std::make_shared<Array>(Array{{}, {}, std::move(buffer)})) {
        array_->items = array_->own;
    }
    /// Of an array of somebody else, who leaves it as it is until `owner` is destroyed, in whichever thread that is:
    /// nothing is copied.
    Column(std::span<const T> items, std::shared_ptr<const void> owner)
        : array_(std::make_shared<Array>(Array{items, std::move(owner), {}})) {}

    [[nodiscard]] std::size_t size() const { return array_ ? array_->items.size() : 0; }
    [[nodiscard]] bool empty() const { return size() == 0; }
    [[nodiscard]] const T* data() const { return array_ ? array_->items.data() : nullptr; }
    [[nodiscard]] const T* begin() const { return data(); }
    [[nodiscard]] const T* end() const { return data() + size(); }
    [[nodiscard]] std::span<const T> view() const { return {data(), size()}; }
    [[nodiscard]] const T& operator[](std::size_t i) const { return array_->items[i]; }
    template <class Tag>
    [[nodiscard]] const T& operator[](Id<Tag> id) const {
        return array_->items[id.index()];
    }

    /// The column's buffer to write on: moved out of a uniquely owned column, copied from a shared one or from an array
    /// of somebody else.
    [[nodiscard]] friend Buffer<T> take(Column column) {
        if (!column.array_) return {};
        if (column.array_.use_count() == 1 && !column.array_->owner) {
            // Whoever held it before has finished reading: the count alone is a relaxed load.
            std::atomic_thread_fence(std::memory_order_acquire);
            return std::move(column.array_->own);
        }
        return Buffer<T>(column.begin(), column.end());
    }

    friend bool operator==(const Column& a, const Column& b) {
        if (a.array_ == b.array_) return true;
        if (a.size() != b.size()) return false;
        for (std::size_t i = 0; i < a.size(); ++i)
            if (!(a[i] == b[i])) return false;
        return true;
    }

  private:
    struct Array {
        std::span<const T> items;
        std::shared_ptr<const void> owner;  ///< of those, where it is somebody else
        Buffer<T> own;
    };
    std::shared_ptr<Array> array_;
};

}  // namespace camber
