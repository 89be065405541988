module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
export module camber.distributed:blocks;
import camber.core;
import :ranks;

export namespace camber {

/// A vertex, an element … of a mesh in blocks, from 0: there may be more than 32 bits count.
using GlobalNumber = std::uint64_t;

struct BlockOptions {
    std::size_t elements = std::size_t{1} << 18U;  ///< about so many in a block, without its rings
};

/// Which vertices are a block's, and which blocks a rank's: runs of rising numbers. An edge, a facet and an element
/// belong to the block of their lowest vertex.
struct BlockLayout {
    std::vector<GlobalNumber> first_vertices;  ///< of each block; then the number of vertices
    std::vector<std::size_t> first_blocks;     ///< of each rank; then the number of blocks

    [[nodiscard]] std::size_t size() const { return first_vertices.empty() ? 0 : first_vertices.size() - 1; }
    [[nodiscard]] std::size_t block_of(GlobalNumber vertex) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(first_vertices, vertex) - first_vertices.begin()) - 1;
    }
    [[nodiscard]] std::size_t rank_of(std::size_t block) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(first_blocks, block) - first_blocks.begin()) - 1;
    }
    [[nodiscard]] std::size_t begin_of(std::size_t rank) const { return first_blocks[rank]; }
    [[nodiscard]] std::size_t end_of(std::size_t rank) const { return first_blocks[rank + 1]; }
};

/// A block with the elements around it: those at its vertices, and a ring more. Local ids rise with global numbers, so
/// that loops over what is around something go in the same order as in the whole mesh.
template <int D>
struct Block {
    LinearMesh<D> mesh;
    Column<GlobalNumber> vertices, elements, facets, edges;  ///< of each local row; edges: the feature edges
    VertexId first, last;                                    ///< its own vertices are [first, last)

    [[nodiscard]] bool owns(VertexId v) const { return v >= first && v < last; }
    template <std::size_t N>
    [[nodiscard]] bool owns(const std::array<VertexId, N>& simplex) const {
        return owns(std::ranges::min(simplex));
    }
};

/// What a rank holds of a mesh in blocks.
template <int D>
struct Blocks {
    BlockLayout layout;
    std::vector<Block<D>> own;  ///< of the blocks from layout.begin_of(rank) on
};

}  // namespace camber
