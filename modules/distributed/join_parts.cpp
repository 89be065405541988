module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import :adaptation_rows;
import :cut_parts;
import :first_of_ranks;
import :ranks;
import :routing;
import :shared_rows;

namespace camber {

namespace {

/// Vertices of several parts, by the numbers that they had: which rank has each now, and where.
template <int D>
class SharedNumbers {
  public:
    SharedNumbers(const CutMesh<D>& cut, Ranks& ranks) : first_vertices_(cut.first_vertices), ranks_(ranks) {
        const auto see = [&](const AdaptationRows<D>& part) {
            for (const AdaptedVertex<D>& v : part.vertices)
                if (v.number.valid()) numbers_.push_back(v.number);
        };
        std::ranges::for_each(cut.parts, see);
        see(cut.aside);
        std::ranges::sort(numbers_);
        numbers_.erase(std::ranges::unique(numbers_).begin(), numbers_.end());
    }

    /// The first rank that has it is a vertex's own: those that had it before see to that.
    Outcome<Done> find_owners() {
        std::vector<std::vector<VertexId>> to(ranks_.size());
        for (const VertexId number : numbers_) to[rank_with(first_vertices_, number.index())].push_back(number);
        const auto asked = exchanged_lists(ranks_, std::move(to));
        if (!asked) return fail(asked.error());
        const std::size_t first = first_vertices_[ranks_.rank()];
        const auto none = static_cast<std::uint32_t>(ranks_.size());
        Buffer<std::uint32_t> owners(first_vertices_[ranks_.rank() + 1] - first, none);
        for (std::size_t r = 0; r < asked->size(); ++r)
            for (const VertexId number : (*asked)[r]) {
                std::uint32_t& owner = owners[number.index() - first];
                owner = std::min(owner, static_cast<std::uint32_t>(r));
            }
        std::vector<std::vector<std::uint32_t>> answers(ranks_.size());
        for (std::size_t r = 0; r < asked->size(); ++r)
            for (const VertexId number : (*asked)[r]) answers[r].push_back(owners[number.index() - first]);
        auto told = exchanged_values<std::uint32_t>(ranks_, std::move(answers));
        if (!told) return fail(told.error());
        owners_ = std::move(*told);
        return Done{};
    }
    /// From the ranks that own them the numbers that they have now; `now(i)` is that of the i-th here, if it is own.
    Outcome<Buffer<VertexId>> numbers_now(const auto& now) {
        std::vector<std::vector<VertexId>> to(ranks_.size());
        for (std::size_t i = 0; i < numbers_.size(); ++i) to[owners_[i]].push_back(numbers_[i]);
        auto asked = exchanged_lists(ranks_, std::move(to));
        if (!asked) return fail(asked.error());
        for (auto& some : *asked)
            for (VertexId& number : some) number = now(at(number));
        const auto told = exchanged_lists(ranks_, std::move(*asked));
        if (!told) return fail(told.error());
        std::vector<std::size_t> next(ranks_.size(), 0);
        Buffer<VertexId> numbers(numbers_.size());
        for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = (*told)[owners_[i]][next[owners_[i]]++];
        return numbers;
    }
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }
    [[nodiscard]] std::size_t at(VertexId number) const {
        return static_cast<std::size_t>(std::ranges::lower_bound(numbers_, number) - numbers_.begin());
    }
    [[nodiscard]] bool is_own(std::size_t i) const { return owners_[i] == ranks_.rank(); }

  private:
    const std::vector<std::size_t>& first_vertices_;
    Ranks& ranks_;
    std::vector<VertexId> numbers_;  ///< that are here, rising
    std::vector<std::uint32_t> owners_;
};

/// Vertices of parts get rows: this rank's own ones first, in the order of the parts.
template <int D>
class JoinedVertices {
  public:
    JoinedVertices(const CutMesh<D>& cut, const SharedNumbers<D>& shared)
        : shared_(shared), rows_(shared.size(), VertexId{}) {
        for (const AdaptationRows<D>& part : cut.parts)
            for (const AdaptedVertex<D>& v : part.vertices)
                if (!v.number.valid() || is_own_and_new(v.number)) ++own_;
        rows_.assign(shared.size(), VertexId{});
        out_.reserve(own_);
    }
    [[nodiscard]] std::size_t own() const { return own_; }

    /// The row of each vertex of a part.
    std::vector<VertexId> take(const AdaptationRows<D>& part) {
        std::vector<VertexId> rows;
        rows.reserve(part.vertices.size());
        for (const AdaptedVertex<D>& v : part.vertices) rows.push_back(v.number.valid() ? put_shared(v) : put(v, 0));
        return rows;
    }
    [[nodiscard]] VertexId row(std::size_t shared) const { return rows_[shared]; }

    /// All of them, as numbered from `first` on; `now`: the numbers of shared ones.
    void move_into(SharedRows<D>& out, std::size_t first, const Buffer<VertexId>& now) {
        for (std::size_t v = 0; v < out_.size(); ++v) out_[v].number = VertexId(first + v);
        for (AdaptedVertex<D>& v : others_) v.number = now[shared_.at(v.number)];
        out_.insert(out_.end(), others_.begin(), others_.end());
        on_rim_.resize(out_.size(), 1);
        out.rows.vertices = std::move(out_);
        out.on_rim = std::move(on_rim_);
    }

  private:
    bool is_own_and_new(VertexId number) {
        const std::size_t i = shared_.at(number);
        return shared_.is_own(i) && !std::exchange(rows_[i], number).valid();
    }
    VertexId put(const AdaptedVertex<D>& v, std::uint8_t on_rim) {
        out_.push_back(v);
        on_rim_.push_back(on_rim);
        return VertexId(out_.size() - 1);
    }
    VertexId put_shared(const AdaptedVertex<D>& v) {
        const std::size_t i = shared_.at(v.number);
        if (rows_[i].valid()) return rows_[i];
        if (shared_.is_own(i)) return rows_[i] = put(v, 1);
        others_.push_back(v);
        return rows_[i] = VertexId(own_ + others_.size() - 1);
    }

    const SharedNumbers<D>& shared_;
    std::size_t own_ = 0;
    Buffer<VertexId> rows_;  ///< of each shared number
    Buffer<AdaptedVertex<D>> out_, others_;
    Buffer<std::uint8_t> on_rim_;
};

/// Takes away what lower ranks have too, of the rows that are said.
template <int D, int K>
Outcome<Done> keep_first(SharedRows<D>& out, Buffer<AdaptedSimplex<K>>& simplices,
                         const std::vector<std::uint32_t>& shared, Ranks& ranks) {
    if (ranks.size() == 1) return Done{};
    std::vector<SimplexVertices<K>> numbers;
    for (const std::uint32_t i : shared) {
        SimplexVertices<K> one = simplices[i].vertices;
        for (VertexId& v : one) v = out.rows.vertices[v.index()].number;
        std::ranges::sort(one);
        numbers.push_back(one);
    }
    const auto kept = are_first(numbers, out.first_vertices, ranks);
    if (!kept) return fail(kept.error());
    std::size_t end = 0;
    for (std::size_t i = 0, s = 0; i < simplices.size(); ++i) {
        const bool is_shared = s < shared.size() && shared[s] == i;
        if (is_shared && (*kept)[s++] == 0) continue;
        simplices[end++] = simplices[i];
    }
    simplices.resize(end);
    return Done{};
}

/// Of facets no other mark than these is known.
Marks thawed(Marks marks) {
    Marks out;
    for (const Mark mark : {Mark::required, Mark::ridge})
        if (marks.has(mark)) out |= mark;
    return out;
}

template <int D>
class Joining {
  public:
    Joining(CutMesh<D>& cut, Ranks& ranks) : cut_(cut), ranks_(ranks) {}

    Outcome<SharedRows<D>> join() {
        SharedNumbers<D> shared(cut_, ranks_);
        if (auto found = shared.find_owners(); !found) return fail(found.error());
        JoinedVertices<D> vertices(cut_, shared);
        const auto counts = gather_all(ranks_, Outcome<std::vector<std::size_t>>({vertices.own()}));
        if (!counts) return fail(counts.error());
        out_.first_vertices = {0};
        for (const std::size_t n : *counts) out_.first_vertices.push_back(out_.first_vertices.back() + n);
        if (out_.first_vertices.back() > max_entities)
            return fail(ErrorKind::unsupported, "there are more vertices than 32 bits can number");
        for (AdaptationRows<D>& part : cut_.parts) put(std::exchange(part, {}), vertices);
        const std::size_t first = out_.first_vertices[ranks_.rank()];
        const auto now = shared.numbers_now([&](std::size_t i) { return VertexId(first + vertices.row(i).index()); });
        if (!now) return fail(now.error());
        vertices.move_into(out_, first, *now);
        if (auto kept = keep_first(out_, out_.rows.facets, between_, ranks_); !kept) return fail(kept.error());
        if (auto kept = keep_first(out_, out_.rows.lines, lines_between_, ranks_); !kept) return fail(kept.error());
        out_.aside = std::move(cut_.aside);
        for (AdaptedVertex<D>& v : out_.aside.vertices)
            if (v.number.valid()) v.number = (*now)[shared.at(v.number)];
        return std::move(out_);
    }

  private:
    void put(const AdaptationRows<D>& part, JoinedVertices<D>& vertices) {
        const std::vector<VertexId> ids = vertices.take(part);
        const auto named = [&](auto simplex) {
            for (VertexId& v : simplex.vertices) v = ids[v.index()];
            return simplex;
        };
        for (const auto& element : part.elements) out_.rows.elements.push_back(named(element));
        for (const auto& facet : part.facets) {
            auto simplex = named(facet);
            const bool is_between = facet.marks.has(Mark::frozen);
            if (is_between && !is_first(simplex.vertices, facets_)) continue;
            if (is_between) simplex.marks = thawed(simplex.marks);
            if (is_between) between_.push_back(static_cast<std::uint32_t>(out_.rows.facets.size()));
            out_.rows.facets.push_back(simplex);
        }
        for (const auto& line : part.lines) {
            const auto simplex = named(line);
            const bool may_be_between =
                std::ranges::all_of(line.vertices, [&](VertexId v) { return part.vertices[v.index()].number.valid(); });
            if (may_be_between && !is_first(simplex.vertices, lines_)) continue;
            if (may_be_between) lines_between_.push_back(static_cast<std::uint32_t>(out_.rows.lines.size()));
            out_.rows.lines.push_back(simplex);
        }
    }
    template <std::size_t N>
    [[nodiscard]] static bool is_first(std::array<VertexId, N> simplex, std::set<std::array<VertexId, N>>& seen) {
        std::ranges::sort(simplex);
        return seen.insert(simplex).second;
    }

    CutMesh<D>& cut_;
    Ranks& ranks_;
    SharedRows<D> out_;
    std::set<std::array<VertexId, D>> facets_;
    std::set<std::array<VertexId, 2>> lines_;
    std::vector<std::uint32_t> between_, lines_between_;  ///< rows that other ranks may have too
};

}  // namespace

template <int D>
Outcome<SharedRows<D>> joined(CutMesh<D> cut, Ranks& ranks) {
    return guarded([&]() -> Outcome<SharedRows<D>> { return Joining<D>(cut, ranks).join(); });
}

#define CAMBER_INSTANTIATE(D) template Outcome<SharedRows<D>> joined<D>(CutMesh<D>, Ranks&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
