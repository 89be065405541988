module;
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.transfer:key_table;
import camber.core;

namespace camber {

inline constexpr std::uint32_t none = 0xffffffffU;

/// Items by keys of N words: a hash table with open addressing, made once, then asked by many threads. Of items with
/// equal keys the first is found.
template <std::size_t N>
class KeyTable {
  public:
    using Key = std::array<std::uint64_t, N>;

    /// key(i) of the items i < n; it is asked again by `find`.
    template <class KeyOf>
    KeyTable(std::size_t n, const KeyOf& key) : mask_(std::bit_ceil(2 * n + 2) - 1), slots_(mask_ + 1, none) {
        for (std::size_t i = 0; i < n; ++i) {
            const Key wanted = key(i);
            std::size_t at = hash(wanted) & mask_;
            while (slots_[at] != none && key(slots_[at]) != wanted) at = (at + 1) & mask_;
            if (slots_[at] == none) slots_[at] = static_cast<std::uint32_t>(i);
        }
    }

    /// The first item of that key, or `none`.
    template <class KeyOf>
    [[nodiscard]] std::uint32_t find(const Key& wanted, const KeyOf& key) const {
        std::size_t at = hash(wanted) & mask_;
        while (slots_[at] != none && key(slots_[at]) != wanted) at = (at + 1) & mask_;
        return slots_[at];
    }

  private:
    /// The finaliser of a 64-bit mixer (SplitMix64), word after word.
    [[nodiscard]] static std::size_t hash(const Key& key) {
        std::uint64_t z = 0;
        for (const std::uint64_t word : key) {
            z = (z ^ word) + 0x9e3779b97f4a7c15ULL;
            z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
            z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
            z ^= z >> 31U;
        }
        return z;
    }

    std::size_t mask_;
    Buffer<std::uint32_t> slots_;
};

}  // namespace camber
