module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>
export module camber.distributed:ringed_parts;
import camber.core;
import :ranks;

export namespace camber {

/// A vertex, an element … of a mesh in blocks, from 0: there may be more than 32 bits count.
using GlobalNumber = std::uint64_t;

/// What is done around the work on a part where memory is little. Null: nobody minds.
struct PartMemory {
    std::function<void()> before = {};  ///< what is made from here on is let go of with the part
    std::function<void()> after = {};   ///< and from here on it is kept
    std::function<void()> leave = {};   ///< what is kept of the part may leave memory
};

inline constexpr std::size_t default_block_elements = std::size_t{1} << 18U;

struct BlockOptions {
    std::size_t elements = default_block_elements;  ///< about so many in a block
    /// At most so many in a part, if that is a block: a rank goes through its blocks by parts. No matter to results.
    std::size_t elements_at_once = std::numeric_limits<std::size_t>::max();
    PartMemory memory = {};
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

/// visit(array) of all that grow with the part.
template <int D>
void each_array(RingedPart<D>& part, const auto& visit) {
    const auto visit_simplices = [&](auto& simplices) {
        visit(simplices.vertices);
        visit(simplices.references);
    };
    visit(part.mesh.points);
    visit(part.mesh.point_references);
    visit_simplices(part.mesh.elements);
    visit_simplices(part.mesh.facets);
    visit_simplices(part.mesh.edges);
    visit(part.vertices);
    visit(part.elements);
    visit(part.facets);
    visit(part.edges);
}
/// The arrays of what has them, and those that are others than before made once more: where what is kept is made.
template <class T>
[[nodiscard]] std::vector<const void*> arrays_of(T& thing) {
    std::vector<const void*> arrays;
    each_array(thing, [&](const auto& array) { arrays.push_back(array.data()); });
    return arrays;
}
template <class T>
void made_anew(T& thing, std::span<const void* const> before) {
    std::size_t next = 0;
    each_array(thing, [&]<class Array>(Array& array) {
        if (array.data() == before[next++] || array.empty()) return;
        Buffer<typename Array::value_type> again(array.size());
        fill_array<typename Array::value_type>(again, {array.data(), array.size()});
        array = std::move(again);
    });
}

/// What a rank holds of a mesh in blocks.
template <int D>
struct RingedParts {
    PartLayout layout;
    std::vector<RingedPart<D>> own;  ///< from layout.begin_of(rank) on
};

}  // namespace camber
