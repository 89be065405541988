module;
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
module camber.ordering;
import camber.core;

namespace camber {

namespace {

template <class T, class F>
Outcome<Column<T>> mapped(const Column<T>& rows, F&& f, const Execution& execution) {
    return map_each(execution, rows.size(), [&](std::size_t i) -> T { return f(rows[i]); }).map([](Buffer<T> result) {
        return Column<T>(std::move(result));
    });
}

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
        Outcome<Column<T>> result = make();
        if (result)
            rows = std::move(*result);
        else
            done_ = fail(std::move(result.error()));
    }

    const Execution& execution_;
    Outcome<Done> done_ = Done{};
};

template <int D>
void renumber_geometry(InputGeometry<D>& geometry, const Column<VertexId>& after, Columns& columns) {
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

/// Old id of each edge. Local edge k of an element is the same edge before and now. Elements that share an edge write
/// the same value.
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

namespace {

template <int D>
Outcome<Permutation<VertexId>> vertices_along_curve(const Column<Vec<D>>& points, const Execution& execution) {
    const auto box = box_of_points(points, without_progress(execution));
    if (!box) return fail(box.error());
    struct Placed {
        std::uint64_t key = 0;
        VertexId vertex;
        auto operator<=>(const Placed&) const = default;
    };
    auto placed = map_each(part_of(execution, 0, 0.2), points.size(),
                           [&](std::size_t v) { return Placed{morton_key(points[v], *box), VertexId(v)}; });
    if (!placed) return fail(std::move(placed.error()));
    std::ranges::sort(*placed);
    auto before =
        map_each(part_of(execution, 0.8, 0.9), placed->size(), [&](std::size_t i) { return (*placed)[i].vertex; });
    if (!before) return fail(std::move(before.error()));
    return permutation(Column<VertexId>(std::move(*before)), part_of(execution, 0.9, 1));
}

Buffer<ElementId> sorted_by(const Buffer<std::uint32_t>& keys, std::size_t bound) {
    Buffer<std::uint32_t> next(bound + 1, 0U);
    for (const std::uint32_t key : keys) ++next[key + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    Buffer<ElementId> sorted(keys.size());
    for (std::size_t e = 0; e < keys.size(); ++e) sorted[next[keys[e]]++] = ElementId(e);
    return sorted;
}

}  // namespace

template <int D>
Outcome<double> scatter(const LinearMesh<D>& mesh, const Execution& execution) {
    const auto& elements = mesh.elements.vertices;
    if (elements.size() < 2) return 0.0;
    const auto lowest = [&](std::size_t e) -> std::uint64_t { return std::ranges::min(elements[e]).value; };
    const auto sum = reduce_each(
        execution, elements.size() - 1, std::uint64_t{0},
        [&](std::uint64_t& total, std::size_t e) {
            const std::uint64_t a = lowest(e), b = lowest(e + 1);
            total += a < b ? b - a : a - b;
        },
        [](std::uint64_t a, std::uint64_t b) { return a + b; });
    if (!sum) return fail(sum.error());
    return static_cast<double>(*sum) / static_cast<double>(elements.size() - 1) /
           static_cast<double>(mesh.points.size());
}

template <int D>
Outcome<Renumbering> space_filling_order(const LinearMesh<D>& mesh, const Execution& execution) {
    auto vertices = vertices_along_curve(mesh.points, part_of(execution, 0, 0.5));
    if (!vertices) return fail(std::move(vertices.error()));
    const auto lowest = map_each(part_of(execution, 0.5, 0.7), mesh.elements.size(), [&](std::size_t e) {
        std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
        for (const VertexId v : mesh.elements.vertices[e]) least = std::min(least, vertices->after[v].value);
        return least;
    });
    if (!lowest) return fail(lowest.error());
    auto elements = guarded([&]() -> Outcome<Permutation<ElementId>> {
        return permutation(Column<ElementId>(sorted_by(*lowest, mesh.points.size())), part_of(execution, 0.9, 1));
    });
    if (!elements) return fail(std::move(elements.error()));
    return Renumbering{std::move(*vertices), std::move(*elements)};
}

template <int D>
Outcome<std::optional<BetterOrder>> better_order(const LinearMesh<D>& mesh, const OrderingOptions& options,
                                                 const Execution& execution) {
    if (mesh.elements.size() < options.min_elements) return std::nullopt;
    const auto own = scatter(mesh, part_of(execution, 0, 0.1));
    if (!own) return fail(own.error());
    if (!(*own > options.max_scatter)) return std::nullopt;
    return space_filling_order(mesh, part_of(execution, 0.1, 1)).map([&](Renumbering result) {
        return std::optional(BetterOrder{std::move(result), *own});
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<LinearMesh<D>> renumbered<D>(LinearMesh<D>, const Renumbering&, const Execution&);             \
    template Outcome<RenumberedQuadratic<D>> renumbered<D>(QuadraticMesh<D>, const Renumbering&, const Execution&); \
    template Outcome<double> scatter<D>(const LinearMesh<D>&, const Execution&);                                    \
    template Outcome<Renumbering> space_filling_order<D>(const LinearMesh<D>&, const Execution&);                   \
    template Outcome<std::optional<BetterOrder>> better_order<D>(const LinearMesh<D>&, const OrderingOptions&,      \
                                                                 const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
