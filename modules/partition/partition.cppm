module;
#include <cstddef>
#include <cstdint>
/// Divides a mesh into parts of about equal size with few common faces.
export module camber.partition;
import camber.core;

export namespace camber {

/// Neighbours across faces (in surface meshes: edges): element e has neighbours[starts[e], starts[e + 1]), ascending.
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

/// Part of each vertex of the graph, from 0. Errors: unsupported (built without Scotch), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts);

}  // namespace camber

export namespace camber {

/// Part of each cell, from 0.
struct CellParts {
    Column<std::int32_t> elements, facets, edges;
};

/// Divides a mesh with Scotch; the result does not depend on the number of threads. Facets and feature edges get the
/// part of their lowest element (0 without elements). Elements of a surface mesh are its facets. Errors: usage (no
/// parts, or more than elements), unsupported (built without Scotch), memory, stopped.
template <int D>
[[nodiscard]] Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution);

/// Extends parts of elements (in a surface mesh: facets) to facets and edges.
template <int D>
[[nodiscard]] Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                                const Execution& execution);

/// A part as a mesh, with ascending numbers of its entities in the whole mesh.
template <class Mesh>
struct MeshPiece {
    Mesh mesh;
    Column<std::uint32_t> vertices, elements, facets, edges;
    Column<std::uint32_t> mid_nodes = {};  ///< numbers of edges in the edge set; empty for degree 1
};

/// Returns the cells of one part with their nodes, corners, ridges and required entities, without CAD associations and
/// directions. Errors: memory, stopped.
template <class Mesh>
[[nodiscard]] Outcome<MeshPiece<Mesh>> piece_of(const Mesh& mesh, const CellParts& parts, std::int32_t part,
                                                const Execution& execution);

}  // namespace camber
