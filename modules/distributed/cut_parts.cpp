module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.ordering;

namespace camber {

namespace {

/// Position of an element along the Morton curve: its first vertex, then its number.
struct OnCurve {
    std::uint64_t key = 0;
    std::uint64_t vertex = 0, element = 0;
    friend auto operator<=>(const OnCurve&, const OnCurve&) = default;
};
struct WeightOnCurve {
    OnCurve at;
    std::uint64_t weight = 0;
};

/// Divides the curve for the ranks: splitter r is the end of rank r and the start of rank r + 1.
Outcome<std::vector<OnCurve>> splitters(Ranks& ranks, const std::vector<WeightOnCurve>& own) {
    constexpr std::size_t samples = 64;
    std::vector<OnCurve> some;
    for (std::size_t i = 0; i < samples && !own.empty(); ++i) some.push_back(own[own.size() * i / samples].at);
    auto all = gather_all(ranks, Outcome<std::vector<OnCurve>>(std::move(some)));
    if (!all) return fail(all.error());
    std::ranges::sort(*all);
    std::vector<OnCurve> out;
    for (std::size_t r = 1; r < ranks.size() && !all->empty(); ++r)
        out.push_back((*all)[all->size() * r / ranks.size()]);
    return out;
}

Outcome<std::vector<WeightOnCurve>> sorted_among_ranks(Ranks& ranks, std::vector<WeightOnCurve> own) {
    if (ranks.size() == 1) return own;
    const auto split = splitters(ranks, own);
    if (!split) return fail(split.error());
    std::vector<std::vector<WeightOnCurve>> to(ranks.size());
    for (auto begin = own.cbegin(); auto& some : to) {
        const auto r = static_cast<std::size_t>(&some - to.data());
        const auto end =
            r < split->size() ? std::ranges::lower_bound(own, (*split)[r], {}, &WeightOnCurve::at) : own.end();
        some.assign(begin, std::vector<WeightOnCurve>::const_iterator(end));
        begin = end;
    }
    own = {};
    const auto from = exchanged_lists(ranks, std::move(to));
    if (!from) return fail(from.error());
    for (const auto& some : *from) {
        const auto before = static_cast<std::ptrdiff_t>(own.size());
        own.insert(own.end(), some.begin(), some.end());
        std::ranges::inplace_merge(own, own.begin() + before, {}, &WeightOnCurve::at);
    }
    return own;
}

struct Start {
    std::uint64_t run = 0;
    OnCurve at;
};

/// Returns the first elements of runs of about equal weight, with `in_a_run` expected elements each (ElementWeights).
/// `own` must be sorted. The result does not depend on the distribution.
Outcome<std::vector<OnCurve>> starts_of_runs(Ranks& ranks, std::vector<WeightOnCurve> own, std::size_t in_a_run) {
    const auto sorted = sorted_among_ranks(ranks, std::move(own));
    if (!sorted) return fail(sorted.error());
    std::uint64_t sum = 0;
    for (const WeightOnCurve& w : *sorted) sum += w.weight;
    const auto weight = counted(ranks, sum);
    if (!weight) return fail(weight.error());
    const double elements = static_cast<double>(weight->all) / static_cast<double>(ElementWeights::one);
    const double target = elements / static_cast<double>(std::max<std::size_t>(in_a_run, 1));
    const auto runs = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(target)));
    // Weights are divided by the weight of a run, because a product with the number of runs may overflow 64 bits.
    const std::uint64_t size = std::max<std::uint64_t>(1, (weight->all + runs - 1) / runs);
    std::vector<Start> here;
    std::uint64_t before = weight->before;
    for (const WeightOnCurve& w : *sorted) {
        if (here.empty() || here.back().run != before / size) here.push_back({before / size, w.at});
        before += w.weight;
    }
    const auto all = gather_all(ranks, Outcome<std::vector<Start>>(std::move(here)));
    if (!all) return fail(all.error());
    std::vector<OnCurve> starts;
    for (std::size_t i = 0; i < all->size(); ++i)
        if (i == 0 || (*all)[i].run != (*all)[i - 1].run) starts.push_back((*all)[i].at);
    return starts;
}

struct PlannedParts {
    Buffer<PartNumber> of_elements;
    std::vector<std::size_t> firsts;
};

struct FirstNumbers {
    std::size_t element = 0, facet = 0, line = 0;
};

struct PartAt {
    VertexId number;
    PartNumber part = 0;
    auto operator<=>(const PartAt&) const = default;
};

template <int D>
class RowSender {
  public:
    RowSender(const SharedRows<D>& shared, const PlannedParts& parts, const Incidence<ElementId>& around, Ranks& ranks)
        : shared_(shared), rows_(shared.rows), parts_(parts), around_(around), ranks_(ranks), to_(ranks.size()) {}

    Outcome<std::vector<SentRows<D>>> rows(const std::vector<std::uint32_t>& along, const FirstNumbers& first) {
        auto at_shared = parts_at_shared();
        if (!at_shared) return fail(at_shared.error());
        // Elements are sent first, with their vertices.
        ids_.assign(rows_.vertices.size(), VertexId{});
        rank_of_ids_.assign(rows_.vertices.size(), static_cast<std::uint32_t>(ranks_.size()));
        put_rank_by_rank(along, first);
        if (auto put = put_by_owners(rows_.facets, first.facet, *at_shared, &SentRows<D>::facets_by_number); !put)
            return fail(put.error());
        if (auto put = put_by_owners(rows_.lines, first.line, *at_shared, &SentRows<D>::lines_by_number); !put)
            return fail(put.error());
        return std::move(to_);
    }

  private:
    template <std::size_t N>
    [[nodiscard]] bool may_be_beside(const std::array<VertexId, N>& simplex) const {
        return ranks_.size() > 1 &&
               std::ranges::all_of(simplex, [&](VertexId v) { return shared_.on_rim[v.index()] != 0; });
    }
    Outcome<std::vector<PartAt>> parts_at_shared() {
        if (ranks_.size() == 1) return std::vector<PartAt>();
        std::vector<std::vector<PartAt>> to(ranks_.size());
        std::vector<PartNumber> found;
        for (std::size_t v = 0; v < rows_.vertices.size(); ++v) {
            if (shared_.on_rim[v] == 0) continue;
            found.clear();
            for (const ElementId e : around_[v]) found.push_back(parts_.of_elements[e.index()]);
            std::ranges::sort(found);
            found.erase(std::ranges::unique(found).begin(), found.end());
            const VertexId number = rows_.vertices[v].number;
            auto& some = to[rank_with(shared_.first_vertices, number.index())];
            for (const PartNumber part : found) some.push_back({number, part});
        }
        auto all = exchanged_values<PartAt>(ranks_, std::move(to));
        if (!all) return all;
        std::ranges::sort(*all);
        all->erase(std::ranges::unique(*all).begin(), all->end());
        return all;
    }
    void put_rank_by_rank(const std::vector<std::uint32_t>& along, const FirstNumbers& first) {
        std::vector<std::size_t> elements(ranks_.size(), 0);
        for (const PartNumber part : parts_.of_elements) ++elements[rank_with(parts_.firsts, part)];
        for (std::size_t r = 0; r < elements.size(); ++r) to_[r].elements.reserve(elements[r]);
        for (const std::uint32_t e : along)
            put(rows_.elements[e], first.element + e, parts_.of_elements[e], &SentRows<D>::elements);
        put_known(rows_.facets, first.facet, &SentRows<D>::facets);
        put_known(rows_.lines, first.line, &SentRows<D>::lines);
    }
    template <int K>
    void put_known(const Buffer<AdaptedSimplex<K>>& simplices, std::size_t first,
                   Buffer<SentSimplex<K>> SentRows<D>::* list) {
        struct Put {
            PartNumber part = 0;
            std::uint32_t row = 0;
            auto operator<=>(const Put&) const = default;
        };
        std::vector<Put> puts;  // sorted by part, and so by rank
        std::vector<PartNumber> found;
        for (std::size_t i = 0; i < simplices.size(); ++i) {
            const auto& vertices = simplices[i].vertices;
            if (may_be_beside(vertices)) continue;
            found.clear();
            for (const ElementId e : around_[vertices[0]])
                if (std::ranges::all_of(vertices, [&](VertexId v) {
                        return std::ranges::find(rows_.elements[e.index()].vertices, v) !=
                               rows_.elements[e.index()].vertices.end();
                    }))
                    found.push_back(parts_.of_elements[e.index()]);
            std::ranges::sort(found);
            found.erase(std::ranges::unique(found).begin(), found.end());
            for (const PartNumber part : found) puts.push_back({part, static_cast<std::uint32_t>(i)});
        }
        std::ranges::sort(puts);
        for (const Put& one : puts) put(simplices[one.row], first + one.row, one.part, list);
    }
    template <int K>
    void put(AdaptedSimplex<K> simplex, std::uint64_t number, PartNumber part,
             Buffer<SentSimplex<K>> SentRows<D>::* list) {
        const std::size_t rank = rank_with(parts_.firsts, part);
        for (VertexId& v : simplex.vertices) v = id_on(rank, v);
        (to_[rank].*list).push_back({number, part, simplex});
    }
    VertexId id_on(std::size_t rank, VertexId v) {
        if (rank_of_ids_[v.index()] != rank) {
            rank_of_ids_[v.index()] = static_cast<std::uint32_t>(rank);
            ids_[v.index()] = VertexId(to_[rank].vertices.size());
            to_[rank].vertices.push_back(rows_.vertices[v.index()]);
        }
        return ids_[v.index()];
    }
    template <int K>
    Outcome<Done> put_by_owners(const Buffer<AdaptedSimplex<K>>& simplices, std::size_t first,
                                const std::vector<PartAt>& at_shared, Buffer<SentSimplex<K>> SentRows<D>::* list) {
        if (ranks_.size() == 1) return Done{};
        std::vector<std::vector<SentSimplex<K>>> to(ranks_.size());
        for (std::size_t i = 0; i < simplices.size(); ++i) {
            if (!may_be_beside(simplices[i].vertices)) continue;
            SentSimplex<K> one{first + i, 0, simplices[i]};
            for (VertexId& v : one.simplex.vertices) v = rows_.vertices[v.index()].number;
            const VertexId least = std::ranges::min(one.simplex.vertices);
            to[rank_with(shared_.first_vertices, least.index())].push_back(one);
        }
        const auto from = exchanged_lists(ranks_, std::move(to));
        if (!from) return fail(from.error());
        for (const auto& some : *from)
            for (SentSimplex<K> one : some)
                for (const PartAt& at :
                     std::ranges::equal_range(at_shared, std::ranges::min(one.simplex.vertices), {}, &PartAt::number)) {
                    one.part = at.part;
                    (to_[rank_with(parts_.firsts, at.part)].*list).push_back(one);
                }
        return Done{};
    }

    const SharedRows<D>& shared_;
    const AdaptationRows<D>& rows_;
    const PlannedParts& parts_;
    const Incidence<ElementId>& around_;
    Ranks& ranks_;
    std::vector<SentRows<D>> to_;
    Buffer<VertexId> ids_;
    Buffer<std::uint32_t> rank_of_ids_;
};

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
    // The grid has twice the extent, so that it contains the mesh for all shifts. Halves avoid overflow.
    PointBox<D> wide;
    for (int c = 0; c < D; ++c) {
        const double half = 0.5 * box.high[c] - 0.5 * box.low[c];
        wide.low[c] = box.low[c] - 2 * shift * half;
        wide.high[c] = wide.low[c] + 4 * half;
    }
    return wide;
}

template <int D>
struct AlongCurve {
    std::vector<std::uint32_t> elements;
    std::vector<OnCurve> at;
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
Outcome<PlannedParts> parts_to_be(const AlongCurve<D>& along, const ElementWeights& weights, std::size_t elements,
                                  Ranks& ranks) {
    std::vector<WeightOnCurve> own(along.at.size());
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = {along.at[i], weights.weights[along.elements[i]]};
    const auto starts = starts_of_runs(ranks, std::move(own), elements);
    if (!starts) return fail(starts.error());
    PlannedParts parts{Buffer<PartNumber>(along.at.size()), parts_of_ranks(starts->size(), ranks.size())};
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
        auto sent = RowSender<D>(shared, *parts, *around, ranks).rows(elements_along, *first);
        if (!sent) return fail(sent.error());
        shared.rows = {};
        *around = {};
        auto received = exchanged_rows(std::move(*sent), ranks);
        if (!received) return fail(received.error());
        const auto own = [&](std::size_t rank) { return static_cast<PartNumber>(parts->firsts[rank]); };
        auto result = parts_of_sent(std::move(*received), *box, own(ranks.rank()), own(ranks.rank() + 1), execution);
        if (!result) return fail(result.error());
        return CutMesh<D>{std::move(*result), std::move(shared.without_elements), std::move(shared.first_vertices)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<CutMesh<D>> cut_into_parts<D>(SharedRows<D>, const ElementWeights&, std::size_t, double, Ranks&, \
                                                   const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
