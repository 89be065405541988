module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
module camber.partition;
import camber.core;

namespace camber {

namespace {

/// The part of the lowest cell that has all vertices of a simplex.
template <int C, int K, class Id>
Outcome<Column<std::int32_t>> parts_of(const Simplices<C>& cells, const Incidence<Id>& balls,
                                       const Simplices<K>& simplices, const Column<std::int32_t>& parts,
                                       const Execution& execution) {
    return map_each(execution, simplices.size(),
                    [&](std::size_t s) -> std::int32_t {
                        const SimplexVertices<K>& simplex = simplices.vertices[s];
                        for (const Id c : balls[simplex[0]])  // they rise
                            if (std::ranges::all_of(simplex, [&](VertexId v) {
                                    return std::ranges::find(cells.vertices[c], v) != cells.vertices[c].end();
                                }))
                                return parts[c];
                        return 0;
                    })
        .map([](Buffer<std::int32_t> made) { return Column<std::int32_t>(std::move(made)); });
}

Outcome<CellParts> parts_of_surface(const LinearMesh<3>& mesh, Column<std::int32_t> facets,
                                    const Execution& execution) {
    const auto around = facet_balls(mesh, execution);
    if (!around) return fail(around.error());
    auto edges = parts_of(mesh.facets, *around, mesh.edges, facets, execution);
    if (!edges) return fail(std::move(edges.error()));
    return CellParts{{}, std::move(facets), std::move(*edges)};
}

}  // namespace

template <int D>
Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                  const Execution& execution) {
    if constexpr (D == 3)
        if (is_surface_alone(mesh)) return parts_of_surface(mesh, std::move(elements), execution);
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto facets = parts_of(mesh.elements, *around, mesh.facets, elements, execution);
    if (!facets) return fail(std::move(facets.error()));
    auto edges = parts_of(mesh.elements, *around, mesh.edges, elements, execution);
    if (!edges) return fail(std::move(edges.error()));
    return CellParts{std::move(elements), std::move(*facets), std::move(*edges)};
}

template <int D>
Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution) {
    const std::size_t cells = is_surface_alone(mesh) ? mesh.facets.size() : mesh.elements.size();
    if (parts == 0 || parts > std::max<std::size_t>(cells, 1))
        return fail(ErrorKind::usage, "a mesh of " + std::to_string(cells) +
                                          (is_surface_alone(mesh) ? " triangles" : " elements") + " has no " +
                                          std::to_string(parts) + " parts");
    const auto graph = dual_graph(mesh, execution);
    if (!graph) return fail(graph.error());
    return guarded([&] { return parts_of_graph(*graph, parts); }).and_then([&](Buffer<std::int32_t> of_cells) {
        return parts_of_cells(mesh, std::move(of_cells), execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<CellParts> partition<D>(const LinearMesh<D>&, std::size_t, const Execution&); \
    template Outcome<CellParts> parts_of_cells<D>(const LinearMesh<D>&, Column<std::int32_t>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
