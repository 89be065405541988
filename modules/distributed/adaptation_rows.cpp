module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.metric;
import camber.surface;
import camber.cavity;
import camber.operation;
import :adaptation_rows;

namespace camber {

namespace {

/// What a mesh that changes holds, but for free places; `row(v)` is a vertex's.
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
    /// Without lines [first, last).
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
    Buffer<VertexId> ids_;  ///< the row of each vertex
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
            if (row.state.marks.has(Mark::given)) row.origin = v;
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
        auto made = make_dynamic_part(mesh_part_of(rows), execution);
        if (!made) return fail(made.error());
        const std::size_t n = rows.vertices.size();
        Buffer<VertexMetric<D>> metrics(n);
        Buffer<GeometryPlace> places(n);
        Buffer<VertexId> off;
        for (std::size_t v = 0; v < n; ++v) {
            metrics[v] = rows.vertices[v].metric;
            places[v] = rows.vertices[v].place;
            if (rows.vertices[v].is_off_geometry && made->on_rim[v] == 0) off.emplace_back(v);
        }
        const std::size_t rim_lines = made->mesh.lines.size() - rows.lines.size();
        AdaptedPart<D> part{{std::move(made->mesh), {std::move(metrics)}}, std::move(made->on_rim), rim_lines};
        part.state.vertices.places = std::move(places);
        part.state.off_geometry = std::move(off);
        part.state.walls = walls_of(part.state.mesh);
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
            const bool was_there = v.index() < before.vertices.size();
            if (was_there && part.on_rim[v] != 0) return before.vertices[v.index()];
            AdaptedVertex<D> row = rows.vertex(v);
            if (was_there && row.state.marks.has(Mark::given)) row.origin = before.vertices[v.index()].origin;
            if (was_there && row.state.marks.has(Mark::frozen)) row.number = before.vertices[v.index()].number;
            row.is_off_geometry = is_off[v.index()] != 0;
            return row;
        });
        rows.elements(out);
        rows.facets(out);
        rows.lines(out, before.lines.size(), before.lines.size() + part.rim_lines);
        // What is between two parts is as it was, and where it was.
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

#define CAMBER_INSTANTIATE(D)                                                                  \
    template Outcome<AdaptationRows<D>> rows_of<D>(const Adaptation<D>&);                      \
    template Outcome<AdaptedPart<D>> assembled<D>(const AdaptationRows<D>&, const Execution&); \
    template Outcome<AdaptationRows<D>> rows_of_part<D>(const AdaptedPart<D>&, const AdaptationRows<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
