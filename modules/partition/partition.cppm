module;
#include <cstddef>
#include <cstdint>
/// A mesh in parts, for solvers on several processes: parts of about as many elements each, with few faces between
/// them, and each of them as a mesh by itself that knows its place in the whole.
export module camber.partition;
import camber.core;

export namespace camber {

/// Elements and those across their faces, in rising order: of element e neighbours[starts[e], starts[e + 1]). Of a
/// surface alone the triangles and those across their edges.
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

/// By the library that is there. Errors: unsupported (there is none), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts);

}  // namespace camber

export namespace camber {

/// The part of each cell, from 0.
struct CellParts {
    Column<std::int32_t> elements, facets, edges;
};

/// Parts of about as many elements each, by Scotch: the same for any number of threads. A facet, and a feature edge, is
/// of the part of the lowest element that it belongs to (of part 0 if of none). The elements of a surface alone are its
/// facets. Errors: usage (no parts, or more than
/// elements), unsupported (Camber was built without Scotch), memory, stopped.
template <int D>
[[nodiscard]] Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution);

/// The same of facets and edges where the parts of the elements (of a surface alone of its facets) are known.
template <int D>
[[nodiscard]] Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                                const Execution& execution);

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
