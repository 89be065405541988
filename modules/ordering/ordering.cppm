module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
/// In which order a mesh's vertices and elements stand in memory: how good it is, a better one, and meshes brought from
/// one into the other and back.
export module camber.ordering;
import camber.core;

export namespace camber {

/// A box along the axes; without points `low` is above `high`.
template <int D>
struct PointBox {
    Vec<D> low, high;
};

/// Errors: memory, stopped.
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

/// Place on the Morton curve: the bits of the coordinates within the box, interleaved, the highest first.
template <int D>
[[nodiscard]] std::uint64_t morton_key(const Vec<D>& p, const PointBox<D>& box) {
    constexpr int bits = 63 / D;
    constexpr auto most = static_cast<double>((std::uint64_t{1} << bits) - 1);
    std::array<std::uint64_t, D> cell{};
    for (int c = 0; c < D; ++c) {
        // Halved, since the extent itself may overflow.
        const double extent = 0.5 * box.high[c] - 0.5 * box.low[c];
        if (extent > 0) cell[c] = static_cast<std::uint64_t>((0.5 * p[c] - 0.5 * box.low[c]) / extent * most);
    }
    std::uint64_t key = 0;
    for (int b = bits - 1; b >= 0; --b)
        for (int c = 0; c < D; ++c) key = key << 1U | (cell[c] >> static_cast<unsigned>(b) & 1U);
    return key;
}

// Other ids for the vertices and elements of a mesh. Facets and feature edges keep theirs: few and read in turn, their
// order costs little.

/// Other ids for all entities of one kind, and the way back.
template <class EntityId>
struct Permutation {
    Column<EntityId> before;  ///< of each id the one that it was
    Column<EntityId> after;   ///< of each id that was the one that it is
};

/// From the ids that were, each once, in the order of the new ones. Errors: memory, stopped.
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

/// From the new ids to those that were.
[[nodiscard]] inline Renumbering inverse(const Renumbering& r) {
    return {{r.vertices.after, r.vertices.before}, {r.elements.after, r.elements.before}};
}

/// A column whose rows are of entities, `width` values each, in the order of the new ids; without rows it stays so.
/// Errors: memory, stopped.
template <class T, class EntityId>
[[nodiscard]] Outcome<Column<T>> renumbered_rows(const Column<T>& rows, const Column<EntityId>& before,
                                                 const Execution& execution, std::size_t width = 1) {
    if (rows.empty()) return rows;
    return map_each(execution, before.size() * width,
                    [&](std::size_t i) { return rows[before[i / width].index() * width + i % width]; })
        .map([](Buffer<T> made) { return Column<T>(std::move(made)); });
}

/// The same mesh by the new ids. The vertices of a simplex keep their turn, and lists of entities theirs, so that what
/// is renumbered by the inverse is what it was. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> renumbered(LinearMesh<D> mesh, const Renumbering& renumbering,
                                                const Execution& execution);

/// The same of a mesh of degree 2, whose unique edges get other ids by the way.
template <int D>
struct RenumberedQuadratic {
    QuadraticMesh<D> mesh;
    Column<EdgeId> edges;  ///< of each edge the one that it was
};
template <int D>
[[nodiscard]] Outcome<RenumberedQuadratic<D>> renumbered(QuadraticMesh<D> mesh, const Renumbering& renumbering,
                                                         const Execution& execution);

// Whether what is near in a mesh is near in memory, and an order in which it is. Loops over elements and edges read
// their vertices, those over vertices their elements: in a mesh of 1 million tetrahedra in random order most of these
// reads miss the caches, and a run takes twice as long.

struct OrderingOptions {
    /// Smaller meshes fit into caches in any order.
    std::size_t min_elements = 100'000;
    /// The scatter above which an order is bad.
    double max_scatter = 0.02;
};

/// The mean distance of the lowest vertices of consecutive elements, by the number of vertices: near 0 in a good order,
/// in a random one 2k/((k + 1)(2k + 1)) of elements of k vertices: 0.178 for tetrahedra, 0.214 for triangles. 0 without
/// two elements. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<double> scatter(const LinearMesh<D>& mesh, const Execution& execution);

/// Vertices along the Morton curve through their bounding box (G. M. Morton, 1966), elements by their lowest vertex
/// then; ties in the order that was. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Renumbering> space_filling_order(const LinearMesh<D>& mesh, const Execution& execution);

/// An order to work in, and how bad the mesh's own is.
struct BetterOrder {
    Renumbering renumbering;
    double scatter = 0;
};
/// The space-filling one, where the mesh's own is bad; nothing where that will do. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::optional<BetterOrder>> better_order(const LinearMesh<D>& mesh,
                                                               const OrderingOptions& options,
                                                               const Execution& execution);

}  // namespace camber
