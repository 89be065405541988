module;
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
/// Ids, shared arrays, arrays in files, maps between ids, hash tables.
export module camber.core:columns;

export namespace camber {

/// A strongly typed index into a column, from 0. The default is invalid.
template <class Tag>
struct Id {
    std::uint32_t value = 0xffffffffU;

    constexpr Id() = default;
    explicit constexpr Id(std::size_t i) : value(static_cast<std::uint32_t>(i)) {}
    [[nodiscard]] constexpr std::size_t index() const { return value; }
    [[nodiscard]] constexpr bool valid() const { return value != 0xffffffffU; }
    friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

struct VertexTag;
struct EdgeTag;
struct FacetTag;
struct FaceTag;
struct ElementTag;

using VertexId = Id<VertexTag>;
using EdgeId = Id<EdgeTag>;
using FacetId = Id<FacetTag>;      ///< boundary or interface facet: triangle in 3D, edge in 2D
using FaceId = Id<FaceTag>;        ///< unique face in 3D, numbered among the faces of its shape
using ElementId = Id<ElementTag>;  ///< tetrahedron in 3D, triangle in 2D

/// Number of the material, surface or curve to which a mesh entity belongs.
using Reference = std::int32_t;

inline constexpr std::size_t max_entities = 0xfffffffeU;

}  // namespace camber

namespace camber {
/// Allocates memory that is aligned for any type. Large arrays are on large pages, if available, for faster first
/// access. Throws std::bad_alloc.
void* allocate_array(std::size_t bytes);
void release_array(void* array, std::size_t bytes);
}  // namespace camber

export namespace camber {

/// Allocator that leaves elements of trivial types uninitialised, so that a parallel loop can be the first to write to
/// each page.
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

/// Mutable array from which a column is made. Elements of trivial types are uninitialised.
template <class T>
using Buffer = std::vector<T, Uninitialised<T>>;

}  // namespace camber

namespace camber {

/// Shared ownership of a value. Copies and the destructor are not inline, because a copy of a mesh contains dozens of
/// them.
class SharedOwner {
  public:
    class Value {
      public:
        Value() = default;
        Value(const Value&) = delete;
        Value(Value&&) = delete;
        Value& operator=(const Value&) = delete;
        Value& operator=(Value&&) = delete;
        virtual ~Value() = default;

      private:
        friend SharedOwner;
        std::atomic<std::size_t> owners_ = 1;
    };

    SharedOwner() = default;
    inline explicit SharedOwner(Value* value) : value_(value) {}
    SharedOwner(const SharedOwner& other) noexcept;
    SharedOwner(SharedOwner&& other) noexcept;
    SharedOwner& operator=(const SharedOwner& other) noexcept;
    SharedOwner& operator=(SharedOwner&& other) noexcept;
    ~SharedOwner();

    [[nodiscard]] inline Value* value() const { return value_; }
    /// True if this is the only owner. In that case, all reads through former owners have ended.
    [[nodiscard]] bool is_only() const;

  private:
    Value* value_ = nullptr;
};

}  // namespace camber

export namespace camber {

/// Immutable shared array. A copy of a column shares the array and only increments a reference count.
template <class T>
class Column {
  public:
    using value_type = T;

    Column() = default;
    Column(Buffer<T> buffer) : owner_(new Array) {  // NOLINT(*-explicit-*)
        array()->own = std::move(buffer);
        array()->items = array()->own;
    }
    /// Makes a column of an external array, which no thread may change until `owner` is destroyed.
    Column(std::span<const T> items, std::shared_ptr<const void> owner) : owner_(new Array) {
        array()->items = items;
        array()->owner = std::move(owner);
    }

    [[nodiscard]] std::size_t size() const { return array() ? array()->items.size() : 0; }
    [[nodiscard]] bool empty() const { return size() == 0; }
    [[nodiscard]] const T* data() const { return array() ? array()->items.data() : nullptr; }
    [[nodiscard]] const T* begin() const { return data(); }
    [[nodiscard]] const T* end() const { return data() + size(); }
    [[nodiscard]] std::span<const T> view() const { return {data(), size()}; }
    [[nodiscard]] const T& operator[](std::size_t i) const { return array()->items[i]; }
    template <class Tag>
    [[nodiscard]] const T& operator[](Id<Tag> id) const {
        return array()->items[id.index()];
    }

    /// Moves the buffer out of a column that is its only owner. In other cases, copies it.
    [[nodiscard]] friend Buffer<T> take(Column column) {
        if (!column.array()) return {};
        if (column.owner_.is_only() && !column.array()->owner) return std::move(column.array()->own);
        return Buffer<T>(column.begin(), column.end());
    }

    friend bool operator==(const Column& a, const Column& b) {
        if (a.array() == b.array()) return true;
        if (a.size() != b.size()) return false;
        for (std::size_t i = 0; i < a.size(); ++i)
            if (!(a[i] == b[i])) return false;
        return true;
    }

  private:
    struct Array : SharedOwner::Value {
        std::span<const T> items;
        std::shared_ptr<const void> owner;
        Buffer<T> own;
    };
    [[nodiscard]] Array* array() const { return static_cast<Array*>(owner_.value()); }

    SharedOwner owner_;
};

/// Stores large arrays from now on in anonymous temporary files of `folder`, so that the system can page them out. With
/// an empty folder, new arrays are in memory again. A program calls it once, at its start. Returns 0, or the system's
/// error number if files cannot be created.
[[nodiscard]] int store_arrays_in_files(const std::string& folder);

/// Copies bytes into an array, or a part of one, that was not accessed before. An array in a file is filled by file
/// output, which takes a tenth of the time of page accesses.
void fill_bytes(void* array, const void* from, std::size_t bytes);
template <class T>
    requires std::is_trivially_copyable_v<T>
void fill_array(std::span<T> array, std::span<const std::type_identity_t<T>> from) {
    fill_bytes(array.data(), from.data(), from.size_bytes());
}

/// Lets the system reclaim the memory of arrays in files; their content is preserved.
void release_array_memory();

/// Thrown if an array's file cannot be created or reserved, as on a full disk.
class NoFileForArray : public std::bad_alloc {
  public:
    NoFileForArray(std::string folder, int error) : folder_(std::move(folder)), error_(error) {}
    [[nodiscard]] const std::string& folder() const { return folder_; }
    [[nodiscard]] int error() const { return error_; }

  private:
    std::string folder_;
    int error_;
};

[[nodiscard]] std::size_t bytes_in_files();

}  // namespace camber

namespace camber {

/// Allocates an array in a file. Returns null for small arrays, and if arrays are not stored in files. Throws
/// NoFileForArray.
[[nodiscard]] void* allocate_in_file(std::size_t bytes);
/// Releases an array that is in a file. Returns false for other arrays.
[[nodiscard]] bool release_in_file(void* array);

}  // namespace camber

export namespace camber {

/// Map from ids before a mesh change to ids after it. The identity takes no memory.
template <class EntityId>
class IdMap {
  public:
    IdMap() = default;
    [[nodiscard]] static IdMap identity(std::size_t count) {
        IdMap map;
        map.count_ = count;
        return map;
    }
    /// `after[old]` is invalid for a removed entity.
    explicit IdMap(Column<EntityId> after) : after_(std::move(after)), count_(after_.size()), identity_(false) {}

    [[nodiscard]] EntityId operator[](EntityId old) const { return identity_ ? old : after_[old]; }
    [[nodiscard]] std::size_t size() const { return count_; }

  private:
    Column<EntityId> after_;
    std::size_t count_ = 0;
    bool identity_ = true;
};

/// Id maps of a commit, for the transfer of fields and metrics.
struct MeshMaps {
    IdMap<VertexId> vertices;
    IdMap<EdgeId> edges;
    IdMap<ElementId> elements;
    IdMap<FacetId> facets;
};

// The following tables store values for few rows of a column. Their cost is proportional to the number of these rows,
// not to the size of the column.

/// Fibonacci hashing (Knuth).
template <class Tag>
[[nodiscard]] constexpr std::uint64_t hash_of(Id<Tag> id) {
    return static_cast<std::uint64_t>(id.value) * 0x9e3779b97f4a7c15ULL >> 32U;
}

/// Hash table with open addressing for few ids. Copies are deep; writes are not thread-safe.
template <class Key, class T>
class SparseMap {
  public:
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }

    /// Pointer to the value, or null if absent; valid until the next `at`.
    [[nodiscard]] const T* find(Key key) const {
        if (size_ == 0) return nullptr;
        const std::size_t slot = slot_of(key);
        return slots_[slot].first == key ? &slots_[slot].second : nullptr;
    }
    /// Inserts T{} if the key is absent. The reference is valid until the next `at`.
    [[nodiscard]] T& at(Key key) {
        if (2 * (size_ + 1) > slots_.size()) grow();
        auto& [there, value] = slots_[slot_of(key)];
        if (!there.valid()) {
            there = key;
            ++size_;
        }
        return value;
    }
    [[nodiscard]] std::vector<Key> keys() const {
        std::vector<Key> all;
        all.reserve(size_);
        for (const auto& [key, value] : slots_)
            if (key.valid()) all.push_back(key);
        std::sort(all.begin(), all.end());
        return all;
    }

  private:
    [[nodiscard]] std::size_t slot_of(Key key) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = hash_of(key) & mask;
        while (slots_[slot].first.valid() && slots_[slot].first != key) slot = (slot + 1) & mask;
        return slot;
    }
    void grow() {
        std::vector<std::pair<Key, T>> old(std::max<std::size_t>(16, 2 * slots_.size()));
        std::swap(old, slots_);
        for (auto& [key, value] : old)
            if (key.valid()) slots_[slot_of(key)] = {key, std::move(value)};
    }

    std::vector<std::pair<Key, T>> slots_;  ///< power of two, at most half full
    std::size_t size_ = 0;
};

template <class Key>
class SparseSet {
  public:
    [[nodiscard]] bool contains(Key key) const { return members_.find(key) != nullptr; }
    void insert(Key key) { members_.at(key) = 1; }

  private:
    SparseMap<Key, std::uint8_t> members_;
};

/// SparseMap with a `clear` in constant time.
template <class Key, class T>
class ScratchMap {
  public:
    /// `slots` must be a power of two.
    explicit ScratchMap(std::size_t slots = 64) : slots_(slots) {}

    [[nodiscard]] std::size_t size() const { return size_; }
    void clear() {
        size_ = 0;
        if (++stamp_ != 0) return;
        slots_.assign(slots_.size(), {});  // the stamp counter overflowed
        stamp_ = 1;
    }
    /// Pointer to the value, or null if absent; valid until the next insertion.
    [[nodiscard]] const T* find(Key key) const {
        const Slot& slot = slots_[slot_of(key)];
        return slot.stamp == stamp_ ? &slot.value : nullptr;
    }
    [[nodiscard]] bool contains(Key key) const { return find(key) != nullptr; }
    /// Inserts `value` if the key is absent. The returned reference is valid until the next insertion.
    T& insert(Key key, const T& value) {
        if (2 * (size_ + 1) > slots_.size()) grow();
        Slot& slot = slots_[slot_of(key)];
        if (slot.stamp != stamp_) {
            slot = {key, stamp_, value};
            ++size_;
        }
        return slot.value;
    }

  private:
    struct Slot {
        Key key{std::size_t{0}};
        std::uint32_t stamp = 0;  ///< the slot is free if the stamp differs from `stamp_`
        [[no_unique_address]] T value{};
    };
    [[nodiscard]] std::size_t slot_of(Key key) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t at = hash_of(key) & mask;
        while (slots_[at].stamp == stamp_ && slots_[at].key != key) at = (at + 1) & mask;
        return at;
    }
    void grow() {
        std::vector<Slot> old(2 * slots_.size());
        std::swap(old, slots_);
        for (const Slot& slot : old)
            if (slot.stamp == stamp_) slots_[slot_of(slot.key)] = slot;
    }

    std::vector<Slot> slots_;
    std::size_t size_ = 0;
    std::uint32_t stamp_ = 1;
};

template <class Key>
class ScratchSet {
  public:
    explicit ScratchSet(std::size_t slots = 64) : members_(slots) {}

    void clear() { members_.clear(); }
    bool insert(Key key) {
        const std::size_t before = members_.size();
        members_.insert(key, {});
        return members_.size() != before;
    }

  private:
    struct Empty {};
    ScratchMap<Key, Empty> members_;
};

/// Finaliser of SplitMix64: a permutation; each output bit depends on all input bits.
[[nodiscard]] constexpr std::uint64_t mixed_bits(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
}

template <std::size_t N>
[[nodiscard]] constexpr std::uint64_t hash_of(const std::array<std::uint64_t, N>& words) {
    std::uint64_t z = 0;
    for (const std::uint64_t word : words) z = mixed_bits((z ^ word) + 0x9e3779b97f4a7c15ULL);
    return z;
}

/// Hash table of rows, with open addressing. The caller stores and compares the keys.
class RowTable {
  public:
    static constexpr std::uint32_t none = 0xffffffffU;

    explicit RowTable(std::size_t rows) : slots_(std::bit_ceil(2 * rows + 2), none) {}

    /// Returns the row with this hash for which `is_same(row)` is true, or `none`. Thread-safe.
    template <class IsSame>
    [[nodiscard]] std::uint32_t find(std::uint64_t hash, const IsSame& is_same) const {
        return slots_[slot_of(hash, is_same)];
    }
    /// Like `find`, but inserts `row` if no row is found.
    template <class IsSame>
    std::uint32_t insert(std::uint64_t hash, std::uint32_t row, const IsSame& is_same) {
        std::uint32_t& slot = slots_[slot_of(hash, is_same)];
        if (slot == none) slot = row;
        return slot;
    }

  private:
    [[nodiscard]] std::size_t slot_of(std::uint64_t hash, const auto& is_same) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t at = hash & mask;
        while (slots_[at] != none && !is_same(slots_[at])) at = (at + 1) & mask;
        return at;
    }

    Buffer<std::uint32_t> slots_;
};

/// A column with few replaced values.
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
    /// Rows whose values were set, in ascending order. A set value may equal that of the base column.
    [[nodiscard]] std::vector<Key> set_rows() const { return others_.keys(); }

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

/// Thread-safe cache of a pure function; copies share it.
template <class Key, class T>
class Memo {
  public:
    explicit Memo(std::function<T(Key)> make) : make_(std::move(make)), shards_(std::make_shared<Shards>()) {}

    [[nodiscard]] T operator[](Key key) const {
        Shard& shard = (*shards_)[key.index() % shards];
        {
            const std::scoped_lock lock(shard.mutex);
            if (const T* known = shard.values.find(key)) return *known;
        }
        // The value is computed without the lock: two threads may both compute it, with the same result.
        T value = make_(key);
        const std::scoped_lock lock(shard.mutex);
        shard.values.at(key) = value;
        return value;
    }

  private:
    static constexpr std::size_t shards = 64;
    struct Shard {
        std::mutex mutex;
        SparseMap<Key, T> values;
    };
    using Shards = std::array<Shard, shards>;

    std::function<T(Key)> make_;
    std::shared_ptr<Shards> shards_;
};

}  // namespace camber
