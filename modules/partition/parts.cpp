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

/// The part of the lowest element that has all vertices of a simplex.
template <int D, int K>
Outcome<Column<std::int32_t>> parts_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                       const Simplices<K>& simplices, const Column<std::int32_t>& elements,
                                       const Execution& execution) {
    return map_each(execution, simplices.size(),
                    [&](std::size_t s) -> std::int32_t {
                        const SimplexVertices<K>& simplex = simplices.vertices[s];
                        for (const ElementId e : balls[simplex[0]])  // they rise
                            if (std::ranges::all_of(simplex, [&](VertexId v) {
                                    return std::ranges::find(mesh.elements.vertices[e], v) !=
                                           mesh.elements.vertices[e].end();
                                }))
                                return elements[e];
                        return 0;
                    })
        .map([](Buffer<std::int32_t> parts) { return Column<std::int32_t>(std::move(parts)); });
}

}  // namespace

template <int D>
Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                  const Execution& execution) {
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto facets = parts_of(mesh, *around, mesh.facets, elements, execution);
    if (!facets) return fail(std::move(facets.error()));
    auto edges = parts_of(mesh, *around, mesh.edges, elements, execution);
    if (!edges) return fail(std::move(edges.error()));
    return CellParts{std::move(elements), std::move(*facets), std::move(*edges)};
}

template <int D>
Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution) {
    if (parts == 0 || parts > std::max<std::size_t>(mesh.elements.size(), 1))
        return fail(ErrorKind::usage, "a mesh of " + std::to_string(mesh.elements.size()) + " elements has no " +
                                          std::to_string(parts) + " parts");
    const auto graph = dual_graph(mesh, execution);
    if (!graph) return fail(graph.error());
    return guarded([&] { return parts_of_graph(*graph, parts); }).and_then([&](Buffer<std::int32_t> elements) {
        return parts_of_cells(mesh, std::move(elements), execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<CellParts> partition<D>(const LinearMesh<D>&, std::size_t, const Execution&); \
    template Outcome<CellParts> parts_of_cells<D>(const LinearMesh<D>&, Column<std::int32_t>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
