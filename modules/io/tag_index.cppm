module;
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
module camber.io:tag_index;
import camber.core;

namespace camber {

inline constexpr std::uint32_t no_row = std::numeric_limits<std::uint32_t>::max();

/// The rows in the order of their tags, those of one tag in the order they have; none at all where they are in it. At
/// most `max_entities` of them. Takes no memory for tags that do not occur.
[[nodiscard]] Buffer<std::uint32_t> rows_by_tag(std::span<const std::uint64_t> tags);

/// Finds rows by tags, whatever these are: next to each other, with gaps, or scattered.
class TagIndex {
  public:
    TagIndex() = default;
    /// Of ascending tags, which must outlive it; row i is `rows[i]`, or i where there are no rows.
    TagIndex(std::span<const std::uint64_t> ascending, Buffer<std::uint32_t> rows);

    /// The row, or `no_row`.
    [[nodiscard]] std::uint32_t find(std::uint64_t tag) const {
        if (tags_.empty() || tag < tags_.front() || tag > tags_.back()) return no_row;
        const std::size_t offset = tag - tags_.front();
        if (contiguous_) return row(offset);
        return table_.empty() ? search(tag) : table_[offset];
    }

  private:
    [[nodiscard]] std::uint32_t row(std::size_t i) const {
        return rows_.empty() ? static_cast<std::uint32_t>(i) : rows_[i];
    }
    [[nodiscard]] std::uint32_t search(std::uint64_t tag) const;

    std::span<const std::uint64_t> tags_;
    Buffer<std::uint32_t> rows_;
    bool contiguous_ = false;
    Buffer<std::uint32_t> table_;  ///< by tags from the first; where most of them occur
};

}  // namespace camber
