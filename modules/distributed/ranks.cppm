// Communication between ranks: exchange, agreement, serialised errors and rows.
module;
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.distributed:ranks;
import camber.core;

export namespace camber {

using Bytes = Buffer<std::byte>;

struct Traffic {
    std::size_t rounds = 0, messages = 0, bytes = 0;
};

/// Processes that share a mesh. Functions that take `Ranks&`, except constructors, are collective: all ranks call them
/// in the same order, and errors can come from any rank.
class Ranks {
  public:
    virtual ~Ranks() = default;

    [[nodiscard]] virtual std::size_t rank() const = 0;
    [[nodiscard]] virtual std::size_t size() const = 0;
    [[nodiscard]] virtual Traffic traffic() const = 0;

    /// Sends bytes to each rank, including this one; out[r] comes from rank r. If some ranks pass an error, all ranks
    /// get the error of the lowest such rank.
    [[nodiscard]] Outcome<std::vector<Bytes>> exchange(Outcome<std::vector<Bytes>> to) {
        auto from = exchanged(std::move(to));
        has_common_error_ |= !from;
        return from;
    }
    /// True after an error in an exchange. All ranks then have the same error.
    [[nodiscard]] bool has_common_error() const { return has_common_error_; }

  protected:
    Ranks() = default;
    Ranks(const Ranks&) = default;
    Ranks(Ranks&&) = default;
    Ranks& operator=(const Ranks&) = default;
    Ranks& operator=(Ranks&&) = default;

  private:
    [[nodiscard]] virtual Outcome<std::vector<Bytes>> exchanged(Outcome<std::vector<Bytes>> to) = 0;

    bool has_common_error_ = false;
};

[[nodiscard]] std::unique_ptr<Ranks> one_rank();

/// Runs work() → Outcome on all ranks. If it fails on one rank, the next exchange of all other ranks returns its error,
/// so that all ranks fail.
template <class Work>
[[nodiscard]] auto together(Ranks& ranks, const Work& work) -> decltype(work()) {
    auto result = work();
    if (!result && ranks.has_common_error()) return result;
    const auto agreed = ranks.exchange(result ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size()))
                                              : Outcome<std::vector<Bytes>>(fail(result.error())));
    if (!agreed) return fail(agreed.error());
    return result;
}

template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Bytes bytes_of(std::span<const T> values) {
    Bytes bytes(values.size_bytes());
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}
template <class T, class Allocator>
    requires std::is_trivially_copyable_v<T>
void append_values(const Bytes& bytes, std::vector<T, Allocator>& values) {
    const std::size_t before = values.size();
    values.resize(before + bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(values.data() + before, bytes.data(), bytes.size());
}

template <class T>
[[nodiscard]] Outcome<std::vector<T>> gather_all(Ranks& ranks, const Outcome<std::vector<T>>& own) {
    std::vector<Bytes> to;
    if (own)
        for (std::size_t r = 0; r < ranks.size(); ++r) to.push_back(bytes_of<T>(*own));
    auto from = ranks.exchange(own ? Outcome<std::vector<Bytes>>(std::move(to)) : fail(own.error()));
    if (!from) return fail(from.error());
    std::vector<T> all;
    for (const Bytes& bytes : *from) append_values(bytes, all);
    return all;
}

/// Returns the local result, or the error of the lowest rank that failed, so that no rank waits for a failed one.
template <class T>
[[nodiscard]] Outcome<T> agreed(Ranks& ranks, Outcome<T> result) {
    if (ranks.size() == 1) return result;
    const auto replies =
        ranks.exchange(result ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size())) : fail(result.error()));
    if (!replies) return fail(replies.error());
    return result;
}

/// Returns the value of rank 0 (plain, or a text) on all ranks.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<T> broadcast_from_first(Ranks& ranks, const Outcome<T>& own) {
    Outcome<std::vector<T>> contribution = std::vector<T>();
    if (!own) contribution = fail(own.error());
    if (own && ranks.rank() == 0) contribution->push_back(*own);
    auto all = gather_all(ranks, contribution);
    if (!all) return fail(std::move(all.error()));
    return all->front();
}
[[nodiscard]] inline Outcome<std::string> broadcast_from_first(Ranks& ranks, const Outcome<std::string>& own) {
    Outcome<std::vector<char>> contribution = std::vector<char>();
    if (!own) contribution = fail(own.error());
    if (own && ranks.rank() == 0) contribution->assign(own->begin(), own->end());
    const auto all = gather_all(ranks, contribution);
    if (!all) return fail(all.error());
    return std::string(all->begin(), all->end());
}

[[nodiscard]] Bytes packed(const Error& error);
[[nodiscard]] Error unpacked_error(const Bytes& bytes);

}  // namespace camber

namespace camber {

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

/// Serialises a value; T::each_kind(value, f) must call f(rows) for each kind of rows.
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
