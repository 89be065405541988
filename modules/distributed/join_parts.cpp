// Joins parts to a shared mesh, and makes the rows of the finished mesh.
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
import camber.metric;
import camber.io;
import camber.operation;

namespace camber {

namespace {

/// Vertices that were in the mesh before the cut, by their former numbers, with their owners and new numbers.
template <int D>
class SharedNumbers {
  public:
    SharedNumbers(const CutMesh<D>& cut, Ranks& ranks) : first_vertices_(cut.first_vertices), ranks_(ranks) {
        const auto add_numbers = [&](const AdaptationRows<D>& part) {
            for (const AdaptedVertex<D>& v : part.vertices)
                if (v.number.valid()) numbers_.push_back(v.number);
        };
        std::ranges::for_each(cut.parts, add_numbers);
        add_numbers(cut.without_elements);
        std::ranges::sort(numbers_);
        numbers_.erase(std::ranges::unique(numbers_).begin(), numbers_.end());
    }

    Outcome<Done> find_owners() {
        std::vector<std::vector<VertexId>> to(ranks_.size());
        for (const VertexId number : numbers_) to[rank_with(first_vertices_, number.index())].push_back(number);
        const auto requests = exchanged_lists(ranks_, std::move(to));
        if (!requests) return fail(requests.error());
        const std::size_t first = first_vertices_[ranks_.rank()];
        const auto none = static_cast<std::uint32_t>(ranks_.size());
        Buffer<std::uint32_t> owners(first_vertices_[ranks_.rank() + 1] - first, none);
        for (std::size_t r = 0; r < requests->size(); ++r)
            for (const VertexId number : (*requests)[r]) {
                std::uint32_t& owner = owners[number.index() - first];
                owner = std::min(owner, static_cast<std::uint32_t>(r));
            }
        std::vector<std::vector<std::uint32_t>> answers(ranks_.size());
        for (std::size_t r = 0; r < requests->size(); ++r)
            for (const VertexId number : (*requests)[r]) answers[r].push_back(owners[number.index() - first]);
        auto replies = exchanged_values<std::uint32_t>(ranks_, std::move(answers));
        if (!replies) return fail(replies.error());
        owners_ = std::move(*replies);
        return Done{};
    }
    Outcome<Buffer<VertexId>> numbers_now(const auto& now) {
        std::vector<std::vector<VertexId>> to(ranks_.size());
        for (std::size_t i = 0; i < numbers_.size(); ++i) to[owners_[i]].push_back(numbers_[i]);
        auto requests = exchanged_lists(ranks_, std::move(to));
        if (!requests) return fail(requests.error());
        for (auto& some : *requests)
            for (VertexId& number : some) number = now(at(number));
        const auto replies = exchanged_lists(ranks_, std::move(*requests));
        if (!replies) return fail(replies.error());
        std::vector<std::size_t> next(ranks_.size(), 0);
        Buffer<VertexId> numbers(numbers_.size());
        for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = (*replies)[owners_[i]][next[owners_[i]]++];
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
    std::vector<VertexId> numbers_;
    std::vector<std::uint32_t> owners_;
};

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

    std::vector<VertexId> take(const AdaptationRows<D>& part) {
        std::vector<VertexId> rows;
        rows.reserve(part.vertices.size());
        for (const AdaptedVertex<D>& v : part.vertices) rows.push_back(v.number.valid() ? put_shared(v) : put(v, 0));
        return rows;
    }
    [[nodiscard]] VertexId row(std::size_t shared) const { return rows_[shared]; }

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
    Buffer<VertexId> rows_;
    Buffer<AdaptedVertex<D>> out_, others_;
    Buffer<std::uint8_t> on_rim_;
};

template <int D, int K>
Outcome<Done> select_first(SharedRows<D>& out, Buffer<AdaptedSimplex<K>>& simplices,
                           const std::vector<std::uint32_t>& shared, Ranks& ranks) {
    if (ranks.size() == 1) return Done{};
    std::vector<SimplexVertices<K>> numbers;
    for (const std::uint32_t i : shared) {
        SimplexVertices<K> one = simplices[i].vertices;
        for (VertexId& v : one) v = out.rows.vertices[v.index()].number;
        std::ranges::sort(one);
        numbers.push_back(one);
    }
    const auto selected = are_first(numbers, out.first_vertices, ranks);
    if (!selected) return fail(selected.error());
    std::size_t end = 0;
    for (std::size_t i = 0, s = 0; i < simplices.size(); ++i) {
        const bool is_shared = s < shared.size() && shared[s] == i;
        if (is_shared && (*selected)[s++] == 0) continue;
        simplices[end++] = simplices[i];
    }
    simplices.resize(end);
    return Done{};
}

Marks unfrozen_marks(Marks marks) {
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
            return fail(ErrorKind::unsupported, "the mesh has more vertices than 32 bits can number");
        for (AdaptationRows<D>& part : cut_.parts) put(std::exchange(part, {}), vertices);
        const std::size_t first = out_.first_vertices[ranks_.rank()];
        const auto now = shared.numbers_now([&](std::size_t i) { return VertexId(first + vertices.row(i).index()); });
        if (!now) return fail(now.error());
        vertices.move_into(out_, first, *now);
        if (auto selected = select_first(out_, out_.rows.facets, between_, ranks_); !selected)
            return fail(selected.error());
        if (auto selected = select_first(out_, out_.rows.lines, lines_between_, ranks_); !selected)
            return fail(selected.error());
        out_.without_elements = std::move(cut_.without_elements);
        for (AdaptedVertex<D>& v : out_.without_elements.vertices)
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
            if (is_between) simplex.marks = unfrozen_marks(simplex.marks);
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
    [[nodiscard]] static bool is_first(std::array<VertexId, N> simplex, std::set<std::array<VertexId, N>>& visited) {
        std::ranges::sort(simplex);
        return visited.insert(simplex).second;
    }

    CutMesh<D>& cut_;
    Ranks& ranks_;
    SharedRows<D> out_;
    std::set<std::array<VertexId, D>> facets_;
    std::set<std::array<VertexId, 2>> lines_;
    std::vector<std::uint32_t> between_, lines_between_;
};

}  // namespace

template <int D>
Outcome<SharedRows<D>> joined(CutMesh<D> cut, Ranks& ranks) {
    return guarded([&]() -> Outcome<SharedRows<D>> { return Joining<D>(cut, ranks).join(); });
}

namespace {

struct PreservedVertex {
    VertexId origin, now;
    Marks marks;
};

template <int D>
class TransferredGeometry {
  public:
    TransferredGeometry(std::size_t vertices, const std::vector<PreservedVertex>& there)
        : now_(vertices), marks_(vertices) {
        for (const PreservedVertex& one : there) {
            now_[one.origin.index()] = one.now;
            marks_[one.origin.index()] = one.marks;
        }
    }
    [[nodiscard]] InputGeometry<D> of(const InputGeometry<D>& original) const {
        return {directions(original.normals), directions(original.tangents), associations(original.on_points),
                associations(original.on_curves), associations(original.on_surfaces)};
    }

  private:
    [[nodiscard]] DirectionsAtVertices<D> directions(const DirectionsAtVertices<D>& original) const {
        Buffer<DirectionRow> at;
        for (const DirectionRow& row : original.at)
            if (const VertexId v = now_[row.vertex.index()]; v.valid() && !has_moved(row.vertex))
                at.push_back({v, row.row});
        return {original.table, std::move(at)};
    }
    template <int G>
    [[nodiscard]] Column<Association<G>> associations(const Column<Association<G>>& original) const {
        Buffer<Association<G>> out;
        for (Association<G> on : original) {
            const VertexId v = now_[on.item.index()];
            if (!v.valid() || (has_moved(on.item) && G < D - 1)) continue;
            if (has_moved(on.item)) on.parameters = {}, on.distance = {};
            on.item = v;
            out.push_back(on);
        }
        return out;
    }
    [[nodiscard]] bool has_moved(VertexId origin) const { return marks_[origin.index()].has(Mark::moved); }

    Buffer<VertexId> now_;
    Buffer<Marks> marks_;
};

template <int D>
class Finishing {
  public:
    explicit Finishing(Ranks& ranks) : ranks_(ranks) {}

    Outcome<FinishedRows<D>> finish(AdaptationRows<D> rows, const InitialGeometry<D>& original) {
        auto lines = std::move(rows.lines);
        std::erase_if(lines, [](const AdaptedSimplex<1>& l) { return is_unlisted(l.marks); });
        for (AdaptedSimplex<1>& line : lines) std::ranges::sort(line.vertices);
        auto& [part, totals, lists] = out_;
        if (auto done = begin_at(rows.vertices.size(), part.vertices.first, totals.vertices); !done)
            return fail(done.error());
        if (auto done = put(rows.elements, part.elements, totals.elements, lists.elements.required); !done)
            return fail(done.error());
        if (auto done = put(rows.facets, part.facets, totals.facets, lists.facets.required); !done)
            return fail(done.error());
        if constexpr (D == 3) {
            if (auto done = put(lines, part.edges, totals.edges, lists.edges.required); !done)
                return fail(done.error());
            auto ridges = listed(lines, part.edges.first, [](Marks m) { return !m.has(Mark::embedded); });
            if (!ridges) return fail(ridges.error());
            lists.ridges = std::move(*ridges);
        } else {
            auto ridges = listed(rows.facets, part.facets.first, [](Marks m) { return m.has(Mark::ridge); });
            if (!ridges) return fail(ridges.error());
            lists.ridges = std::move(*ridges);
        }
        if (auto done = put_vertices(rows.vertices, original); !done) return fail(done.error());
        lists.groups = original.groups;
        return std::move(out_);
    }

  private:
    [[nodiscard]] static bool is_unlisted(Marks m) { return m.has(Mark::embedded) && m.has(Mark::implied); }

    Outcome<Done> begin_at(std::size_t own, std::uint64_t& first, std::uint64_t& total) {
        const auto count = counted(ranks_, own);
        if (!count) return fail(count.error());
        first = count->before;
        total = count->all;
        return Done{};
    }
    template <int K>
    Outcome<Done> put(const Buffer<AdaptedSimplex<K>>& rows, SimplexRun<K, 1>& run, std::uint64_t& total,
                      Column<std::uint32_t>& required) {
        if (auto done = begin_at(rows.size(), run.first, total); !done) return done;
        run.nodes.reserve(rows.size());
        run.references.reserve(rows.size());
        for (const AdaptedSimplex<K>& row : rows) {
            auto& nodes = run.nodes.emplace_back();
            for (std::size_t v = 0; v < nodes.size(); ++v) nodes[v] = row.vertices[v].value;
            run.references.push_back(row.reference);
        }
        auto are = listed(rows, run.first, [](Marks m) { return m.has(Mark::required); });
        if (!are) return fail(are.error());
        required = std::move(*are);
        return Done{};
    }
    Outcome<Buffer<std::uint32_t>> listed(const auto& rows, std::uint64_t first, const auto& is_listed) {
        std::vector<std::uint32_t> own;
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (is_listed(rows[i].marks)) own.push_back(static_cast<std::uint32_t>(first + i));
        return gather_all(ranks_, Outcome<std::vector<std::uint32_t>>(std::move(own))).map([](const auto& all) {
            return Buffer<std::uint32_t>(all.begin(), all.end());
        });
    }
    Outcome<Done> put_vertices(const Buffer<AdaptedVertex<D>>& rows, const InitialGeometry<D>& original) {
        PointRun<D>& run = out_.part.vertices;
        std::vector<VertexId> corners, required;
        std::vector<PreservedVertex> there;
        run.points.reserve(rows.size());
        run.references.reserve(rows.size());
        for (const AdaptedVertex<D>& v : rows) {
            run.points.push_back(v.point);
            run.references.push_back(v.reference);
            const Marks marks = v.state.marks;
            if (v.state.place == VertexPlace::corner || marks.has(Mark::corner)) corners.push_back(v.number);
            if (marks.has(Mark::required)) required.push_back(v.number);
            if (v.origin.valid() && marks.has(Mark::has_input_data)) there.push_back({v.origin, v.number, marks});
        }
        const auto all_corners = gather_all(ranks_, Outcome<std::vector<VertexId>>(std::move(corners)));
        if (!all_corners) return fail(all_corners.error());
        const auto all_required = gather_all(ranks_, Outcome<std::vector<VertexId>>(std::move(required)));
        if (!all_required) return fail(all_required.error());
        const auto all_preserved = gather_all(ranks_, Outcome<std::vector<PreservedVertex>>(std::move(there)));
        if (!all_preserved) return fail(all_preserved.error());
        out_.lists.corners = Buffer<VertexId>(all_corners->begin(), all_corners->end());
        out_.lists.required_vertices = Buffer<VertexId>(all_required->begin(), all_required->end());
        out_.lists.geometry = TransferredGeometry<D>(original.vertices, *all_preserved).of(original.geometry);
        return Done{};
    }

    Ranks& ranks_;
    FinishedRows<D> out_;
};

using EdgeRows = std::vector<std::array<VertexId, 2>>;
template <int D>
EdgeRows edges_on_rank(const AdaptationRows<D>& rows) {
    EdgeRows edges;
    edges.reserve(rows.elements.size() * local_edges<D>.size());
    for (const AdaptedSimplex<D>& element : rows.elements)
        for (const auto& [a, b] : local_edges<D>) {
            VertexId u = element.vertices[a], v = element.vertices[b];
            if (rows.vertices[v.index()].number < rows.vertices[u.index()].number) std::swap(u, v);
            edges.push_back({u, v});
        }
    std::ranges::sort(edges);
    edges.erase(std::ranges::unique(edges).begin(), edges.end());
    return edges;
}

template <int D>
Outcome<EdgeRows> own_edges(const SharedRows<D>& shared, Ranks& ranks) {
    EdgeRows edges = edges_on_rank(shared.rows);
    if (ranks.size() == 1) return edges;
    const auto may_be_shared = [&](const std::array<VertexId, 2>& e) {
        return shared.on_rim[e[0].index()] != 0 && shared.on_rim[e[1].index()] != 0;
    };
    EdgeRows numbers;
    for (const auto& e : edges)
        if (may_be_shared(e))
            numbers.push_back({shared.rows.vertices[e[0].index()].number, shared.rows.vertices[e[1].index()].number});
    const auto first = are_first(numbers, shared.first_vertices, ranks);
    if (!first) return fail(first.error());
    std::size_t next = 0;
    std::erase_if(edges, [&](const auto& e) { return may_be_shared(e) && (*first)[next++] == 0; });
    return edges;
}

}  // namespace

template <int D>
Outcome<FinishedRows<D>> finished_rows(SharedRows<D> shared, const InitialGeometry<D>& original, Ranks& ranks) {
    return guarded([&]() -> Outcome<FinishedRows<D>> {
        return Finishing<D>(ranks).finish(numbered_rows(std::move(shared), ranks), original);
    });
}

template <int D>
Outcome<MeasuredRows> measured_rows(const SharedRows<D>& shared, Ranks& ranks, const Execution& execution) {
    return guarded([&]() -> Outcome<MeasuredRows> {
        const AdaptationRows<D>& rows = shared.rows;
        const auto at = [&](VertexId v) -> const AdaptedVertex<D>& { return rows.vertices[v.index()]; };
        const auto edges = own_edges(shared, ranks);
        if (!edges) return fail(edges.error());
        const auto lengths = map_each(execution, edges->size(), [&](std::size_t e) {
            const AdaptedVertex<D>&a = at((*edges)[e][0]), &b = at((*edges)[e][1]);
            return edge_length(a.metric.measure, b.metric.measure, b.point - a.point);
        });
        if (!lengths) return fail(lengths.error());
        const auto qualities = map_each(execution, rows.elements.size(), [&](std::size_t e) {
            std::array<Vec<D>, D + 1> corners;
            std::array<const MeasuringMetric<D>*, D + 1> metrics{};
            for (int i = 0; i <= D; ++i) {
                corners[i] = at(rows.elements[e].vertices[i]).point;
                metrics[i] = &at(rows.elements[e].vertices[i]).metric.measure;
            }
            return metric_quality<D>(corners, metrics);
        });
        if (!qualities) return fail(qualities.error());
        return MeasuredRows{{lengths->begin(), lengths->end()}, {qualities->begin(), qualities->end()}};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Outcome<SharedRows<D>> joined<D>(CutMesh<D>, Ranks&);                                        \
    template Outcome<FinishedRows<D>> finished_rows<D>(SharedRows<D>, const InitialGeometry<D>&, Ranks&); \
    template Outcome<MeasuredRows> measured_rows<D>(const SharedRows<D>&, Ranks&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
