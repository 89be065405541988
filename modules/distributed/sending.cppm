module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.distributed:sending;
import camber.core;
import :adaptation_rows;
import :ranks;
import :routing;
import :sent_parts;
import :shared_rows;

namespace camber {

/// Parts to be: of each of this rank's elements, and whose they are.
struct PartsToBe {
    Buffer<PartNumber> of_elements;
    std::vector<std::size_t> firsts;  ///< of each rank; then how many there are
};

/// The first numbers of this rank's simplices in the whole.
struct FirstNumbers {
    std::size_t element = 0, facet = 0, line = 0;
};

/// A part that has elements at a vertex.
struct PartAt {
    VertexId number;
    PartNumber part = 0;
    auto operator<=>(const PartAt&) const = default;
};

/// What this rank has, to the ranks whose parts it is of.
template <int D>
class Sending {
  public:
    Sending(const SharedRows<D>& shared, const PartsToBe& parts, const Incidence<ElementId>& around, Ranks& ranks)
        : shared_(shared), rows_(shared.rows), parts_(parts), around_(around), ranks_(ranks), to_(ranks.size()) {}

    /// `along`: the elements as they follow each other along the curve.
    Outcome<std::vector<SentRows<D>>> rows(const std::vector<std::uint32_t>& along, const FirstNumbers& first) {
        auto at_shared = parts_at_shared();
        if (!at_shared) return fail(at_shared.error());
        // Of elements first: their vertices go along with them.
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
    /// Whether other ranks may have elements with these vertices.
    template <std::size_t N>
    [[nodiscard]] bool may_be_beside(const std::array<VertexId, N>& simplex) const {
        return ranks_.size() > 1 &&
               std::ranges::all_of(simplex, [&](VertexId v) { return shared_.on_rim[v.index()] != 0; });
    }
    /// Of this rank's vertices that others may have, the parts that anybody has there; sorted.
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
    /// Into the parts of elements that are all here.
    template <int K>
    void put_known(const Buffer<AdaptedSimplex<K>>& simplices, std::size_t first,
                   Buffer<SentSimplex<K>> SentRows<D>::* list) {
        struct Put {
            PartNumber part = 0;
            std::uint32_t row = 0;
            auto operator<=>(const Put&) const = default;
        };
        std::vector<Put> puts;  // by parts, and so by ranks
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
    /// The row of a vertex among those that a rank is sent; it may be sent anew.
    VertexId id_on(std::size_t rank, VertexId v) {
        if (rank_of_ids_[v.index()] != rank) {
            rank_of_ids_[v.index()] = static_cast<std::uint32_t>(rank);
            ids_[v.index()] = VertexId(to_[rank].vertices.size());
            to_[rank].vertices.push_back(rows_.vertices[v.index()]);
        }
        return ids_[v.index()];
    }
    /// What may be of parts that only the owner of a vertex knows: by way of that of the first.
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
    const PartsToBe& parts_;
    const Incidence<ElementId>& around_;
    Ranks& ranks_;
    std::vector<SentRows<D>> to_;
    Buffer<VertexId> ids_;               ///< of each vertex on the rank that it was last sent to
    Buffer<std::uint32_t> rank_of_ids_;  ///< that rank
};

}  // namespace camber
