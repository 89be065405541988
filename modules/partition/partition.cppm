module;
#include <cstddef>
#include <cstdint>
/// Divides a mesh into parts of about equal size with few common faces.
export module camber.partition;
import camber.core;

export namespace camber {

/// Neighbours of elements across faces (in surface meshes: edges). Element e has the neighbours with index starts[e] to
/// starts[e + 1] − 1, in ascending order.
struct DualGraph {
    Buffer<std::uint32_t> starts;
    Buffer<std::uint32_t> neighbours;

    [[nodiscard]] std::size_t size() const { return starts.empty() ? 0 : starts.size() - 1; }
};

/// Errors: input (a face has more than two elements), memory, stopped.
template <int D>
[[nodiscard]] Outcome<DualGraph> dual_graph(const LinearMesh<D>& mesh, const Execution& execution);

}  // namespace camber

namespace camber {

/// Returns the part of each vertex of the graph, from 0. Errors: unsupported (built without Scotch), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts);

}  // namespace camber

export namespace camber {

/// Number of the part of each cell, from 0.
struct CellParts {
    Column<std::int32_t> elements, facets, edges;
};

/// Divides a mesh with Scotch. The result does not depend on the number of threads. Facets and feature edges get the
/// part of the lowest element that contains them (0 without such an element). The elements of a surface mesh are its
/// facets. Errors: usage (no parts, or more parts than elements), unsupported (built without Scotch), memory, stopped.
template <int D>
[[nodiscard]] Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution);

/// Computes the parts of facets and edges from those of elements (in a surface mesh: facets).
template <int D>
[[nodiscard]] Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                                const Execution& execution);

/// A part of a mesh as a separate mesh. Columns: for each entity of the part its number in the whole mesh, ascending.
template <class Mesh>
struct MeshPiece {
    Mesh mesh;
    Column<std::uint32_t> vertices, elements, facets, edges;
    Column<std::uint32_t> mid_nodes = {};  ///< numbers of edges in the whole mesh's edge set; empty for degree 1
};

/// Returns the cells of one part, with their nodes, corners, ridges and required entities. CAD associations and
/// directions are dropped. Errors: memory, stopped.
template <class Mesh>
[[nodiscard]] Outcome<MeshPiece<Mesh>> piece_of(const Mesh& mesh, const CellParts& parts, std::int32_t part,
                                                const Execution& execution);

}  // namespace camber
