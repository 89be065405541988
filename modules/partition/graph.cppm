module;
#include <cstddef>
#include <cstdint>
export module camber.partition:graph;
import camber.core;

export namespace camber {

/// Elements and those across their faces, in rising order: of element e neighbours[starts[e], starts[e + 1]). Of a
/// surface alone the triangles and those across their edges.
struct DualGraph {
    Buffer<std::uint32_t> starts;
    Buffer<std::uint32_t> neighbours;

    [[nodiscard]] std::size_t size() const { return starts.empty() ? 0 : starts.size() - 1; }
};

/// Errors: input (more than two elements on a face), memory, stopped.
template <int D>
[[nodiscard]] Outcome<DualGraph> dual_graph(const LinearMesh<D>& mesh, const Execution& execution);

}  // namespace camber
