module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;

namespace camber {

namespace {

/// Weight of a facet at each of its vertices, relative to weight 1 for an element. It is large, because edges near a
/// displaced boundary add equations.
constexpr std::uint64_t weight_of_facet = 20;

/// An element counts at each of its vertices, because a part processes all elements at its vertices. Counts are summed
/// in buckets of vertices, because the bounds of blocks may be approximate.
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

/// Distributes blocks over ranks, and the blocks of a rank over the minimum number of similar parts.
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

template <int D>
Outcome<PartLayout> part_layout(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks) {
    auto first = first_vertices(rows, options, ranks);
    if (!first) return fail(first.error());
    return layout_of(std::move(*first), options, ranks.size());
}

template <int D>
struct PartRows {
    Buffer<SimplexRow<D>> elements;
    Buffer<SimplexRow<D - 1>> facets;
    Buffer<SimplexRow<1>> edges;
};

class LocalVertices {
  public:
    LocalVertices(Run own, std::vector<GlobalNumber> others) : own_(own), others_(std::move(others)) {
        std::ranges::sort(others_);
        others_.erase(std::ranges::unique(others_).begin(), others_.end());
        before_ = static_cast<std::size_t>(std::ranges::lower_bound(others_, own.begin) - others_.begin());
    }
    [[nodiscard]] bool owns(GlobalNumber v) const { return v >= own_.begin && v < own_.end; }
    [[nodiscard]] std::size_t size() const { return count() + others_.size(); }
    [[nodiscard]] VertexId first() const { return VertexId(before_); }
    [[nodiscard]] VertexId last() const { return VertexId(before_ + count()); }
    [[nodiscard]] VertexId find(GlobalNumber v) const {
        if (owns(v)) return VertexId(before_ + (v - own_.begin));
        const auto at = std::ranges::lower_bound(others_, v);
        if (at == others_.end() || *at != v) return VertexId{};
        const auto place = static_cast<std::size_t>(at - others_.begin());
        return VertexId(place < before_ ? place : place + count());
    }
    [[nodiscard]] Buffer<GlobalNumber> numbers() const {
        Buffer<GlobalNumber> all(others_.begin(), others_.begin() + static_cast<std::ptrdiff_t>(before_));
        all.resize(before_ + count());
        std::iota(all.begin() + static_cast<std::ptrdiff_t>(before_), all.end(), GlobalNumber{own_.begin});
        all.insert(all.end(), others_.begin() + static_cast<std::ptrdiff_t>(before_), others_.end());
        return all;
    }

  private:
    [[nodiscard]] std::size_t count() const { return own_.size(); }
    Run own_;
    std::vector<GlobalNumber> others_;
    std::size_t before_ = 0;
};

template <int K>
struct LocalSimplices {
    Simplices<K> simplices;
    Column<GlobalNumber> numbers;
};
template <int K>
Outcome<LocalSimplices<K>> local_simplices(const Buffer<SimplexRow<K>>& rows, const LocalVertices& vertices,
                                           const Execution& execution) {
    Buffer<SimplexVertices<K>> simplices(rows.size());
    Buffer<Reference> references(rows.size());
    Buffer<GlobalNumber> numbers(rows.size());
    auto done = each(execution, rows.size(), [&](std::size_t i) {
        for (int v = 0; v <= K; ++v) simplices[i][v] = vertices.find(rows[i].vertices[v]);
        references[i] = rows[i].reference;
        numbers[i] = rows[i].row;
    });
    if (!done) return fail(done.error());
    Buffer<std::uint32_t> required;
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (rows[i].required != 0) required.push_back(static_cast<std::uint32_t>(i));
    return LocalSimplices<K>{{std::move(simplices), std::move(references), std::move(required)}, std::move(numbers)};
}

template <int K>
void add_others(const Buffer<SimplexRow<K>>& rows, Run own, std::vector<GlobalNumber>& others) {
    for (const auto& row : rows)
        for (const GlobalNumber v : row.vertices)
            if (v < own.begin || v >= own.end) others.push_back(v);
}

Column<VertexId> local_list(const Column<VertexId>& list, const LocalVertices& vertices) {
    Buffer<VertexId> local;
    for (const VertexId v : list)
        if (const VertexId at = vertices.find(v.value); at.valid()) local.push_back(at);
    return local;
}

/// Makes a part. Points of vertices that other parts own are not set.
template <int D>
Outcome<RingedPart<D>> part_of_rows(const PartRows<D>& of, Run own, const MeshRows<D>& rows, const LinearMesh<D>& lists,
                                    const Execution& execution) {
    std::vector<GlobalNumber> others;
    add_others<D>(of.elements, own, others);
    add_others<D - 1>(of.facets, own, others);
    add_others<1>(of.edges, own, others);
    const LocalVertices vertices(own, std::move(others));
    auto elements = local_simplices<D>(of.elements, vertices, execution);
    if (!elements) return fail(elements.error());
    auto facets = local_simplices<D - 1>(of.facets, vertices, execution);
    if (!facets) return fail(facets.error());
    auto edges = local_simplices<1>(of.edges, vertices, execution);
    if (!edges) return fail(edges.error());
    auto points = rows.points(own.begin, own.end);
    if (!points) return fail(points.error());
    RingedPart<D> part;
    part.first = vertices.first();
    part.last = vertices.last();
    Buffer<Vec<D>> places(vertices.size(), Vec<D>{});
    Buffer<Reference> references(vertices.size(), 0);
    const auto first = static_cast<std::ptrdiff_t>(part.first.index());
    std::ranges::copy(points->points, places.begin() + first);
    std::ranges::copy(points->references, references.begin() + first);
    part.mesh.points = std::move(places);
    part.mesh.point_references = std::move(references);
    part.mesh.corners = local_list(lists.corners, vertices);
    part.mesh.required_vertices = local_list(lists.required_vertices, vertices);
    part.mesh.elements = std::move(elements->simplices);
    part.mesh.facets = std::move(facets->simplices);
    part.mesh.edges = std::move(edges->simplices);
    part.mesh.groups = lists.groups;
    part.elements = std::move(elements->numbers);
    part.facets = std::move(facets->numbers);
    part.edges = std::move(edges->numbers);
    part.vertices = vertices.numbers();
    return part;
}

template <int D>
Outcome<RingedPart<D>> make_part(PartRows<D> of, Run own, const MeshRows<D>& rows, const LinearMesh<D>& lists,
                                 const PartMemory& memory, const Execution& execution) {
    if (memory.before) memory.before();
    of = {in_order<D>(of.elements), in_order<D - 1>(of.facets), in_order<1>(of.edges)};
    auto part = part_of_rows<D>(of, own, rows, lists, execution);
    of = {};
    if (memory.after) {
        memory.after();
        RingedPart<D> none;
        if (part) copy_new_arrays(*part, arrays_of(none));
    }
    if (memory.leave) memory.leave();
    return part;
}

template <std::size_t N>
void each_part_of(const PartLayout& layout, const std::array<GlobalNumber, N>& vertices, const auto& visit) {
    std::array<std::size_t, N> parts{};
    for (std::size_t i = 0; i < N; ++i) parts[i] = layout.part_with(vertices[i]);
    std::ranges::sort(parts);
    for (std::size_t i = 0; i < N; ++i)
        if (i == 0 || parts[i] != parts[i - 1]) visit(parts[i]);
}

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
        lists.emplace_back().reserve(rows + rows / 4);  // reserve space for some of the second ring
    }
    return lists;
}

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

struct RingRequest {
    std::uint64_t part = 0;
    GlobalNumber vertex = 0;
};

template <int D>
Outcome<std::vector<std::vector<RingRequest>>> ring_requests(const std::vector<Buffer<SimplexRow<D>>>& ring,
                                                             const PartLayout& layout, Ranks& ranks) {
    std::vector<ToPart<RingRequest>> out;
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
    return route<RingRequest>(ranks, layout, std::move(out));
}

/// Maximum number of parts of a rank. In iteration b, each rank processes its part b.
std::size_t turns_of(const PartLayout& layout) {
    std::size_t most = 0;
    for (std::size_t r = 0; r + 1 < layout.first_parts.size(); ++r)
        most = std::max(most, layout.end_of(r) - layout.begin_of(r));
    return most;
}

template <int K>
std::vector<ToPart<SimplexRow<K>>> requested_rows(std::span<const SimplexRow<K>> rows,
                                                  std::vector<RingRequest> ring_requests) {
    std::vector<ToPart<SimplexRow<K>>> out;
    if (ring_requests.empty()) return out;
    std::ranges::sort(ring_requests, {}, [](const RingRequest& w) { return std::pair(w.vertex, w.part); });
    const GlobalNumber first = ring_requests.front().vertex, last = ring_requests.back().vertex;
    std::vector<bool> is_requested(last - first + 1, false);
    for (const RingRequest& w : ring_requests) is_requested[w.vertex - first] = true;
    std::vector<std::uint64_t> receivers;
    for (const auto& row : rows) {
        receivers.clear();
        for (const GlobalNumber v : row.vertices)
            if (v >= first && v <= last && is_requested[v - first])
                for (const RingRequest& w : std::ranges::equal_range(ring_requests, v, {}, &RingRequest::vertex))
                    receivers.push_back(w.part);
        if (receivers.empty()) continue;
        std::ranges::sort(receivers);
        receivers.erase(std::ranges::unique(receivers).begin(), receivers.end());
        for (const std::uint64_t part : receivers) out.push_back({part, row});
    }
    return out;
}

template <int K>
Outcome<Done> add_ring(std::vector<Buffer<SimplexRow<K>>>& rows,
                       const std::vector<std::vector<RingRequest>>& ring_requests, const PartLayout& layout,
                       Ranks& ranks) {
    std::vector<std::size_t> first_rings;
    first_rings.reserve(rows.size());
    for (const auto& some : rows) first_rings.push_back(some.size());
    const std::size_t turns = turns_of(layout);
    for (std::size_t b = 0; b < turns; ++b) {
        std::vector<ToPart<SimplexRow<K>>> out;
        if (b < rows.size()) out = requested_rows<K>(std::span(rows[b]).first(first_rings[b]), ring_requests[b]);
        const auto received = route<SimplexRow<K>>(ranks, layout, std::move(out));
        if (!received) return fail(received.error());
        for (std::size_t to = 0; to < rows.size(); ++to) append<K>(rows[to], (*received)[to]);
    }
    return Done{};
}

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

template <int D>
Outcome<Done> fetch_points(RingedParts<D>& parts, Ranks& ranks) {
    const PartLayout& layout = parts.layout;
    std::vector<ToPart<GlobalNumber>> questions;
    for (const RingedPart<D>& part : parts.own)
        for (std::size_t v = 0; v < part.vertices.size(); ++v)
            if (!part.owns(VertexId(v))) questions.push_back({layout.part_with(part.vertices[v]), part.vertices[v]});
    const auto answers =
        query<PlacedPoint<D>>(ranks, layout, questions, [&](std::size_t b, const GlobalNumber& number) {
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
        if (options.elements == 0)
            return fail(ErrorKind::usage, "a block must have at least one element", {}, {}, "give at least 1");
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
        const auto own_requests = ring_requests<D>(*elements, layout, ranks);
        if (!own_requests) return fail(own_requests.error());
        if (auto added = add_ring<D>(*elements, *own_requests, layout, ranks); !added) return fail(added.error());
        if (auto added = add_ring<D - 1>(*facets, *own_requests, layout, ranks); !added) return fail(added.error());
        if (auto added = add_ring<1>(*edges, *own_requests, layout, ranks); !added) return fail(added.error());
        for (std::size_t p = 0; p < elements->size(); ++p) {
            const std::size_t at = layout.begin_of(ranks.rank()) + p;
            PartRows<D> of{std::move((*elements)[p]), std::move((*facets)[p]), std::move((*edges)[p])};
            auto result = make_part<D>(std::move(of), {layout.first_vertices[at], layout.first_vertices[at + 1]}, rows,
                                       *lists, options.memory, without_progress(execution));
            if (!result) return fail(result.error());
            parts.own.push_back(std::move(*result));
            report_progress(execution, p + 1, elements->size());
        }
        if (auto updated = fetch_points(parts, ranks); !updated) return fail(updated.error());
        return parts;
    });
}

template Outcome<RingedParts<2>> split<2>(const MeshRows<2>&, const BlockOptions&, Ranks&, const Execution&);
template Outcome<RingedParts<3>> split<3>(const MeshRows<3>&, const BlockOptions&, Ranks&, const Execution&);

}  // namespace camber
