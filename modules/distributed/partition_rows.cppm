module;
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.distributed:partition_rows;
import camber.core;
import :curve_blocks;
import :finished_rows;
import :graph_run;
import :quadratic_rows;
import :ranks;
import :rows;

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
