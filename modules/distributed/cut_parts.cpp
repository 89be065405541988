module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.ordering;
import :adaptation_rows;
import :block_weights;
import :curve_runs;
import :cut_parts;
import :packing;
import :ranks;
import :sending;
import :sent_parts;
import :shared_rows;

namespace camber {

namespace {

template <int D>
Outcome<PointBox<D>> grid(const SharedRows<D>& shared, double shift, Ranks& ranks, const Execution& execution) {
    Buffer<Vec<D>> points(shared.rows.vertices.size());
    for (std::size_t v = 0; v < points.size(); ++v) points[v] = shared.rows.vertices[v].point;
    const auto own = box_of_points(Column<Vec<D>>(std::move(points)), execution);
    if (!own) return fail(own.error());
    const auto all = gather_all(ranks, Outcome<std::vector<PointBox<D>>>({*own}));
    if (!all) return fail(all.error());
    PointBox<D> box = all->front();
    for (const PointBox<D>& one : *all)
        for (int c = 0; c < D; ++c) {
            box.low[c] = std::min(box.low[c], one.low[c]);
            box.high[c] = std::max(box.high[c], one.high[c]);
        }
    // Twice as wide, so that it holds the mesh for all shifts; halves, since an extent may overflow.
    PointBox<D> wide;
    for (int c = 0; c < D; ++c) {
        const double half = 0.5 * box.high[c] - 0.5 * box.low[c];
        wide.low[c] = box.low[c] - 2 * shift * half;
        wide.high[c] = wide.low[c] + 4 * half;
    }
    return wide;
}

/// This rank's elements as they follow each other along the curve.
template <int D>
struct AlongCurve {
    std::vector<std::uint32_t> elements;
    std::vector<OnCurve> at;  ///< of each of those
};

template <int D>
Outcome<AlongCurve<D>> along_curve(const AdaptationRows<D>& rows, const PointBox<D>& grid, std::size_t first_element,
                                   const Execution& execution) {
    struct Placed {
        std::uint64_t key = 0;
        VertexId number;
        std::uint32_t row = 0;
        auto operator<=>(const Placed&) const = default;
    };
    auto placed = map_each(execution, rows.vertices.size(), [&](std::size_t v) {
        return Placed{morton_key(rows.vertices[v].point, grid), rows.vertices[v].number, static_cast<std::uint32_t>(v)};
    });
    if (!placed) return fail(placed.error());
    std::ranges::sort(*placed);
    Buffer<std::uint32_t> turns(placed->size());
    for (std::size_t i = 0; i < turns.size(); ++i) turns[(*placed)[i].row] = static_cast<std::uint32_t>(i);
    Buffer<std::uint32_t> begin(turns.size() + 1, 0U), first(rows.elements.size());
    for (std::size_t e = 0; e < first.size(); ++e) {
        std::uint32_t least = turns[rows.elements[e].vertices[0].index()];
        for (const VertexId v : rows.elements[e].vertices) least = std::min(least, turns[v.index()]);
        first[e] = least;
        ++begin[least + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    AlongCurve<D> along{std::vector<std::uint32_t>(first.size()), std::vector<OnCurve>(first.size())};
    for (std::size_t e = 0; e < first.size(); ++e) {
        const std::uint32_t at = begin[first[e]]++;
        const Placed& vertex = (*placed)[first[e]];
        along.elements[at] = static_cast<std::uint32_t>(e);
        along.at[at] = {vertex.key, vertex.number.value, first_element + e};
    }
    return along;
}

std::vector<std::size_t> parts_of_ranks(std::size_t parts, std::size_t ranks) {
    std::vector<std::size_t> firsts;
    for (std::size_t r = 0; r <= ranks; ++r) firsts.push_back(parts * r / ranks);
    return firsts;
}

template <int D>
Outcome<PartsToBe> parts_to_be(const AlongCurve<D>& along, const ElementWeights& weights, std::size_t elements,
                               Ranks& ranks) {
    std::vector<WeightOnCurve> own(along.at.size());
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = {along.at[i], weights.weights[along.elements[i]]};
    const auto starts = starts_of_runs(ranks, std::move(own), elements);
    if (!starts) return fail(starts.error());
    PartsToBe parts{Buffer<PartNumber>(along.at.size()), parts_of_ranks(starts->size(), ranks.size())};
    std::size_t part = 0;
    for (std::size_t i = 0; i < along.at.size(); ++i) {
        while (part + 1 < starts->size() && (*starts)[part + 1] <= along.at[i]) ++part;
        parts.of_elements[along.elements[i]] = static_cast<PartNumber>(part);
    }
    return parts;
}

template <int D>
Outcome<FirstNumbers> first_numbers(const AdaptationRows<D>& rows, Ranks& ranks) {
    const auto all = gather_all(ranks, Outcome<std::vector<FirstNumbers>>({FirstNumbers{
                                           rows.elements.size(), rows.facets.size(), rows.lines.size()}}));
    if (!all) return fail(all.error());
    FirstNumbers first;
    for (std::size_t r = 0; r < ranks.rank(); ++r) {
        first.element += (*all)[r].element;
        first.facet += (*all)[r].facet;
        first.line += (*all)[r].line;
    }
    return first;
}

template <int D>
Outcome<std::vector<SentRows<D>>> exchanged_rows(std::vector<SentRows<D>> to, Ranks& ranks) {
    if (ranks.size() == 1) return to;
    std::vector<Bytes> bytes(ranks.size());
    SentRows<D> own = std::exchange(to[ranks.rank()], {});
    for (std::size_t r = 0; r < to.size(); ++r)
        if (r != ranks.rank()) bytes[r] = packed_rows(std::exchange(to[r], {}));
    auto from = ranks.exchange(std::move(bytes));
    if (!from) return fail(from.error());
    std::vector<SentRows<D>> rows;
    for (std::size_t r = 0; r < from->size(); ++r) {
        const Bytes some = std::exchange((*from)[r], {});
        rows.push_back(r == ranks.rank() ? std::exchange(own, {}) : unpacked_rows<SentRows<D>>(some));
    }
    return rows;
}

}  // namespace

template <int D>
Outcome<CutMesh<D>> cut_into_parts(SharedRows<D> shared, const ElementWeights& weights, std::size_t elements,
                                   double shift, Ranks& ranks, const Execution& execution) {
    return guarded([&]() -> Outcome<CutMesh<D>> {
        const auto box = grid(shared, shift, ranks, execution);
        if (!box) return fail(box.error());
        const auto first = first_numbers(shared.rows, ranks);
        if (!first) return fail(first.error());
        auto along = along_curve(shared.rows, *box, first->element, execution);
        if (!along) return fail(along.error());
        const auto parts = parts_to_be(*along, weights, elements, ranks);
        if (!parts) return fail(parts.error());
        const auto elements_along = std::move(along->elements);
        *along = {};
        auto around = elements_around(shared.rows, execution);
        if (!around) return fail(around.error());
        auto sent = Sending<D>(shared, *parts, *around, ranks).rows(elements_along, *first);
        if (!sent) return fail(sent.error());
        shared.rows = {};
        *around = {};
        auto received = exchanged_rows(std::move(*sent), ranks);
        if (!received) return fail(received.error());
        const auto own = [&](std::size_t rank) { return static_cast<PartNumber>(parts->firsts[rank]); };
        auto made = parts_of_sent(std::move(*received), *box, own(ranks.rank()), own(ranks.rank() + 1), execution);
        if (!made) return fail(made.error());
        return CutMesh<D>{std::move(*made), std::move(shared.aside), std::move(shared.first_vertices)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<CutMesh<D>> cut_into_parts<D>(SharedRows<D>, const ElementWeights&, std::size_t, double, Ranks&, \
                                                   const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
