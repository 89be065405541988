module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
module camber.partition;
import camber.core;

namespace camber {

template <int D>
Outcome<DualGraph> dual_graph(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<DualGraph> {
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
