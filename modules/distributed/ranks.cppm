module;
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
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

}  // namespace camber
