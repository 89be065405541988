module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>
module camber.partition;
import camber.core;

namespace camber {

namespace {

/// The triangles of a surface: any number of them may meet at an edge.
Outcome<DualGraph> graph_of_surface(const LinearMesh<3>& mesh, const Execution& execution) {
    const auto edges = unique_edges(mesh, execution);
    if (!edges) return fail(edges.error());
    const auto shells = facet_shells(*edges, execution);
    if (!shells) return fail(shells.error());
    DualGraph graph;
    graph.starts.push_back(0);
    std::vector<std::uint32_t> beside;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        beside.clear();
        for (const EdgeId edge : edges->of_facets[f])
            for (const FacetId other : (*shells)[edge])
                if (other.index() != f) beside.push_back(other.value);
        std::sort(beside.begin(), beside.end());
        beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
        graph.neighbours.insert(graph.neighbours.end(), beside.begin(), beside.end());
        if (graph.neighbours.size() > std::numeric_limits<std::uint32_t>::max())
            return fail(ErrorKind::unsupported, "has more edges between triangles than 32 bits can number");
        graph.starts.push_back(static_cast<std::uint32_t>(graph.neighbours.size()));
    }
    return graph;
}

}  // namespace

template <int D>
Outcome<DualGraph> dual_graph(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<DualGraph> {
        if constexpr (D == 3)
            if (is_surface_alone(mesh)) return graph_of_surface(mesh, execution);
        const auto around = balls(mesh, execution);
        if (!around) return fail(around.error());
        const auto across = neighbours(mesh, *around, execution);
        if (!across) return fail(across.error());
        DualGraph graph;
        graph.starts.resize(mesh.elements.size() + 1);
        std::size_t arcs = 0;
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
            graph.starts[e] = static_cast<std::uint32_t>(arcs);
            arcs += static_cast<std::size_t>(std::ranges::count_if((*across)[e], &ElementId::valid));
            if (arcs > std::numeric_limits<std::uint32_t>::max())
                return fail(ErrorKind::unsupported, "has more faces between elements than 32 bits can number");
        }
        graph.starts.back() = static_cast<std::uint32_t>(arcs);
        graph.neighbours.resize(arcs);
        auto filled = each(execution, mesh.elements.size(), [&](std::size_t e) {
            std::uint32_t* const begin = graph.neighbours.data() + graph.starts[e];
            std::uint32_t* at = begin;
            for (const ElementId other : (*across)[e])
                if (other.valid()) *at++ = other.value;
            std::sort(begin, at);
        });
        if (!filled) return fail(std::move(filled.error()));
        return graph;
    });
}

template Outcome<DualGraph> dual_graph<2>(const LinearMesh<2>&, const Execution&);
template Outcome<DualGraph> dual_graph<3>(const LinearMesh<3>&, const Execution&);

}  // namespace camber
