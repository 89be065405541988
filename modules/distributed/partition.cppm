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

/// A rank's run of the rows of a graph, of elements and those across their faces say: the neighbours of its row i, by
/// their numbers in the whole, are neighbours[starts[i], starts[i + 1]). Runs follow each other in the order of the
/// ranks; whoever is a neighbour has a neighbour.
struct GraphRun {
    Buffer<std::uint64_t> starts = Buffer<std::uint64_t>(1, 0);
    Buffer<std::uint64_t> neighbours = {};

    [[nodiscard]] std::size_t size() const { return starts.size() - 1; }
};

/// The part, from 0, of each row of a rank, by a library that all ranks call.
using GraphPartitioner =
    std::function<Outcome<Buffer<std::int32_t>>(Ranks& ranks, const GraphRun& run, std::size_t parts)>;

}  // namespace camber

namespace camber {

/// Of n rows that ranks share in runs (`part_of`): whose a row is.
[[nodiscard]] inline std::size_t rank_of_row(std::uint64_t row, std::size_t n, std::size_t ranks) {
    std::size_t r = row * ranks / n;
    while (r + 1 < ranks && n * (r + 1) / ranks <= row) ++r;
    while (n * r / ranks > row) --r;
    return r;
}

/// A facet on its way: its row, and the lowest element that it bounds (none: `no_element`).
inline constexpr std::uint64_t no_element = ~std::uint64_t{0};
template <int D>
struct FacetRow {
    std::uint64_t row = 0;
    SimplexVertices<D - 1> vertices{};
    Reference reference = 0;
    std::uint32_t padding = 0;
    std::uint64_t element = no_element;
};

/// The rank's run of the graph of elements across faces, and the facets whose lowest vertex is of its run of vertices.
template <int D>
struct DualRows {
    GraphRun graph;
    std::vector<FacetRow<D>> facets;
};

/// Of what a rank has runs of, its first element being row `first`. Errors, of any rank: input (more than two elements
/// on a face).
template <int D>
[[nodiscard]] Outcome<DualRows<D>> dual_rows(const RunsOfRank<D>& runs, std::size_t first, Ranks& ranks);

}  // namespace camber

export namespace camber {

/// What a rank has of a mesh in parts for a solver: a run of the parts as one mesh, of degree 1 or 2.
template <class Mesh>
struct PartsOfRank {
    std::size_t first = 0, last = 0;  ///< parts, from 0
    Mesh mesh;
    std::vector<std::uint64_t> vertices, elements, facets, edges;       ///< their numbers in the whole, which rise
    std::vector<std::uint64_t> mid_nodes = {};                          ///< by edges of the edge set; of degree 1 none
    Buffer<std::int32_t> part_of_element, part_of_facet, part_of_edge;  ///< from 0
};

/// Parts of about as many elements each: each rank reads a run of the elements, they find those across their faces
/// together, `partition` says which are whose, and each rank gets what its parts have. A facet, and a feature edge, is
/// of the part of the lowest element that it belongs to (of part 0 if of none). What is given of the geometry is left
/// out. Errors, of any rank: usage (no parts, or more than elements), input (those of the rows; more than two elements
/// on a face), those of `partition`.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_rows(const MeshRows<D>& rows, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

/// The same of degree 2; edges' nodes have their numbers in the file. Errors: also input (a node of two edges, or an
/// edge with two, among what a rank has), stopped.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_quadratic_rows(const QuadraticRows<D>& rows,
                                                                             std::size_t parts,
                                                                             const GraphPartitioner& partition,
                                                                             Ranks& ranks, const Execution& execution);

/// A mesh that was curved by blocks, whose straight rows these are: nodes go from those who have them to where their
/// parts are.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_blocks(const MeshRows<D>& rows,
                                                                     const CurvedBlocks<D>& mesh, std::size_t parts,
                                                                     const GraphPartitioner& partition, Ranks& ranks,
                                                                     const Execution& execution);

/// A mesh that was remeshed by ranks.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_finished(FinishedRows<D> rows, std::size_t parts,
                                                                    const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber

namespace camber {

/// What this rank reads of rows.
template <int D>
[[nodiscard]] Outcome<RunsOfRank<D>> runs_of(const MeshRows<D>& rows, const Ranks& ranks);

/// Parts of what ranks have runs of, see parts_of_rows; what a rank could not read is the error of all.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_runs(const Outcome<RunsOfRank<D>>& runs,
                                                                const PointsAt<D>& points_at, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber
