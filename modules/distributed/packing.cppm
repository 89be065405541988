module;
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
module camber.distributed:packing;
import camber.core;
import :ranks;

namespace camber {

/// Rows of plain values one after the other, a count before each, and back.
class Packing {
  public:
    explicit Packing(Bytes& bytes) : bytes_(bytes) {}
    template <class T>
    void operator()(const Buffer<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        const std::uint64_t count = values.size();
        append(&count, sizeof count);
        append(values.data(), values.size() * sizeof(T));
    }

  private:
    void append(const void* from, std::size_t size) {
        const std::size_t before = bytes_.size();
        bytes_.resize(before + size);
        if (size > 0) std::memcpy(bytes_.data() + before, from, size);
    }
    Bytes& bytes_;
};
class Unpacking {
  public:
    explicit Unpacking(const Bytes& bytes) : left_(bytes) {}
    template <class T>
    void operator()(Buffer<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        std::uint64_t count = 0;
        take(&count, sizeof count);
        values.resize(count);
        take(values.data(), count * sizeof(T));
    }

  private:
    void take(void* to, std::size_t size) {
        if (size > 0) std::memcpy(to, left_.data(), size);
        left_ = left_.subspan(size);
    }
    std::span<const std::byte> left_;
};

/// What has rows of several kinds: T::each_kind(value, f) does f(rows) of each.
template <class T>
[[nodiscard]] Bytes packed_rows(const T& value) {
    std::size_t size = 0;
    T::each_kind(value,
                 [&]<class V>(const Buffer<V>& rows) { size += sizeof(std::uint64_t) + rows.size() * sizeof(V); });
    Bytes bytes;
    bytes.reserve(size);
    T::each_kind(value, Packing(bytes));
    return bytes;
}
template <class T>
[[nodiscard]] T unpacked_rows(const Bytes& bytes) {
    T value;
    T::each_kind(value, Unpacking(bytes));
    return value;
}

}  // namespace camber
