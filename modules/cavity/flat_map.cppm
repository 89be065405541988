module;
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.cavity:flat_map;
import camber.core;

/// Small tables that are filled and emptied over and over, without memory being asked for.
namespace camber {

/// Numbers by ids: a hash table with open addressing, emptied at once.
template <class Key>
class FlatMap {
  public:
    FlatMap() : slots_(64) {}

    void clear() {
        size_ = 0;
        if (++round_ == 0) {
            slots_.assign(slots_.size(), {});
            round_ = 1;
        }
    }
    [[nodiscard]] std::size_t size() const { return size_; }

    static constexpr std::uint32_t none = 0xffffffffU;
    /// The number put at the key; `none` where there is none.
    [[nodiscard]] std::uint32_t find(Key key) const {
        for (std::size_t at = start(key);; at = (at + 1) & (slots_.size() - 1)) {
            const Slot& slot = slots_[at];
            if (slot.round != round_) return none;
            if (slot.key == key.value) return slot.number;
        }
    }
    [[nodiscard]] bool contains(Key key) const { return find(key) != none; }
    /// The key's number; `number` is put where there was none.
    std::uint32_t put(Key key, std::uint32_t number) {
        if (2 * (size_ + 1) > slots_.size()) grow();
        for (std::size_t at = start(key);; at = (at + 1) & (slots_.size() - 1)) {
            Slot& slot = slots_[at];
            if (slot.round != round_) {
                slot = {key.value, number, round_};
                ++size_;
                return number;
            }
            if (slot.key == key.value) return slot.number;
        }
    }

  private:
    struct Slot {
        std::uint32_t key = 0, number = 0, round = 0;
    };
    [[nodiscard]] std::size_t start(Key key) const {
        return (static_cast<std::uint64_t>(key.value) * 0x9e3779b97f4a7c15ULL >> 32U) & (slots_.size() - 1);
    }
    void grow() {
        std::vector<Slot> old(2 * slots_.size());
        old.swap(slots_);
        const std::uint32_t before = round_;
        round_ = 1;
        size_ = 0;
        for (const Slot& slot : old)
            if (slot.round == before) put(Key(std::size_t{slot.key}), slot.number);
    }

    std::vector<Slot> slots_;
    std::size_t size_ = 0;
    std::uint32_t round_ = 1;
};

}  // namespace camber
