// Parts for solvers: dual graph by rows, interface of a partitioner, parts of a rank.
module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>
export module camber.distributed:partition;
import camber.core;
import :adaptation;
import :blocks;
import :parts;
import :ranks;

export namespace camber {

/// This rank's rows of a symmetric graph, in which elements with a common face are neighbours. The neighbours of row i
/// are neighbours[starts[i], starts[i + 1]), as global numbers. The runs of ranks are consecutive.
struct GraphRun {
    Buffer<std::uint64_t> starts = Buffer<std::uint64_t>(1, 0);
    Buffer<std::uint64_t> neighbours = {};

    [[nodiscard]] std::size_t size() const { return starts.size() - 1; }
};

/// Part, from 0, of each own row. All ranks call it.
using GraphPartitioner =
    std::function<Outcome<Buffer<std::int32_t>>(Ranks& ranks, const GraphRun& run, std::size_t parts)>;

}  // namespace camber

namespace camber {

/// Rank of a row, for n rows distributed in even runs (`part_of`).
[[nodiscard]] inline std::size_t rank_of_row(std::uint64_t row, std::size_t n, std::size_t ranks) {
    std::size_t r = row * ranks / n;
    while (r + 1 < ranks && n * (r + 1) / ranks <= row) ++r;
    while (n * r / ranks > row) --r;
    return r;
}

/// A facet and its lowest element. A facet without elements has `no_element`.
inline constexpr std::uint64_t no_element = ~std::uint64_t{0};
template <int D>
struct FacetRow {
    std::uint64_t row = 0;
    SimplexVertices<D - 1> vertices{};
    Reference reference = 0;
    std::uint32_t padding = 0;
    std::uint64_t element = no_element;
};

/// This rank's run of the dual graph, and the facets whose lowest vertex is in its run of vertices.
template <int D>
struct DualRows {
    GraphRun graph;
    std::vector<FacetRow<D>> facets;
};

/// Builds the dual graph. `first` is the row of the first own element. Errors: input (more than two elements on a
/// face).
template <int D>
[[nodiscard]] Outcome<DualRows<D>> dual_rows(const RunsOfRank<D>& runs, std::size_t first, Ranks& ranks);

}  // namespace camber

export namespace camber {

/// Parts of this rank for a solver, together as one mesh of degree 1 or 2.
template <class Mesh>
struct PartsOfRank {
    std::size_t first = 0, last = 0;  ///< this rank has the parts [first, last), numbered from 0
    Mesh mesh;
    std::vector<std::uint64_t> vertices, elements, facets, edges;  ///< ascending global numbers
    std::vector<std::uint64_t> mid_nodes = {};  ///< file number of each edge's node; empty for degree 1
    Buffer<std::int32_t> part_of_element, part_of_facet, part_of_edge;  ///< numbered from 0
};

/// Partitions a mesh into parts of about equal numbers of elements. Ranks read runs of elements, build the dual graph,
/// call `partition`, and receive the rows of their parts. A facet or feature edge is in the part of its lowest element
/// (without elements: part 0). The geometry data of the file is not transferred. Errors: usage (no parts, or more parts
/// than elements), input (those of the rows; more than two elements on a face), those of `partition`.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_rows(const MeshRows<D>& rows, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

/// Like parts_of_rows for degree 2, with file numbers of edge nodes. Further errors: input (a node of two edges, or an
/// edge with two nodes, on one rank), stopped.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_quadratic_rows(const QuadraticRows<D>& rows,
                                                                             std::size_t parts,
                                                                             const GraphPartitioner& partition,
                                                                             Ranks& ranks, const Execution& execution);

/// Like parts_of_rows, for a mesh curved by blocks. `rows` has the straight mesh.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_blocks(const MeshRows<D>& rows,
                                                                     const CurvedBlocks<D>& mesh, std::size_t parts,
                                                                     const GraphPartitioner& partition, Ranks& ranks,
                                                                     const Execution& execution);

/// Like parts_of_rows, for a remeshed mesh.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_finished(FinishedRows<D> rows, std::size_t parts,
                                                                    const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] Outcome<RunsOfRank<D>> runs_of(const MeshRows<D>& rows, const Ranks& ranks);

/// Like parts_of_rows, from runs that the ranks have already read.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_runs(const Outcome<RunsOfRank<D>>& runs,
                                                                const PointsAt<D>& points_at, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber
