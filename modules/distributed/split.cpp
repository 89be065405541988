module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import :kept_part;
import :part_layout;
import :ranks;
import :ringed_parts;
import :routing;
import :row_runs;
import :rows;
import :simplex_row;
import :split;

namespace camber {

namespace {

/// The parts of a simplex's vertices, each once.
template <std::size_t N>
void each_part_of(const PartLayout& layout, const std::array<GlobalNumber, N>& vertices, const auto& visit) {
    std::array<std::size_t, N> parts{};
    for (std::size_t i = 0; i < N; ++i) parts[i] = layout.part_with(vertices[i]);
    std::ranges::sort(parts);
    for (std::size_t i = 0; i < N; ++i)
        if (i == 0 || parts[i] != parts[i - 1]) visit(parts[i]);
}

/// Empty lists with room for the rows of each part here: lists that grow would be copied.
template <int K, class Read>
Outcome<std::vector<Buffer<SimplexRow<K>>>> lists_for(Run own, const PartLayout& layout, Ranks& ranks,
                                                      const Read& read) {
    const auto count = [&]() -> Outcome<std::vector<std::uint64_t>> {
        std::vector<std::uint64_t> counts(layout.size(), 0);
        for (std::size_t begin = own.begin; begin < own.end; begin += chunk_rows) {
            const auto some = read(begin, std::min(begin + chunk_rows, own.end));
            if (!some) return fail(some.error());
            for (const auto& simplex : some->vertices) {
                std::array<GlobalNumber, K + 1> vertices{};
                for (int v = 0; v <= K; ++v) vertices[v] = simplex[v].value;
                each_part_of(layout, vertices, [&](std::size_t p) { ++counts[p]; });
            }
        }
        return counts;
    };
    const auto of_ranks = gather_all(ranks, count());
    if (!of_ranks) return fail(of_ranks.error());
    std::vector<Buffer<SimplexRow<K>>> lists;
    for (std::size_t p = layout.begin_of(ranks.rank()); p < layout.end_of(ranks.rank()); ++p) {
        std::uint64_t rows = 0;
        for (std::size_t r = 0; r < ranks.size(); ++r) rows += (*of_ranks)[r * layout.size() + p];
        lists.emplace_back().reserve(rows + rows / 4);  // and some of the second ring
    }
    return lists;
}

/// All rows of one kind to the parts of their vertices: read(begin, end) gives them.
template <int K, class Read>
Outcome<std::vector<Buffer<SimplexRow<K>>>> first_ring(std::size_t n, std::span<const std::uint32_t> required,
                                                       const PartLayout& layout, Ranks& ranks, const Read& read) {
    const Run own = part_of({0, n}, ranks.rank(), ranks.size());
    auto all = lists_for<K>(own, layout, ranks, read);
    if (!all) return all;
    const std::size_t chunks = n / ranks.size() / chunk_rows + 1;
    for (std::size_t c = 0; c < chunks; ++c) {
        const Run chunk = part_of(own, c, chunks);
        const auto things = [&]() -> Outcome<std::vector<ToPart<SimplexRow<K>>>> {
            const auto some = read(chunk.begin, chunk.end);
            if (!some) return fail(some.error());
            std::vector<ToPart<SimplexRow<K>>> out;
            for (std::size_t i = 0; i < some->vertices.size(); ++i) {
                SimplexRow<K> row{chunk.begin + i, {}, some->references[i]};
                for (int v = 0; v <= K; ++v) row.vertices[v] = some->vertices[i][v].value;
                row.required = std::ranges::binary_search(required, static_cast<std::uint32_t>(row.row)) ? 1 : 0;
                each_part_of(layout, row.vertices, [&](std::size_t b) { out.push_back({b, row}); });
            }
            return out;
        };
        auto received = route<SimplexRow<K>>(ranks, layout, things());
        if (!received) return fail(received.error());
        for (std::size_t b = 0; b < all->size(); ++b) append<K>((*all)[b], (*received)[b]);
    }
    return all;
}

/// A part that wants what is around a vertex of another.
struct Wish {
    std::uint64_t part = 0;
    GlobalNumber vertex = 0;
};

/// Of each own part the vertices of its first ring that are others', told to their owners.
template <int D>
Outcome<std::vector<std::vector<Wish>>> wishes(const std::vector<Buffer<SimplexRow<D>>>& ring, const PartLayout& layout,
                                               Ranks& ranks) {
    std::vector<ToPart<Wish>> out;
    for (std::size_t b = 0; b < ring.size(); ++b) {
        const std::size_t part = layout.begin_of(ranks.rank()) + b;
        std::vector<GlobalNumber> others;
        for (const auto& row : ring[b])
            for (const GlobalNumber v : row.vertices)
                if (v < layout.first_vertices[part] || v >= layout.first_vertices[part + 1]) others.push_back(v);
        std::ranges::sort(others);
        others.erase(std::ranges::unique(others).begin(), others.end());
        for (const GlobalNumber v : others) out.push_back({layout.part_with(v), {part, v}});
    }
    return route<Wish>(ranks, layout, std::move(out));
}

/// The most parts that a rank has: so many turns go over all of them, one of each rank at a time.
std::size_t turns_of(const PartLayout& layout) {
    std::size_t most = 0;
    for (std::size_t r = 0; r + 1 < layout.first_parts.size(); ++r)
        most = std::max(most, layout.end_of(r) - layout.begin_of(r));
    return most;
}

/// Those of a part's simplices that others wish, each once for each of them.
template <int K>
std::vector<ToPart<SimplexRow<K>>> wished_rows(std::span<const SimplexRow<K>> rows, std::vector<Wish> wishes) {
    std::vector<ToPart<SimplexRow<K>>> out;
    if (wishes.empty()) return out;
    std::ranges::sort(wishes, {}, [](const Wish& w) { return std::pair(w.vertex, w.part); });
    const GlobalNumber first = wishes.front().vertex, last = wishes.back().vertex;
    std::vector<bool> is_wished(last - first + 1, false);  // most are not
    for (const Wish& w : wishes) is_wished[w.vertex - first] = true;
    std::vector<std::uint64_t> told;
    for (const auto& row : rows) {
        told.clear();
        for (const GlobalNumber v : row.vertices)
            if (v >= first && v <= last && is_wished[v - first])
                for (const Wish& w : std::ranges::equal_range(wishes, v, {}, &Wish::vertex)) told.push_back(w.part);
        if (told.empty()) continue;
        std::ranges::sort(told);
        told.erase(std::ranges::unique(told).begin(), told.end());
        for (const std::uint64_t part : told) out.push_back({part, row});
    }
    return out;
}

/// The first ring with what is around its vertices: a ring more. Others ask for first rings alone.
template <int K>
Outcome<Done> add_ring(std::vector<Buffer<SimplexRow<K>>>& rows, const std::vector<std::vector<Wish>>& wishes,
                       const PartLayout& layout, Ranks& ranks) {
    std::vector<std::size_t> first_rings;
    first_rings.reserve(rows.size());
    for (const auto& some : rows) first_rings.push_back(some.size());
    const std::size_t turns = turns_of(layout);
    for (std::size_t b = 0; b < turns; ++b) {
        std::vector<ToPart<SimplexRow<K>>> out;
        if (b < rows.size()) out = wished_rows<K>(std::span(rows[b]).first(first_rings[b]), wishes[b]);
        const auto received = route<SimplexRow<K>>(ranks, layout, std::move(out));
        if (!received) return fail(received.error());
        for (std::size_t to = 0; to < rows.size(); ++to) append<K>(rows[to], (*received)[to]);
    }
    return Done{};
}

/// What is required is looked up.
template <int D>
void sort_required(LinearMesh<D>& lists) {
    const auto sorted = [](Column<std::uint32_t> rows) {
        Buffer<std::uint32_t> out = take(std::move(rows));
        std::ranges::sort(out);
        return Column<std::uint32_t>(std::move(out));
    };
    lists.elements.required = sorted(std::move(lists.elements.required));
    lists.facets.required = sorted(std::move(lists.facets.required));
    lists.edges.required = sorted(std::move(lists.edges.required));
}

template <int D>
struct PlacedPoint {
    Vec<D> point;
    Reference reference = 0;
};

/// The points of others, from them.
template <int D>
Outcome<Done> bring_points(RingedParts<D>& parts, Ranks& ranks) {
    const PartLayout& layout = parts.layout;
    std::vector<ToPart<GlobalNumber>> questions;
    for (const RingedPart<D>& part : parts.own)
        for (std::size_t v = 0; v < part.vertices.size(); ++v)
            if (!part.owns(VertexId(v))) questions.push_back({layout.part_with(part.vertices[v]), part.vertices[v]});
    const auto answers = ask<PlacedPoint<D>>(ranks, layout, questions, [&](std::size_t b, const GlobalNumber& number) {
        const RingedPart<D>& part = parts.own[b];
        const VertexId v(part.first.index() + (number - layout.first_vertices[layout.begin_of(ranks.rank()) + b]));
        return PlacedPoint<D>{part.mesh.points[v], part.mesh.point_references[v]};
    });
    if (!answers) return fail(answers.error());
    std::size_t next = 0;
    for (RingedPart<D>& part : parts.own) {
        auto points = take(std::move(part.mesh.points));
        auto references = take(std::move(part.mesh.point_references));
        for (std::size_t v = 0; v < points.size(); ++v) {
            if (part.owns(VertexId(v))) continue;
            points[v] = (*answers)[next].point;
            references[v] = (*answers)[next++].reference;
        }
        part.mesh.points = std::move(points);
        part.mesh.point_references = std::move(references);
    }
    return Done{};
}

}  // namespace

template <int D>
Outcome<RingedParts<D>> split(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks,
                              const Execution& execution) {
    return guarded([&]() -> Outcome<RingedParts<D>> {
        if (options.elements == 0) return fail(ErrorKind::usage, "a block of no elements", {}, {}, "give at least 1");
        auto lists = rows.lists();
        if (!lists) return fail(lists.error());
        sort_required(*lists);
        auto laid_out = part_layout(rows, options, ranks);
        if (!laid_out) return fail(laid_out.error());
        RingedParts<D> parts{std::move(*laid_out), {}};
        const PartLayout& layout = parts.layout;
        const RowCounts counts = rows.counts();
        auto elements = first_ring<D>(counts.elements, lists->elements.required.view(), layout, ranks,
                                      [&](std::size_t b, std::size_t e) { return rows.elements(b, e); });
        if (!elements) return fail(elements.error());
        auto facets = first_ring<D - 1>(counts.facets, lists->facets.required.view(), layout, ranks,
                                        [&](std::size_t b, std::size_t e) { return rows.facets(b, e); });
        if (!facets) return fail(facets.error());
        auto edges = first_ring<1>(counts.edges, lists->edges.required.view(), layout, ranks,
                                   [&](std::size_t b, std::size_t e) { return rows.edges(b, e); });
        if (!edges) return fail(edges.error());
        const auto wished = wishes<D>(*elements, layout, ranks);
        if (!wished) return fail(wished.error());
        if (auto added = add_ring<D>(*elements, *wished, layout, ranks); !added) return fail(added.error());
        if (auto added = add_ring<D - 1>(*facets, *wished, layout, ranks); !added) return fail(added.error());
        if (auto added = add_ring<1>(*edges, *wished, layout, ranks); !added) return fail(added.error());
        for (std::size_t p = 0; p < elements->size(); ++p) {
            const std::size_t at = layout.begin_of(ranks.rank()) + p;
            PartRows<D> of{std::move((*elements)[p]), std::move((*facets)[p]), std::move((*edges)[p])};
            auto made = kept_part<D>(std::move(of), {layout.first_vertices[at], layout.first_vertices[at + 1]}, rows,
                                     *lists, options.memory, without_progress(execution));
            if (!made) return fail(made.error());
            parts.own.push_back(std::move(*made));
            report_progress(execution, p + 1, elements->size());
        }
        if (auto brought = bring_points(parts, ranks); !brought) return fail(brought.error());
        return parts;
    });
}

template Outcome<RingedParts<2>> split<2>(const MeshRows<2>&, const BlockOptions&, Ranks&, const Execution&);
template Outcome<RingedParts<3>> split<3>(const MeshRows<3>&, const BlockOptions&, Ranks&, const Execution&);

}  // namespace camber
