module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
/// Order of vertices and elements in memory: its quality, its improvement, and renumbering in both directions. All
/// functions that return an Outcome may fail with memory or stopped.
export module camber.ordering;
import camber.core;

export namespace camber {

/// Bounding box of points. Without points `low` is above `high`.
template <int D>
struct PointBox {
    Vec<D> low, high;
};

template <int D>
[[nodiscard]] Outcome<PointBox<D>> box_of_points(const Column<Vec<D>>& points, const Execution& execution) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    PointBox<D> nothing;
    for (int c = 0; c < D; ++c) nothing.low[c] = infinity, nothing.high[c] = -infinity;
    const auto join = [](PointBox<D> a, const PointBox<D>& b) {
        for (int c = 0; c < D; ++c) {
            a.low[c] = std::min(a.low[c], b.low[c]);
            a.high[c] = std::max(a.high[c], b.high[c]);
        }
        return a;
    };
    return reduce_each(
        execution, points.size(), nothing,
        [&](PointBox<D>& box, std::size_t v) { box = join(box, {points[v], points[v]}); }, join);
}

/// Morton code: interleaves the bits of the coordinates, the highest bits first. Coordinates are relative to the box.
template <int D>
[[nodiscard]] std::uint64_t morton_key(const Vec<D>& p, const PointBox<D>& box) {
    constexpr int bits = 63 / D;
    constexpr auto most = static_cast<double>((std::uint64_t{1} << bits) - 1);
    std::array<std::uint64_t, D> cell{};
    for (int c = 0; c < D; ++c) {
        // Each term is halved first, because high − low may overflow.
        const double extent = 0.5 * box.high[c] - 0.5 * box.low[c];
        if (extent > 0) cell[c] = static_cast<std::uint64_t>((0.5 * p[c] - 0.5 * box.low[c]) / extent * most);
    }
    std::uint64_t key = 0;
    for (int b = bits - 1; b >= 0; --b)
        for (int c = 0; c < D; ++c) key = key << 1U | (cell[c] >> static_cast<unsigned>(b) & 1U);
    return key;
}

// Renumbering of vertices and elements. Facets and feature edges keep their ids, because they are few and are read
// sequentially.

template <class EntityId>
struct Permutation {
    Column<EntityId> before;  ///< old id of each new id
    Column<EntityId> after;   ///< new id of each old id
};

/// `before`: old id of each new id.
template <class EntityId>
[[nodiscard]] Outcome<Permutation<EntityId>> permutation(Column<EntityId> before, const Execution& execution) {
    Buffer<EntityId> after;
    auto done = guarded([&]() -> Outcome<Done> {
        after = Buffer<EntityId>(before.size());
        return each(execution, before.size(), [&](std::size_t id) { after[before[id].index()] = EntityId(id); });
    });
    if (!done) return fail(std::move(done.error()));
    return Permutation<EntityId>{std::move(before), std::move(after)};
}

struct Renumbering {
    Permutation<VertexId> vertices;
    Permutation<ElementId> elements;
};

[[nodiscard]] inline Renumbering inverse(const Renumbering& r) {
    return {{r.vertices.after, r.vertices.before}, {r.elements.after, r.elements.before}};
}

/// Reorders rows of `width` values; an empty column stays empty.
template <class T, class EntityId>
[[nodiscard]] Outcome<Column<T>> renumbered_rows(const Column<T>& rows, const Column<EntityId>& before,
                                                 const Execution& execution, std::size_t width = 1) {
    if (rows.empty()) return rows;
    return map_each(execution, before.size() * width,
                    [&](std::size_t i) { return rows[before[i / width].index() * width + i % width]; })
        .map([](Buffer<T> result) { return Column<T>(std::move(result)); });
}

/// Renumbers a mesh. The order of vertices within a simplex, and that of lists, is preserved, so `inverse` restores the
/// mesh.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> renumbered(LinearMesh<D> mesh, const Renumbering& renumbering,
                                                const Execution& execution);

/// A renumbered mesh of degree 2, in which edges also have new ids.
template <int D>
struct RenumberedQuadratic {
    QuadraticMesh<D> mesh;
    Column<EdgeId> edges;  ///< old id of each new edge
};
template <int D>
[[nodiscard]] Outcome<RenumberedQuadratic<D>> renumbered(QuadraticMesh<D> mesh, const Renumbering& renumbering,
                                                         const Execution& execution);

// Locality in memory: loops over elements read data of vertices, and loops over vertices read data of elements. For 1
// million tetrahedra in random order most reads miss the caches, and a run takes twice as long.

struct OrderingOptions {
    /// Meshes with fewer elements fit into caches and are not reordered.
    std::size_t min_elements = 100'000;
    /// Meshes with a larger `scatter` are reordered.
    double max_scatter = 0.02;
};

/// Returns a measure of the order: the mean difference between the lowest vertices of consecutive elements, divided by
/// the number of vertices. It is near 0 in a good order and 0 for fewer than two elements. In a random order of
/// elements with k vertices it is 2k/((k + 1)(2k + 1)): 0.178 for tetrahedra, 0.214 for triangles.
template <int D>
[[nodiscard]] Outcome<double> scatter(const LinearMesh<D>& mesh, const Execution& execution);

/// Sorts vertices along the Morton curve in their bounding box (G. M. Morton, 1966), and elements by their lowest
/// vertex. Elements with the same lowest vertex keep their order.
template <int D>
[[nodiscard]] Outcome<Renumbering> space_filling_order(const LinearMesh<D>& mesh, const Execution& execution);

/// A better order, and the `scatter` of the present order.
struct BetterOrder {
    Renumbering renumbering;
    double scatter = 0;
};
/// Returns the space-filling order; none if the mesh is small or its present order is good.
template <int D>
[[nodiscard]] Outcome<std::optional<BetterOrder>> better_order(const LinearMesh<D>& mesh,
                                                               const OrderingOptions& options,
                                                               const Execution& execution);

}  // namespace camber
