// Converts an adapted mesh to plain rows: whole, in parts, or shared among ranks.
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
import camber.metric;
import camber.surface;
import camber.operation;

namespace camber {

namespace {

template <int D>
class Rows {
  public:
    explicit Rows(const Adaptation<D>& r) : r_(r) {}

    void vertices(AdaptationRows<D>& out, const auto& row) {
        ids_.assign(r_.mesh.points.size(), VertexId{});
        out.vertices.reserve(r_.mesh.vertex_count());
        for (std::size_t v = 0; v < ids_.size(); ++v) {
            if (r_.mesh.is_free(VertexId(v))) continue;
            ids_[v] = VertexId(out.vertices.size());
            out.vertices.push_back(row(VertexId(v)));
        }
    }
    void elements(AdaptationRows<D>& out) const { simplices<D, ElementId>(r_.mesh.elements, out.elements); }
    void facets(AdaptationRows<D>& out) const {
        simplices<D - 1, FacetId>(r_.mesh.facets, out.facets);
        for (std::size_t f = 0, row = 0; f < r_.mesh.facets.size(); ++f) {
            if (r_.mesh.is_free(FacetId(f))) continue;
            const auto valid = std::ranges::count_if(r_.mesh.sides[f], [](ElementId e) { return e.valid(); });
            out.facets[row++].sides = static_cast<std::uint8_t>(valid);
        }
    }
    void lines(AdaptationRows<D>& out, std::size_t first, std::size_t last) const {
        const DynamicMesh<D>& mesh = r_.mesh;
        for (std::size_t l = 0; l < mesh.lines.size(); ++l) {
            if (mesh.is_free(LineId(l)) || (l >= first && l < last)) continue;
            out.lines.push_back(
                {named(mesh.edges[mesh.lines[l]]), mesh.line_references[l], mesh.line_entities[l], mesh.line_marks[l]});
        }
    }
    [[nodiscard]] AdaptedVertex<D> vertex(VertexId v) const {
        return {.number = {},
                .origin = {},
                .point = r_.mesh.points[v],
                .reference = r_.mesh.point_references[v],
                .state = r_.mesh.states[v],
                .is_off_geometry = false,
                .metric = r_.vertices.metrics[v],
                .place = r_.vertices.place(v)};
    }

  private:
    template <std::size_t N>
    [[nodiscard]] std::array<VertexId, N> named(std::array<VertexId, N> simplex) const {
        for (VertexId& v : simplex) v = ids_[v.index()];
        return simplex;
    }
    template <int K, class Id>
    void simplices(const DynamicSimplices<K>& from, Buffer<AdaptedSimplex<K>>& out) const {
        out.reserve(from.size());
        for (std::size_t i = 0; i < from.size(); ++i)
            if (!r_.mesh.is_free(Id(i)))
                out.push_back({named(from.vertices[i]), from.references[i],
                               from.entities.empty() ? 0 : from.entities[i], from.marks[i]});
    }

    const Adaptation<D>& r_;
    Buffer<VertexId> ids_;
};

template <int D>
Buffer<std::uint8_t> off_geometry(const Adaptation<D>& r) {
    Buffer<std::uint8_t> is_off(r.mesh.points.size(), 0);
    for (const VertexId v : r.off_geometry)
        if (v.index() < is_off.size()) is_off[v.index()] = 1;
    return is_off;
}

template <int K>
Simplices<K> simplices_of(const Buffer<AdaptedSimplex<K>>& rows) {
    Buffer<SimplexVertices<K>> vertices(rows.size());
    Buffer<Reference> references(rows.size()), entities(rows.size());
    Buffer<std::uint32_t> required;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        vertices[i] = rows[i].vertices;
        references[i] = rows[i].reference;
        entities[i] = rows[i].entity;
        if (rows[i].marks.has(Mark::required)) required.push_back(static_cast<std::uint32_t>(i));
    }
    if (std::ranges::all_of(entities, [](Reference e) { return e == 0; })) entities.clear();
    return {std::move(vertices), std::move(references), std::move(required), std::move(entities)};
}
template <int K>
Buffer<Marks> marks_of(const Buffer<AdaptedSimplex<K>>& rows) {
    Buffer<Marks> marks(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) marks[i] = rows[i].marks;
    return marks;
}

template <int D>
MeshPart<D> mesh_part_of(const AdaptationRows<D>& rows) {
    MeshPart<D> part;
    const std::size_t n = rows.vertices.size();
    Buffer<Vec<D>> points(n);
    Buffer<Reference> references(n);
    Buffer<VertexState> states(n);
    for (std::size_t v = 0; v < n; ++v) {
        points[v] = rows.vertices[v].point;
        references[v] = rows.vertices[v].reference;
        states[v] = rows.vertices[v].state;
    }
    part.mesh.points = std::move(points);
    part.mesh.point_references = std::move(references);
    part.states = std::move(states);
    part.mesh.elements = simplices_of(rows.elements);
    part.mesh.facets = simplices_of(rows.facets);
    part.facet_marks = marks_of(rows.facets);
    if constexpr (D == 3) {
        part.mesh.edges = simplices_of(rows.lines);
        part.line_marks = marks_of(rows.lines);
    }
    return part;
}

}  // namespace

template <int D>
Outcome<AdaptationRows<D>> rows_of(const Adaptation<D>& whole) {
    return guarded([&]() -> Outcome<AdaptationRows<D>> {
        AdaptationRows<D> out;
        Rows<D> rows(whole);
        const auto is_off = off_geometry(whole);
        rows.vertices(out, [&](VertexId v) {
            AdaptedVertex<D> row = rows.vertex(v);
            row.number = VertexId(out.vertices.size());
            if (row.state.marks.has(Mark::has_input_data)) row.origin = v;
            row.is_off_geometry = is_off[v.index()] != 0;
            return row;
        });
        rows.elements(out);
        rows.facets(out);
        rows.lines(out, 0, 0);
        return out;
    });
}

template <int D>
Outcome<AdaptedPart<D>> assembled(const AdaptationRows<D>& rows, const Execution& execution) {
    return guarded([&]() -> Outcome<AdaptedPart<D>> {
        auto result = make_dynamic_part(mesh_part_of(rows), execution);
        if (!result) return fail(result.error());
        const std::size_t n = rows.vertices.size();
        Buffer<VertexMetric<D>> metrics(n);
        Buffer<GeometryPosition> places(n);
        Buffer<VertexId> off;
        for (std::size_t v = 0; v < n; ++v) {
            metrics[v] = rows.vertices[v].metric;
            places[v] = rows.vertices[v].place;
            if (rows.vertices[v].is_off_geometry && result->on_rim[v] == 0) off.emplace_back(v);
        }
        const std::size_t rim_lines = result->mesh.lines.size() - rows.lines.size();
        AdaptedPart<D> part{{std::move(result->mesh), {std::move(metrics)}}, std::move(result->on_rim), rim_lines};
        part.state.vertices.places = std::move(places);
        part.state.off_geometry = std::move(off);
        part.state.walls = facet_grid_of(part.state.mesh);
        return part;
    });
}

template <int D>
Outcome<AdaptationRows<D>> rows_of_part(const AdaptedPart<D>& part, const AdaptationRows<D>& before) {
    return guarded([&]() -> Outcome<AdaptationRows<D>> {
        AdaptationRows<D> out;
        Rows<D> rows(part.state);
        const auto is_off = off_geometry(part.state);
        rows.vertices(out, [&](VertexId v) {
            const bool existed = v.index() < before.vertices.size();
            if (existed && part.on_rim[v] != 0) return before.vertices[v.index()];
            AdaptedVertex<D> row = rows.vertex(v);
            if (existed && row.state.marks.has(Mark::has_input_data)) row.origin = before.vertices[v.index()].origin;
            if (existed && row.state.marks.has(Mark::frozen)) row.number = before.vertices[v.index()].number;
            row.is_off_geometry = is_off[v.index()] != 0;
            return row;
        });
        rows.elements(out);
        rows.facets(out);
        rows.lines(out, before.lines.size(), before.lines.size() + part.rim_lines);
        // A facet between two parts is unchanged, so it keeps its marks and sides.
        for (std::size_t f = 0, row = 0; f < before.facets.size(); ++f) {
            if (part.state.mesh.is_free(FacetId(f))) continue;
            if (before.facets[f].marks.has(Mark::frozen)) {
                out.facets[row].marks = before.facets[f].marks;
                out.facets[row].sides = before.facets[f].sides;
            }
            ++row;
        }
        return out;
    });
}

namespace {

template <int D>
bool is_frozen(const AdaptationRows<D>& rows, VertexId v) {
    return rows.vertices[v.index()].state.marks.has(Mark::frozen);
}

/// Lines without elements. Both ends of such a line are frozen.
template <int D>
std::set<std::array<VertexId, 2>> lines_without_elements(const AdaptationRows<D>& whole) {
    std::set<std::array<VertexId, 2>> shared_lines;
    for (const AdaptedSimplex<1>& line : whole.lines)
        if (is_frozen(whole, line.vertices[0]) && is_frozen(whole, line.vertices[1]))
            shared_lines.insert({std::ranges::min(line.vertices), std::ranges::max(line.vertices)});
    if (shared_lines.empty()) return shared_lines;
    for (const AdaptedSimplex<D>& element : whole.elements)
        for (const auto& [a, b] : local_edges<D>) {
            const VertexId u = element.vertices[a], v = element.vertices[b];
            if (is_frozen(whole, u) && is_frozen(whole, v)) shared_lines.erase({std::min(u, v), std::max(u, v)});
        }
    return shared_lines;
}

template <int D>
class Sharing {
  public:
    Sharing(const AdaptationRows<D>& whole, const Ranks& ranks)
        : whole_(whole),
          ranks_(ranks),
          shared_lines_(lines_without_elements(whole)),
          ids_(whole.vertices.size(), VertexId{}) {
        number_vertices();
    }

    [[nodiscard]] SharedRows<D> share() {
        SharedRows<D> out;
        for (std::size_t r = 0; r <= ranks_.size(); ++r) out.first_vertices.push_back(of_.size() * r / ranks_.size());
        put_run(whole_.elements, out.rows.elements, [](const auto&) { return true; });
        put_run(whole_.facets, out.rows.facets, [](const auto& facet) { return facet.sides > 0; });
        put_run(whole_.lines, out.rows.lines, [&](const auto& line) { return !is_shared_line(line); });
        put_vertices(out);
        if (ranks_.rank() + 1 == ranks_.size()) add_without_elements(out.without_elements);
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
    [[nodiscard]] bool is_shared_line(const AdaptedSimplex<1>& line) const {
        return shared_lines_.contains({std::ranges::min(line.vertices), std::ranges::max(line.vertices)});
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
    void add_without_elements(AdaptationRows<D>& without_elements) {
        for (const auto& facet : whole_.facets)
            if (facet.sides == 0) without_elements.facets.push_back(facet);
        for (const auto& line : whole_.lines)
            if (is_shared_line(line)) without_elements.lines.push_back(line);
        std::vector<VertexId> named;
        for (std::size_t v = 0; v < number_.size(); ++v)
            if (!number_[v].valid()) named.emplace_back(v);
        for (const auto& facet : without_elements.facets)
            named.insert(named.end(), facet.vertices.begin(), facet.vertices.end());
        for (const auto& line : without_elements.lines)
            named.insert(named.end(), line.vertices.begin(), line.vertices.end());
        std::ranges::sort(named);
        named.erase(std::ranges::unique(named).begin(), named.end());
        put_named(named, without_elements);
    }

    const AdaptationRows<D>& whole_;
    const Ranks& ranks_;
    std::set<std::array<VertexId, 2>> shared_lines_;
    Buffer<VertexId> number_;
    Buffer<VertexId> of_;
    Buffer<VertexId> ids_;
};

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
    for (AdaptedVertex<D>& v : shared.without_elements.vertices)
        if (!v.number.valid()) {  // such vertices are only on the last rank
            v.number = VertexId(next++);
            shared.rows.vertices.push_back(v);
        }
    name_by_numbers(shared.without_elements);
    append_simplices(shared.without_elements, shared.rows);
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

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Outcome<AdaptationRows<D>> rows_of<D>(const Adaptation<D>&);                                 \
    template Outcome<AdaptedPart<D>> assembled<D>(const AdaptationRows<D>&, const Execution&);            \
    template Outcome<AdaptationRows<D>> rows_of_part<D>(const AdaptedPart<D>&, const AdaptationRows<D>&); \
    template Outcome<SharedRows<D>> share_of<D>(const AdaptationRows<D>&, const Ranks&);                  \
    template AdaptationRows<D> numbered_rows<D>(SharedRows<D>, const Ranks&);                             \
    template Outcome<AdaptationRows<D>> gathered<D>(SharedRows<D>, Ranks&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
