module;
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.ordering;
import camber.core;

namespace camber {

namespace {

/// f(row) of all rows.
template <class T, class F>
Outcome<Column<T>> mapped(const Column<T>& rows, F&& f, const Execution& execution) {
    return map_each(execution, rows.size(), [&](std::size_t i) -> T { return f(rows[i]); }).map([](Buffer<T> made) {
        return Column<T>(std::move(made));
    });
}

/// Replaces columns of one mesh, until one fails.
class Columns {
  public:
    explicit Columns(const Execution& execution) : execution_(execution) {}

    template <class T, class EntityId>
    void reorder(Column<T>& rows, const Column<EntityId>& before) {
        put(rows, [&] { return renumbered_rows(rows, before, execution_); });
    }
    template <class T, class F>
    void map(Column<T>& rows, F&& f) {
        put(rows, [&] { return mapped(rows, f, execution_); });
    }
    [[nodiscard]] Outcome<Done> done() && { return std::move(done_); }

  private:
    template <class T, class Make>
    void put(Column<T>& rows, Make&& make) {
        if (!done_) return;
        Outcome<Column<T>> made = make();
        if (made)
            rows = std::move(*made);
        else
            done_ = fail(std::move(made.error()));
    }

    const Execution& execution_;
    Outcome<Done> done_ = Done{};
};

template <int D>
void renumber_geometry(GivenGeometry<D>& geometry, const Column<VertexId>& after, Columns& columns) {
    const auto at_vertex = [&](DirectionRow row) {
        row.vertex = after[row.vertex];
        return row;
    };
    const auto of_item = [&](auto association) {
        association.item = after[association.item];
        return association;
    };
    columns.map(geometry.normals.at, at_vertex);
    columns.map(geometry.tangents.at, at_vertex);
    columns.map(geometry.on_points, of_item);
    columns.map(geometry.on_curves, of_item);
    columns.map(geometry.on_surfaces, of_item);
}

/// Of each edge the one that it was: an element's edges stand in the same turn before and after. What several simplices
/// write to an edge is the same.
template <int D>
Outcome<Buffer<EdgeId>> edges_before(const EdgeSet<D>& before, const EdgeSet<D>& now, const Column<ElementId>& elements,
                                     const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<EdgeId>> {
        Buffer<EdgeId> ids(now.size());
        const auto put = [&](const auto& was, const auto& is) {
            for (std::size_t i = 0; i < is.size(); ++i)
                std::atomic_ref<std::uint32_t>(ids[is[i].index()].value).store(was[i].value, std::memory_order_relaxed);
        };
        auto done = each(execution, now.of_elements.size(),
                         [&](std::size_t e) { put(before.of_elements[elements[e]], now.of_elements[e]); });
        if (!done) return fail(std::move(done.error()));
        for (std::size_t f = 0; f < now.of_facets.size(); ++f) put(before.of_facets[f], now.of_facets[f]);
        put(before.of_edges, now.of_edges);
        return ids;
    });
}

}  // namespace

template <int D>
Outcome<LinearMesh<D>> renumbered(LinearMesh<D> mesh, const Renumbering& renumbering, const Execution& execution) {
    const auto& [vertices, elements] = renumbering;
    const auto id = [&](VertexId v) { return vertices.after[v]; };
    const auto ids = [&](auto simplex) {
        for (VertexId& v : simplex) v = id(v);
        return simplex;
    };
    Columns columns(execution);
    columns.reorder(mesh.points, vertices.before);
    columns.reorder(mesh.point_references, vertices.before);
    columns.map(mesh.corners, id);
    columns.map(mesh.required_vertices, id);
    columns.reorder(mesh.elements.vertices, elements.before);
    columns.map(mesh.elements.vertices, ids);
    columns.reorder(mesh.elements.references, elements.before);
    columns.reorder(mesh.elements.entities, elements.before);
    columns.map(mesh.elements.required, [&](std::uint32_t e) { return elements.after[e].value; });
    columns.map(mesh.facets.vertices, ids);
    columns.map(mesh.edges.vertices, ids);
    renumber_geometry(mesh.geometry, vertices.after, columns);
    return std::move(columns).done().map([&](Done) { return std::move(mesh); });
}

template <int D>
Outcome<RenumberedQuadratic<D>> renumbered(QuadraticMesh<D> mesh, const Renumbering& renumbering,
                                           const Execution& execution) {
    auto linear = renumbered(std::move(mesh.linear), renumbering, part_of(execution, 0, 0.2));
    if (!linear) return fail(std::move(linear.error()));
    auto edges = unique_edges(*linear, part_of(execution, 0.2, 0.7));
    if (!edges) return fail(std::move(edges.error()));
    auto before = edges_before(mesh.edges, *edges, renumbering.elements.before, part_of(execution, 0.7, 0.9));
    if (!before) return fail(std::move(before.error()));
    const Column<EdgeId> were(std::move(*before));
    auto nodes = renumbered_rows(mesh.mid_nodes, were, part_of(execution, 0.9, 1));
    if (!nodes) return fail(std::move(nodes.error()));
    return RenumberedQuadratic<D>{{std::move(*linear), std::move(*edges), std::move(*nodes)}, were};
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<LinearMesh<D>> renumbered<D>(LinearMesh<D>, const Renumbering&, const Execution&); \
    template Outcome<RenumberedQuadratic<D>> renumbered<D>(QuadraticMesh<D>, const Renumbering&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
