module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import :adaptation_rows;
import :packing;
import :ranks;
import :row_runs;
import :shared_rows;

namespace camber {

namespace {

template <int D>
bool is_frozen(const AdaptationRows<D>& rows, VertexId v) {
    return rows.vertices[v.index()].state.marks.has(Mark::frozen);
}

/// Lines on no element: their ends are frozen.
template <int D>
std::set<std::array<VertexId, 2>> loose_lines(const AdaptationRows<D>& whole) {
    std::set<std::array<VertexId, 2>> loose;
    for (const AdaptedSimplex<1>& line : whole.lines)
        if (is_frozen(whole, line.vertices[0]) && is_frozen(whole, line.vertices[1]))
            loose.insert({std::ranges::min(line.vertices), std::ranges::max(line.vertices)});
    if (loose.empty()) return loose;
    for (const AdaptedSimplex<D>& element : whole.elements)
        for (const auto& [a, b] : local_edges<D>) {
            const VertexId u = element.vertices[a], v = element.vertices[b];
            if (is_frozen(whole, u) && is_frozen(whole, v)) loose.erase({std::min(u, v), std::max(u, v)});
        }
    return loose;
}

/// A mesh as a whole in two: what is of elements, and the rest.
template <int D>
class Sharing {
  public:
    Sharing(const AdaptationRows<D>& whole, const Ranks& ranks)
        : whole_(whole), ranks_(ranks), loose_(loose_lines(whole)), ids_(whole.vertices.size(), VertexId{}) {
        number_vertices();
    }

    [[nodiscard]] SharedRows<D> share() {
        SharedRows<D> out;
        for (std::size_t r = 0; r <= ranks_.size(); ++r) out.first_vertices.push_back(of_.size() * r / ranks_.size());
        put_run(whole_.elements, out.rows.elements, [](const auto&) { return true; });
        put_run(whole_.facets, out.rows.facets, [](const auto& facet) { return facet.sides > 0; });
        put_run(whole_.lines, out.rows.lines, [&](const auto& line) { return !is_loose(line); });
        put_vertices(out);
        if (ranks_.rank() + 1 == ranks_.size()) put_aside(out.aside);
        return out;
    }

  private:
    void number_vertices() {
        number_.assign(whole_.vertices.size(), VertexId{});
        for (const auto& element : whole_.elements)
            for (const VertexId v : element.vertices) number_[v.index()] = v;
        for (std::size_t v = 0; v < number_.size(); ++v)
            if (number_[v].valid()) {
                number_[v] = VertexId(of_.size());
                of_.emplace_back(v);
            }
    }
    [[nodiscard]] bool is_loose(const AdaptedSimplex<1>& line) const {
        return loose_.contains({std::ranges::min(line.vertices), std::ranges::max(line.vertices)});
    }
    template <int K>
    void put_run(const Buffer<AdaptedSimplex<K>>& from, Buffer<AdaptedSimplex<K>>& to, const auto& is_shared) const {
        const Run own = part_of({0, from.size()}, ranks_.rank(), ranks_.size());
        for (std::size_t i = own.begin; i < own.end; ++i)
            if (is_shared(from[i])) to.push_back(from[i]);
    }
    [[nodiscard]] AdaptedVertex<D> vertex(VertexId v) const {
        AdaptedVertex<D> row = whole_.vertices[v.index()];
        row.number = number_[v.index()];
        return row;
    }
    void put_vertices(SharedRows<D>& out) {
        AdaptationRows<D>& rows = out.rows;
        const std::size_t first = out.first_vertices[ranks_.rank()], last = out.first_vertices[ranks_.rank() + 1];
        std::vector<VertexId> named(of_.begin() + static_cast<std::ptrdiff_t>(first),
                                    of_.begin() + static_cast<std::ptrdiff_t>(last));
        for (const VertexId v : named) ids_[v.index()] = v;
        const auto name = [&](const auto& simplices) {
            for (const auto& simplex : simplices)
                for (const VertexId v : simplex.vertices)
                    if (!std::exchange(ids_[v.index()], v).valid()) named.push_back(v);
        };
        name(rows.elements);
        name(rows.facets);
        name(rows.lines);
        std::ranges::sort(named.begin() + static_cast<std::ptrdiff_t>(last - first), named.end());
        put_named(named, rows);
        out.on_rim.assign(named.size(), 1);
    }
    void put_named(const std::vector<VertexId>& named, AdaptationRows<D>& rows) {
        rows.vertices.reserve(named.size());
        for (const VertexId v : named) {
            ids_[v.index()] = VertexId(rows.vertices.size());
            rows.vertices.push_back(vertex(v));
        }
        const auto rename = [&](auto& simplices) {
            for (auto& simplex : simplices)
                for (VertexId& v : simplex.vertices) v = ids_[v.index()];
        };
        rename(rows.elements);
        rename(rows.facets);
        rename(rows.lines);
    }
    void put_aside(AdaptationRows<D>& aside) {
        for (const auto& facet : whole_.facets)
            if (facet.sides == 0) aside.facets.push_back(facet);
        for (const auto& line : whole_.lines)
            if (is_loose(line)) aside.lines.push_back(line);
        std::vector<VertexId> named;
        for (std::size_t v = 0; v < number_.size(); ++v)
            if (!number_[v].valid()) named.emplace_back(v);
        for (const auto& facet : aside.facets) named.insert(named.end(), facet.vertices.begin(), facet.vertices.end());
        for (const auto& line : aside.lines) named.insert(named.end(), line.vertices.begin(), line.vertices.end());
        std::ranges::sort(named);
        named.erase(std::ranges::unique(named).begin(), named.end());
        put_named(named, aside);
    }

    const AdaptationRows<D>& whole_;
    const Ranks& ranks_;
    std::set<std::array<VertexId, 2>> loose_;
    Buffer<VertexId> number_;  ///< of each vertex; none: it is of no element
    Buffer<VertexId> of_;      ///< the vertex of each number
    Buffer<VertexId> ids_;     ///< of each vertex, among those that are put
};

/// Simplices by the numbers of their vertices.
template <int D>
void name_by_numbers(AdaptationRows<D>& rows) {
    const auto rename = [&](auto& simplices) {
        for (auto& simplex : simplices)
            for (VertexId& v : simplex.vertices) v = rows.vertices[v.index()].number;
    };
    rename(rows.elements);
    rename(rows.facets);
    rename(rows.lines);
}

template <int D>
void append_simplices(const AdaptationRows<D>& rows, AdaptationRows<D>& whole) {
    whole.elements.insert(whole.elements.end(), rows.elements.begin(), rows.elements.end());
    whole.facets.insert(whole.facets.end(), rows.facets.begin(), rows.facets.end());
    whole.lines.insert(whole.lines.end(), rows.lines.begin(), rows.lines.end());
}

template <int D>
void append(AdaptationRows<D> rows, AdaptationRows<D>& whole) {
    whole.vertices.insert(whole.vertices.end(), rows.vertices.begin(), rows.vertices.end());
    append_simplices(rows, whole);
}

}  // namespace

template <int D>
Outcome<SharedRows<D>> share_of(const AdaptationRows<D>& whole, const Ranks& ranks) {
    return guarded([&]() -> Outcome<SharedRows<D>> { return Sharing<D>(whole, ranks).share(); });
}

template <int D>
AdaptationRows<D> numbered_rows(SharedRows<D> shared, const Ranks& ranks) {
    name_by_numbers(shared.rows);
    shared.rows.vertices.resize(shared.own_vertices(ranks));
    std::size_t next = shared.vertices();
    for (AdaptedVertex<D>& v : shared.aside.vertices)
        if (!v.number.valid()) {  // only the last rank has any
            v.number = VertexId(next++);
            shared.rows.vertices.push_back(v);
        }
    name_by_numbers(shared.aside);
    append_simplices(shared.aside, shared.rows);
    return std::move(shared.rows);
}

template <int D>
Outcome<AdaptationRows<D>> gathered(SharedRows<D> shared, Ranks& ranks) {
    return guarded([&]() -> Outcome<AdaptationRows<D>> {
        AdaptationRows<D> own = numbered_rows(std::move(shared), ranks);
        if (ranks.size() == 1) return own;
        std::vector<Bytes> to(ranks.size());
        for (std::size_t r = 0; r < to.size(); ++r)
            if (r != ranks.rank()) to[r] = packed_rows(own);
        auto from = ranks.exchange(std::move(to));
        if (!from) return fail(from.error());
        AdaptationRows<D> whole;
        for (std::size_t r = 0; r < from->size(); ++r) {
            const Bytes bytes = std::exchange((*from)[r], {});
            append(r == ranks.rank() ? std::exchange(own, {}) : unpacked_rows<AdaptationRows<D>>(bytes), whole);
        }
        return whole;
    });
}

Outcome<Counted> counted(Ranks& ranks, std::size_t own) {
    const auto counts = gather_all(ranks, Outcome<std::vector<std::size_t>>({own}));
    if (!counts) return fail(counts.error());
    const auto here = counts->begin() + static_cast<std::ptrdiff_t>(ranks.rank());
    return Counted{std::accumulate(counts->begin(), counts->end(), std::size_t{0}),
                   std::accumulate(counts->begin(), here, std::size_t{0})};
}

#define CAMBER_INSTANTIATE(D)                                                            \
    template Outcome<SharedRows<D>> share_of<D>(const AdaptationRows<D>&, const Ranks&); \
    template AdaptationRows<D> numbered_rows<D>(SharedRows<D>, const Ranks&);            \
    template Outcome<AdaptationRows<D>> gathered<D>(SharedRows<D>, Ranks&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
