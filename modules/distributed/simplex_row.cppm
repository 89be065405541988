module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.distributed:simplex_row;
import camber.core;
import :ringed_parts;

namespace camber {

/// Of a K-simplex, on its way to parts.
template <int K>
struct SimplexRow {
    GlobalNumber row = 0;
    std::array<GlobalNumber, K + 1> vertices{};
    Reference reference = 0;
    std::uint32_t required = 0;
};

/// Rising, each once. They come in a few runs that rise: these are merged.
template <int K>
Buffer<SimplexRow<K>> in_order(const Buffer<SimplexRow<K>>& given) {
    Buffer<SimplexRow<K>> rows(given.begin(), given.end());
    const auto precedes = [](const SimplexRow<K>& a, const SimplexRow<K>& b) { return a.row < b.row; };
    std::vector<std::size_t> runs{0};
    for (std::size_t i = 1; i < rows.size(); ++i)
        if (precedes(rows[i], rows[i - 1])) runs.push_back(i);
    runs.push_back(rows.size());
    const auto at = [&](std::size_t run) { return rows.begin() + static_cast<std::ptrdiff_t>(runs[run]); };
    const std::size_t last = runs.size() - 1;
    for (std::size_t width = 1; width < last; width *= 2)
        for (std::size_t r = 0; r + width < last; r += 2 * width)
            std::inplace_merge(at(r), at(r + width), at(std::min(r + 2 * width, last)), precedes);
    const auto again = std::ranges::unique(rows, {}, &SimplexRow<K>::row);
    rows.erase(again.begin(), again.end());
    return rows;
}

/// Rows at the end of a list.
template <int K>
void append(Buffer<SimplexRow<K>>& list, const std::vector<SimplexRow<K>>& rows) {
    const std::size_t before = list.size();
    list.resize(before + rows.size());
    fill_array<SimplexRow<K>>(std::span(list).subspan(before), rows);
}

}  // namespace camber
