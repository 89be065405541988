module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
export module camber.distributed:ringed_parts;
import camber.core;
import :ranks;

export namespace camber {

/// A vertex, an element … of a mesh in blocks, from 0: there may be more than 32 bits count.
using GlobalNumber = std::uint64_t;

struct BlockOptions {
    std::size_t elements = std::size_t{1} << 18U;  ///< about so many in a block
    /// At most so many in a part, if that is a block: a rank goes through its blocks by parts. No matter to results.
    std::size_t elements_at_once = std::numeric_limits<std::size_t>::max();
};

/// Which vertices are a block's, and who has which blocks: runs of rising numbers. An edge, a facet and an element
/// belong to the block of their lowest vertex. A part is a run of blocks that a rank has and works on at once.
struct PartLayout {
    std::vector<GlobalNumber> first_of_blocks;  ///< vertices: of each block; then the number of vertices
    std::vector<GlobalNumber> first_vertices;   ///< of each part; then the number of vertices
    std::vector<std::size_t> first_parts;       ///< of each rank; then the number of parts

    [[nodiscard]] std::size_t blocks() const { return first_of_blocks.empty() ? 0 : first_of_blocks.size() - 1; }
    [[nodiscard]] std::size_t size() const { return first_vertices.empty() ? 0 : first_vertices.size() - 1; }
    [[nodiscard]] std::size_t part_with(GlobalNumber vertex) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(first_vertices, vertex) - first_vertices.begin()) - 1;
    }
    [[nodiscard]] std::size_t rank_of(std::size_t part) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(first_parts, part) - first_parts.begin()) - 1;
    }
    [[nodiscard]] std::size_t begin_of(std::size_t rank) const { return first_parts[rank]; }
    [[nodiscard]] std::size_t end_of(std::size_t rank) const { return first_parts[rank + 1]; }
    /// Where all blocks of a part but the first begin.
    [[nodiscard]] std::span<const GlobalNumber> later_blocks(std::size_t part) const {
        const auto begin = std::ranges::upper_bound(first_of_blocks, first_vertices[part]);
        return {begin, std::ranges::lower_bound(first_of_blocks, first_vertices[part + 1])};
    }
};

/// Some of a mesh's vertices and the elements around them: those at these vertices, and a ring more. Local ids rise
/// with global numbers, so that loops over what is around something go in the same order as in the whole mesh.
template <int D>
struct RingedPart {
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
struct RingedParts {
    PartLayout layout;
    std::vector<RingedPart<D>> own;  ///< from layout.begin_of(rank) on
};

}  // namespace camber
