module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
module camber.io;
import camber.core;

namespace camber {

namespace {

/// Whether a table of all numbers from the first tag to the last is little more than the tags themselves.
bool is_dense(std::uint64_t first, std::uint64_t last, std::size_t n) {
    return last - first < 4 * std::uint64_t{n} + 64;
}

}  // namespace

Buffer<std::uint32_t> rows_by_tag(std::span<const std::uint64_t> tags) {
    if (std::is_sorted(tags.begin(), tags.end())) return {};
    const auto [first, last] = std::minmax_element(tags.begin(), tags.end());
    const std::uint64_t low = *first;
    Buffer<std::uint32_t> rows(tags.size());
    if (!is_dense(low, *last, tags.size())) {
        std::iota(rows.begin(), rows.end(), 0U);
        std::stable_sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) { return tags[a] < tags[b]; });
        return rows;
    }
    Buffer<std::uint32_t> starts(*last - low + 2, 0U);
    for (const std::uint64_t tag : tags) ++starts[tag - low + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    for (std::size_t i = 0; i < tags.size(); ++i) rows[starts[tags[i] - low]++] = static_cast<std::uint32_t>(i);
    return rows;
}

TagIndex::TagIndex(std::span<const std::uint64_t> ascending, Buffer<std::uint32_t> rows)
    : tags_(ascending), rows_(std::move(rows)) {
    if (tags_.empty()) return;
    const std::uint64_t width = tags_.back() - tags_.front();
    contiguous_ = width == tags_.size() - 1 && std::adjacent_find(tags_.begin(), tags_.end()) == tags_.end();
    if (contiguous_ || !is_dense(tags_.front(), tags_.back(), tags_.size())) return;
    table_ = Buffer<std::uint32_t>(width + 1, no_row);
    for (std::size_t i = tags_.size(); i-- > 0;) table_[tags_[i] - tags_.front()] = row(i);
}

std::uint32_t TagIndex::search(std::uint64_t tag) const {
    const auto found = std::lower_bound(tags_.begin(), tags_.end(), tag);
    return found != tags_.end() && *found == tag ? row(static_cast<std::size_t>(found - tags_.begin())) : no_row;
}

}  // namespace camber
