module;
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.distributed:partition_rows;
import camber.core;
import :graph_run;
import :ranks;
import :rows;

export namespace camber {

/// What a rank has of a mesh in parts for a solver: a run of the parts as one mesh.
template <int D>
struct PartsOfRank {
    std::size_t first = 0, last = 0;  ///< parts, from 0
    LinearMesh<D> mesh;
    std::vector<std::uint64_t> vertices, elements, facets, edges;       ///< their numbers in the whole, which rise
    Buffer<std::int32_t> part_of_element, part_of_facet, part_of_edge;  ///< from 0
};

/// Parts of about as many elements each: each rank reads a run of the elements, they find those across their faces
/// together, `partition` says which are whose, and each rank gets what its parts have. A facet, and a feature edge, is
/// of the part of the lowest element that it belongs to (of part 0 if of none). What is given of the geometry is left
/// out. Errors, of any rank: usage (no parts, or more than elements), input (those of the rows; more than two elements
/// on a face), those of `partition`.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<D>> parts_of_rows(const MeshRows<D>& rows, std::size_t parts,
                                                    const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber
