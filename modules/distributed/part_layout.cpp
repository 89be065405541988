module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import :part_layout;
import :ranks;
import :ringed_parts;
import :row_runs;
import :rows;

namespace camber {

namespace {

/// What a facet counts at each of its vertices, where an element counts 1: edges near a boundary that is displaced have
/// equations.
constexpr std::uint64_t weight_of_facet = 20;

/// Where blocks begin: an element counts at each of its vertices, since all around these is worked on; in buckets,
/// since a bound need not be sharp.
template <int D>
Outcome<std::vector<GlobalNumber>> first_vertices(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks) {
    const RowCounts counts = rows.counts();
    constexpr std::size_t max_buckets = std::size_t{1} << 16U;
    const std::size_t width = counts.points / max_buckets + 1;
    std::vector<std::uint64_t> own(counts.points / width + 1, 0);
    const auto add = [&](std::size_t n, std::uint64_t weight, const auto& read) -> Outcome<Done> {
        const Run all = part_of({0, n}, ranks.rank(), ranks.size());
        for (std::size_t begin = all.begin; begin < all.end; begin += chunk_rows) {
            const auto some = read(begin, std::min(begin + chunk_rows, all.end));
            if (!some) return fail(some.error());
            for (const auto& simplex : some->vertices)
                for (const VertexId v : simplex) own[v.value / width] += weight;
        }
        return Done{};
    };
    const auto count = [&]() -> Outcome<std::vector<std::uint64_t>> {
        auto added = add(counts.elements, 1, [&](std::size_t b, std::size_t e) { return rows.elements(b, e); });
        if (added)
            added =
                add(counts.facets, weight_of_facet, [&](std::size_t b, std::size_t e) { return rows.facets(b, e); });
        if (!added) return fail(added.error());
        return own;
    };
    const auto of_ranks = gather_all(ranks, count());
    if (!of_ranks) return fail(of_ranks.error());
    std::vector<GlobalNumber> first{0};
    const std::uint64_t all = (D + 1) * counts.elements + D * weight_of_facet * counts.facets;
    std::uint64_t before = 0;
    const std::size_t blocks = std::max<std::size_t>(1, (counts.elements + options.elements / 2) / options.elements);
    for (std::size_t b = 0; b < own.size(); ++b) {
        for (std::size_t r = 0; r < ranks.size(); ++r) before += (*of_ranks)[r * own.size() + b];
        const GlobalNumber next = std::min<GlobalNumber>((b + 1) * width, counts.points);
        if (before >= all * first.size() / blocks && next > first.back() && next < counts.points &&
            first.size() < blocks)
            first.push_back(next);
    }
    first.push_back(counts.points);
    return first;
}

/// Blocks dealt out to ranks, and those of a rank to as few parts of like size as may be.
PartLayout layout_of(std::vector<GlobalNumber> first_of_blocks, const BlockOptions& options, std::size_t ranks) {
    PartLayout layout;
    layout.first_of_blocks = std::move(first_of_blocks);
    const std::size_t blocks = layout.blocks();
    const std::size_t at_once = std::max<std::size_t>(1, options.elements_at_once / options.elements);
    for (std::size_t r = 0; r < ranks; ++r) {
        layout.first_parts.push_back(layout.first_vertices.size());
        const Run own = part_of({0, blocks}, r, ranks);
        const std::size_t parts = (own.size() + at_once - 1) / at_once;
        for (std::size_t p = 0; p < parts; ++p)
            layout.first_vertices.push_back(layout.first_of_blocks[part_of(own, p, parts).begin]);
    }
    layout.first_parts.push_back(layout.first_vertices.size());
    layout.first_vertices.push_back(layout.first_of_blocks.back());
    return layout;
}

}  // namespace

template <int D>
Outcome<PartLayout> part_layout(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks) {
    auto first = first_vertices(rows, options, ranks);
    if (!first) return fail(first.error());
    return layout_of(std::move(*first), options, ranks.size());
}

template Outcome<PartLayout> part_layout<2>(const MeshRows<2>&, const BlockOptions&, Ranks&);
template Outcome<PartLayout> part_layout<3>(const MeshRows<3>&, const BlockOptions&, Ranks&);

}  // namespace camber
