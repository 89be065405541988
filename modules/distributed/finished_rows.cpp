module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import camber.io;
import camber.metric;
import camber.operation;
import :adaptation_rows;
import :finished_rows;
import :first_of_ranks;
import :ranks;
import :shared_rows;

namespace camber {

namespace {

/// A vertex of the mesh when all began that is there still, and what became of it.
struct StillThere {
    VertexId origin, now;
    Marks marks;
};

/// Directions and associations as compacted (camber.cavity) has them.
template <int D>
class GivenNow {
  public:
    GivenNow(std::size_t vertices, const std::vector<StillThere>& there) : now_(vertices), marks_(vertices) {
        for (const StillThere& one : there) {
            now_[one.origin.index()] = one.now;
            marks_[one.origin.index()] = one.marks;
        }
    }
    [[nodiscard]] GivenGeometry<D> of(const GivenGeometry<D>& given) const {
        return {directions(given.normals), directions(given.tangents), associations(given.on_points),
                associations(given.on_curves), associations(given.on_surfaces)};
    }

  private:
    [[nodiscard]] DirectionsAtVertices<D> directions(const DirectionsAtVertices<D>& given) const {
        Buffer<DirectionRow> at;
        for (const DirectionRow& row : given.at)
            if (const VertexId v = now_[row.vertex.index()]; v.valid() && !has_moved(row.vertex))
                at.push_back({v, row.row});
        return {given.table, std::move(at)};
    }
    template <int G>
    [[nodiscard]] Column<Association<G>> associations(const Column<Association<G>>& given) const {
        Buffer<Association<G>> out;
        for (Association<G> on : given) {
            const VertexId v = now_[on.item.index()];
            if (!v.valid() || (has_moved(on.item) && G < D - 1)) continue;
            if (has_moved(on.item)) on.parameters = {}, on.distance = {};
            on.item = v;
            out.push_back(on);
        }
        return out;
    }
    [[nodiscard]] bool has_moved(VertexId origin) const { return marks_[origin.index()].has(Mark::moved); }

    Buffer<VertexId> now_;  ///< of each vertex when all began
    Buffer<Marks> marks_;
};

/// Runs of rows that follow each other over the ranks, as parts of their file.
template <int D>
class Finishing {
  public:
    explicit Finishing(Ranks& ranks) : ranks_(ranks) {}

    Outcome<FinishedRows<D>> finish(AdaptationRows<D> rows, const GivenOfMesh<D>& given) {
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
        if (auto done = put_vertices(rows.vertices, given); !done) return fail(done.error());
        lists.groups = given.groups;
        return std::move(out_);
    }

  private:
    /// Lines where surfaces break are all listed (`finished`); others if the maker did.
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
    /// Numbers of rows with such marks, of all ranks.
    Outcome<Buffer<std::uint32_t>> listed(const auto& rows, std::uint64_t first, const auto& is_listed) {
        std::vector<std::uint32_t> own;
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (is_listed(rows[i].marks)) own.push_back(static_cast<std::uint32_t>(first + i));
        return gather_all(ranks_, Outcome<std::vector<std::uint32_t>>(std::move(own))).map([](const auto& all) {
            return Buffer<std::uint32_t>(all.begin(), all.end());
        });
    }
    Outcome<Done> put_vertices(const Buffer<AdaptedVertex<D>>& rows, const GivenOfMesh<D>& given) {
        PointRun<D>& run = out_.part.vertices;
        std::vector<VertexId> corners, required;
        std::vector<StillThere> there;
        run.points.reserve(rows.size());
        run.references.reserve(rows.size());
        for (const AdaptedVertex<D>& v : rows) {
            run.points.push_back(v.point);
            run.references.push_back(v.reference);
            const Marks marks = v.state.marks;
            if (v.state.place == VertexPlace::corner || marks.has(Mark::corner)) corners.push_back(v.number);
            if (marks.has(Mark::required)) required.push_back(v.number);
            if (v.origin.valid() && marks.has(Mark::given)) there.push_back({v.origin, v.number, marks});
        }
        const auto all_corners = gather_all(ranks_, Outcome<std::vector<VertexId>>(std::move(corners)));
        if (!all_corners) return fail(all_corners.error());
        const auto all_required = gather_all(ranks_, Outcome<std::vector<VertexId>>(std::move(required)));
        if (!all_required) return fail(all_required.error());
        const auto all_there = gather_all(ranks_, Outcome<std::vector<StillThere>>(std::move(there)));
        if (!all_there) return fail(all_there.error());
        out_.lists.corners = Buffer<VertexId>(all_corners->begin(), all_corners->end());
        out_.lists.required_vertices = Buffer<VertexId>(all_required->begin(), all_required->end());
        out_.lists.geometry = GivenNow<D>(given.vertices, *all_there).of(given.geometry);
        return Done{};
    }

    Ranks& ranks_;
    FinishedRows<D> out_;
};

/// Edges by rows of vertices, the lower number first, each once.
using EdgeRows = std::vector<std::array<VertexId, 2>>;
template <int D>
EdgeRows edges_here(const AdaptationRows<D>& rows) {
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

/// Without those that a lower rank has too.
template <int D>
Outcome<EdgeRows> own_edges(const SharedRows<D>& shared, Ranks& ranks) {
    EdgeRows edges = edges_here(shared.rows);
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
Outcome<FinishedRows<D>> finished_rows(SharedRows<D> shared, const GivenOfMesh<D>& given, Ranks& ranks) {
    return guarded([&]() -> Outcome<FinishedRows<D>> {
        return Finishing<D>(ranks).finish(numbered_rows(std::move(shared), ranks), given);
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

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<FinishedRows<D>> finished_rows<D>(SharedRows<D>, const GivenOfMesh<D>&, Ranks&); \
    template Outcome<MeasuredRows> measured_rows<D>(const SharedRows<D>&, Ranks&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
