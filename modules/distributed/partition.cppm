// Parts for solvers: dual graph by rows, partitioner, parts of a rank.
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

/// A rank's rows of a symmetric graph of elements and face neighbours. Neighbours of row i: neighbours[starts[i],
/// starts[i + 1]), as global numbers. Runs are in rank order.
struct GraphRun {
    Buffer<std::uint64_t> starts = Buffer<std::uint64_t>(1, 0);
    Buffer<std::uint64_t> neighbours = {};

    [[nodiscard]] std::size_t size() const { return starts.size() - 1; }
};

/// Returns the part, from 0, of each own row. All ranks call it.
using GraphPartitioner =
    std::function<Outcome<Buffer<std::int32_t>>(Ranks& ranks, const GraphRun& run, std::size_t parts)>;

}  // namespace camber

namespace camber {

/// For n rows shared in runs (`part_of`).
[[nodiscard]] inline std::size_t rank_of_row(std::uint64_t row, std::size_t n, std::size_t ranks) {
    std::size_t r = row * ranks / n;
    while (r + 1 < ranks && n * (r + 1) / ranks <= row) ++r;
    while (n * r / ranks > row) --r;
    return r;
}

/// A facet, and the lowest element at it (none: `no_element`).
inline constexpr std::uint64_t no_element = ~std::uint64_t{0};
template <int D>
struct FacetRow {
    std::uint64_t row = 0;
    SimplexVertices<D - 1> vertices{};
    Reference reference = 0;
    std::uint32_t padding = 0;
    std::uint64_t element = no_element;
};

/// Own run of the dual graph, and facets with their lowest vertex in the own run of vertices.
template <int D>
struct DualRows {
    GraphRun graph;
    std::vector<FacetRow<D>> facets;
};

/// `first`: row of the first own element. Errors: input (more than two elements on a face).
template <int D>
[[nodiscard]] Outcome<DualRows<D>> dual_rows(const RunsOfRank<D>& runs, std::size_t first, Ranks& ranks);

}  // namespace camber

export namespace camber {

/// Own parts for a solver, as one mesh of degree 1 or 2.
template <class Mesh>
struct PartsOfRank {
    std::size_t first = 0, last = 0;  ///< parts, from 0
    Mesh mesh;
    std::vector<std::uint64_t> vertices, elements, facets, edges;       ///< ascending global numbers
    std::vector<std::uint64_t> mid_nodes = {};                          ///< by edge; empty for degree 1
    Buffer<std::int32_t> part_of_element, part_of_facet, part_of_edge;  ///< from 0
};

/// Partitions a mesh into parts of about equal numbers of elements. Ranks read runs of elements, build the dual graph,
/// call `partition`, and receive the rows of their parts. A facet or feature edge is in the part of its lowest element
/// (without elements: part 0). The given geometry is not transferred. Errors: usage (no parts, or more than elements),
/// input (those of the rows; more than two elements on a face), those of `partition`.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_rows(const MeshRows<D>& rows, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

/// The same for degree 2, with file numbers of edge nodes. More errors: input (a node of two edges, or an edge with two
/// nodes, on one rank), stopped.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_quadratic_rows(const QuadraticRows<D>& rows,
                                                                             std::size_t parts,
                                                                             const GraphPartitioner& partition,
                                                                             Ranks& ranks, const Execution& execution);

/// The same for a mesh curved by blocks. `rows`: straight mesh.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_blocks(const MeshRows<D>& rows,
                                                                     const CurvedBlocks<D>& mesh, std::size_t parts,
                                                                     const GraphPartitioner& partition, Ranks& ranks,
                                                                     const Execution& execution);

/// The same for a remeshed mesh.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_finished(FinishedRows<D> rows, std::size_t parts,
                                                                    const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] Outcome<RunsOfRank<D>> runs_of(const MeshRows<D>& rows, const Ranks& ranks);

/// See parts_of_rows.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_runs(const Outcome<RunsOfRank<D>>& runs,
                                                                const PointsAt<D>& points_at, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber
