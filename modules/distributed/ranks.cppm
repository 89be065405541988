// Communication between ranks: exchange, agreement, errors as bytes, packing of rows.
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

/// What has gone out from a rank to others.
struct Traffic {
    std::size_t rounds = 0, messages = 0, bytes = 0;
};

/// The processes that hold a mesh together, each some of its blocks.
class Ranks {
  public:
    virtual ~Ranks() = default;

    [[nodiscard]] virtual std::size_t rank() const = 0;
    [[nodiscard]] virtual std::size_t size() const = 0;
    [[nodiscard]] virtual Traffic traffic() const = 0;

    /// Gives to each rank (its own too) and takes from each: out[r] is what r gave to this one. All ranks call it, in
    /// the same turn. Where one of them comes with an error all get it, that of the lowest rank.
    [[nodiscard]] Outcome<std::vector<Bytes>> exchange(Outcome<std::vector<Bytes>> to) {
        auto from = exchanged(std::move(to));
        all_know_ |= !from;
        return from;
    }
    /// Whether an exchange has ended with an error: so all ranks have it.
    [[nodiscard]] bool all_know() const { return all_know_; }

  protected:
    Ranks() = default;
    Ranks(const Ranks&) = default;
    Ranks(Ranks&&) = default;
    Ranks& operator=(const Ranks&) = default;
    Ranks& operator=(Ranks&&) = default;

  private:
    [[nodiscard]] virtual Outcome<std::vector<Bytes>> exchanged(Outcome<std::vector<Bytes>> to) = 0;

    bool all_know_ = false;
};

/// A process by itself.
[[nodiscard]] std::unique_ptr<Ranks> one_rank();

/// What all ranks do together, work() → Outcome: where one of them fails by itself all others get its error in the
/// exchange that they come to next, and all fail alike.
template <class Work>
[[nodiscard]] auto together(Ranks& ranks, const Work& work) -> decltype(work()) {
    auto made = work();
    if (!made && ranks.all_know()) return made;
    const auto agreed = ranks.exchange(made ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size()))
                                            : Outcome<std::vector<Bytes>>(fail(made.error())));
    if (!agreed) return fail(agreed.error());
    return made;
}

/// Plain values as bytes, and back.
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

/// The values of all ranks on all of them, one rank's after the other's. Errors: of any rank.
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

/// What every rank has made by itself, if all have: none goes on and waits for one that has failed. All ranks call it.
/// Errors: of the lowest rank that has one.
template <class T>
[[nodiscard]] Outcome<T> agreed(Ranks& ranks, Outcome<T> made) {
    if (ranks.size() == 1) return made;
    const auto heard =
        ranks.exchange(made ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size())) : fail(made.error()));
    if (!heard) return fail(heard.error());
    return made;
}

/// The first rank's value (a plain one, or a text) on all of them; what the others give is not looked at. Errors: of
/// any.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<T> told_by_first(Ranks& ranks, const Outcome<T>& own) {
    Outcome<std::vector<T>> given = std::vector<T>();
    if (!own) given = fail(own.error());
    if (own && ranks.rank() == 0) given->push_back(*own);
    auto all = gather_all(ranks, given);
    if (!all) return fail(std::move(all.error()));
    return all->front();
}
[[nodiscard]] inline Outcome<std::string> told_by_first(Ranks& ranks, const Outcome<std::string>& own) {
    Outcome<std::vector<char>> given = std::vector<char>();
    if (!own) given = fail(own.error());
    if (own && ranks.rank() == 0) given->assign(own->begin(), own->end());
    const auto all = gather_all(ranks, given);
    if (!all) return fail(all.error());
    return std::string(all->begin(), all->end());
}

/// An error for another process, and back.
[[nodiscard]] Bytes packed(const Error& error);
[[nodiscard]] Error unpacked_error(const Bytes& bytes);

}  // namespace camber

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
