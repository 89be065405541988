module;
#include <cstddef>
#include <cstdint>
export module camber.partition:pieces;
import camber.core;
import :parts;

export namespace camber {

/// A part of a mesh as a mesh, and which rows of the whole its own are; both rise.
template <class Mesh>
struct MeshPiece {
    Mesh mesh;
    Column<std::uint32_t> vertices, elements, facets, edges;
    Column<std::uint32_t> mid_nodes = {};  ///< by edges of the edge set; of degree 1 none
};

/// The cells of one part with the vertices (and the nodes) that they have; corners, ridges and what is required of
/// these. What is given of the geometry is left out. Errors: memory, stopped.
template <class Mesh>
[[nodiscard]] Outcome<MeshPiece<Mesh>> piece_of(const Mesh& mesh, const CellParts& parts, std::int32_t part,
                                                const Execution& execution);

}  // namespace camber
