module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>
module camber.ordering;
import camber.core;
import :morton;

namespace camber {

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

/// Elements by keys below a bound, equal ones in the order that was: a counting sort.
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
    return space_filling_order(mesh, part_of(execution, 0.1, 1)).map([&](Renumbering made) {
        return std::optional(BetterOrder{std::move(made), *own});
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<double> scatter<D>(const LinearMesh<D>&, const Execution&);                               \
    template Outcome<Renumbering> space_filling_order<D>(const LinearMesh<D>&, const Execution&);              \
    template Outcome<std::optional<BetterOrder>> better_order<D>(const LinearMesh<D>&, const OrderingOptions&, \
                                                                 const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
