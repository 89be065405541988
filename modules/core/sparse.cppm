module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
export module camber.core:sparse;
import :column;
import :ids;

/// What is known of few rows of a column: its cost goes with these rows, not with the column.
export namespace camber {

/// Values of some ids: a hash table with open addressing. Copying copies what is in it. Not for writing from several
/// threads.
template <class Key, class T>
class SparseMap {
  public:
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }

    /// Null where nothing is known of it. Valid until the next `at`.
    [[nodiscard]] const T* find(Key key) const {
        if (size_ == 0) return nullptr;
        const std::size_t slot = slot_of(key);
        return slots_[slot].first == key ? &slots_[slot].second : nullptr;
    }
    /// The key's value; a T{} that is new where nothing was known. Valid until the next `at`.
    [[nodiscard]] T& at(Key key) {
        if (2 * (size_ + 1) > slots_.size()) grow();
        auto& [there, value] = slots_[slot_of(key)];
        if (!there.valid()) {
            there = key;
            ++size_;
        }
        return value;
    }
    /// All keys, rising.
    [[nodiscard]] std::vector<Key> keys() const {
        std::vector<Key> all;
        all.reserve(size_);
        for (const auto& [key, value] : slots_)
            if (key.valid()) all.push_back(key);
        std::sort(all.begin(), all.end());
        return all;
    }

  private:
    /// Where the key is, or the free place for it: numbers are spread by the golden ratio (Knuth).
    [[nodiscard]] std::size_t slot_of(Key key) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = (static_cast<std::uint64_t>(key.value) * 0x9e3779b97f4a7c15ULL >> 32U) & mask;
        while (slots_[slot].first.valid() && slots_[slot].first != key) slot = (slot + 1) & mask;
        return slot;
    }
    void grow() {
        std::vector<std::pair<Key, T>> old(std::max<std::size_t>(16, 2 * slots_.size()));
        std::swap(old, slots_);
        for (auto& [key, value] : old)
            if (key.valid()) slots_[slot_of(key)] = {key, std::move(value)};
    }

    std::vector<std::pair<Key, T>> slots_;  ///< a power of two, at most half of them taken
    std::size_t size_ = 0;
};

/// Some ids.
template <class Key>
class SparseSet {
  public:
    [[nodiscard]] bool contains(Key key) const { return members_.find(key) != nullptr; }
    void insert(Key key) { members_.at(key) = 1; }

  private:
    SparseMap<Key, std::uint8_t> members_;
};

/// A column some of whose rows are otherwise.
template <class Key, class T>
class Overlay {
  public:
    Overlay() = default;
    Overlay(Column<T> base) : base_(std::move(base)) {}  // NOLINT(*-explicit-*)

    [[nodiscard]] std::size_t size() const { return base_.size(); }
    [[nodiscard]] const Column<T>& base() const { return base_; }
    [[nodiscard]] const T& operator[](Key key) const {
        const T* other = others_.find(key);
        return other ? *other : base_[key];
    }
    void set(Key key, const T& value) { others_.at(key) = value; }
    /// The rows that were set, rising; some may have their value of before again.
    [[nodiscard]] std::vector<Key> set_rows() const { return others_.keys(); }

    /// All of it as a column; the base itself when nothing was set.
    [[nodiscard]] Column<T> column() const {
        if (others_.empty()) return base_;
        Buffer<T> rows(base_.begin(), base_.end());
        for (const Key key : others_.keys()) rows[key.index()] = *others_.find(key);
        return rows;
    }

  private:
    Column<T> base_;
    SparseMap<Key, T> others_;
};

}  // namespace camber
