module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
export module camber.drawing:faces;
import camber.core;

/// What of a mesh is to be seen: faces with all their nodes, and their edges.
export namespace camber {

/// A node by its number from 0: the vertices, then the nodes of the edge set's edges.
using NodeNumber = std::uint32_t;

/// How a face comes to be seen.
enum class FaceKind : std::uint8_t {
    boundary,   ///< no element behind it; of a surface alone all
    uncovered,  ///< the element behind it is left out
    plane,      ///< an element of a 2D mesh, itself
};

/// A triangle of degree 2. In 3D its corners turn counter-clockwise seen from outside of its element; in 2D they are
/// the element's own.
struct Face {
    std::array<NodeNumber, 6> nodes{};  ///< corners, then those of the edges 01, 12, 20
    std::uint32_t element = 0;          ///< of which it is seen; of a surface alone the number of the facet
    Reference reference = 0;            ///< of the facet that stands there (0: none is listed), else of the element
    FaceKind kind = FaceKind::boundary;
    friend bool operator==(const Face&, const Face&) = default;
};

/// An edge of faces.
struct FaceEdge {
    std::array<NodeNumber, 3> nodes{};  ///< both ends, then the middle
    std::uint32_t faces = 0;            ///< how many faces have it; 1: a rim
    friend bool operator==(const FaceEdge&, const FaceEdge&) = default;
};

/// What lies beyond a plane, dot(normal, x) > offset, is cut away.
template <int D>
struct Cut {
    Vec<D> normal{};
    double offset = 0;
};

/// A number an element (of a surface alone: a facet): 1 where it stays, since its centroid, that of its vertices, does
/// not lie beyond the plane; else 0. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<std::uint8_t>> kept_by(const Cut<D>& cut, const LinearMesh<D>& mesh,
                                                    const Execution& execution);

/// The faces to be seen of the elements that are kept (`kept` as `kept_by` has it; empty: all), by rising element: in
/// 3D faces with one kept element on them, in 2D the elements, of a surface alone its facets. A mesh of degree 1 is
/// elevated first. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const QuadraticMesh<D>& mesh, std::span<const std::uint8_t> kept,
                                                  const Execution& execution);

/// The edges of the faces, each once, in the order of the mesh's edge set.
template <int D>
[[nodiscard]] Column<FaceEdge> edges_to_draw(const QuadraticMesh<D>& mesh, std::span<const Face> faces);

/// Where a node is.
template <int D>
[[nodiscard]] inline Vec<D> node_point(const QuadraticMesh<D>& mesh, NodeNumber node) {
    const std::size_t vertices = mesh.linear.points.size();
    return node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point;
}

}  // namespace camber
