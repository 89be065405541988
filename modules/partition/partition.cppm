module;
#include <cstddef>
#include <cstdint>
/// Divides a mesh into parts of about equal size with few faces between them, each a mesh with references to the whole.
export module camber.partition;
import camber.core;

export namespace camber {

/// Neighbours across faces, ascending: of element e neighbours[starts[e], starts[e + 1]). For surface meshes triangles
/// across edges.
struct DualGraph {
    Buffer<std::uint32_t> starts;
    Buffer<std::uint32_t> neighbours;

    [[nodiscard]] std::size_t size() const { return starts.empty() ? 0 : starts.size() - 1; }
};

/// Errors: input (more than two elements on a face), memory, stopped.
template <int D>
[[nodiscard]] Outcome<DualGraph> dual_graph(const LinearMesh<D>& mesh, const Execution& execution);

}  // namespace camber

namespace camber {

/// Errors: unsupported (no library), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts);

}  // namespace camber

export namespace camber {

/// Parts of cells, from 0.
struct CellParts {
    Column<std::int32_t> elements, facets, edges;
};

/// Uses Scotch; the result does not depend on the number of threads. Facets and feature edges get the part of their
/// lowest element (0 without elements). Elements of a surface mesh are its facets. Errors: usage (no parts, or more
/// than elements), unsupported (built without Scotch), memory, stopped.
template <int D>
[[nodiscard]] Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution);

/// Parts of facets and edges from those of elements (of a surface mesh: facets).
template <int D>
[[nodiscard]] Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                                const Execution& execution);

/// A part as a mesh, with its rows in the whole, ascending.
template <class Mesh>
struct MeshPiece {
    Mesh mesh;
    Column<std::uint32_t> vertices, elements, facets, edges;
    Column<std::uint32_t> mid_nodes = {};  ///< edges in the edge set; empty for degree 1
};

/// Cells of one part with their nodes, corners, ridges and required entities, without given geometry. Errors: memory,
/// stopped.
template <class Mesh>
[[nodiscard]] Outcome<MeshPiece<Mesh>> piece_of(const Mesh& mesh, const CellParts& parts, std::int32_t part,
                                                const Execution& execution);

}  // namespace camber
