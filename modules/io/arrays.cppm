module;
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>
export module camber.io:arrays;
import camber.core;
import camber.bezier;
import :any_mesh;
import :notice;

/// Meshes as programs hand them on in memory: coordinates, and nodes of cells in VTK's order.
export namespace camber {

/// K-simplices of one degree, of `Nodes` nodes each, which count the points from 0.
template <int Nodes>
struct CellArray {
    Column<std::array<VertexId, Nodes>> nodes = {};
    Column<Reference> references = {};  ///< one a cell; none: 0 of all
};
template <int K>
struct CellArrays {
    CellArray<K + 1> straight = {};
    CellArray<quadratic_nodes<K>> curved = {};  ///< mid nodes as `local_edges` has the edges

    [[nodiscard]] std::size_t size() const { return straight.nodes.size() + curved.nodes.size(); }
};

template <int D>
struct MeshArrays {
    Column<Vec<D>> points;                    ///< nodes of degree 2 among them
    Column<Reference> point_references = {};  ///< one a point; none: 0 of all
    CellArrays<D> elements = {};
    CellArrays<D - 1> facets = {};
    CellArrays<1> edges = {};  ///< feature edges of a mesh in 3D
    std::vector<Group> groups = {};
};

/// Coordinates, D of each point, as a column: the array of somebody else who leaves it as it is (see Column), or a copy
/// where nobody does.
template <int D>
[[nodiscard]] Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner);

/// The mesh: of degree 1, which shares the columns, or of degree 2, whose vertices come first, in their order
/// (DecodedMesh::node_numbers says which point each node was). Triangles in one plane z = constant stay in space: see
/// `with_flat_in_2d`. Errors: input, a coordinate that is not finite, a cell that has a node which is no point or one
/// twice, mid nodes that contradict each other; memory, stopped.
template <int D>
[[nodiscard]] Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution);

/// Nodes of the simplices of a mesh of degree 2 in VTK's order: vertices, then n plus the edge's number for its node,
/// where n is the number of vertices.
template <int K>
[[nodiscard]] Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n);

}  // namespace camber
