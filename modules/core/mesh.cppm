module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
/// Meshes of degree 1 to 5 with elements of several shapes.
export module camber.core:mesh;
import :columns;
import :execution;
import :outcome;
import :shape;
import :simplices;
import :tensors;

export namespace camber {

/// The highest degree of a mesh.
inline constexpr int max_degree = 5;

/// Calls f.operator()<shape>() for each shape of dimension K, in the order of `Shape`.
template <int K, class F>
constexpr void each_shape(F&& f) {
    static_assert(K >= 1 && K <= 3);
    if constexpr (K == 1) {
        f.template operator()<Shape::line>();
    } else if constexpr (K == 2) {
        f.template operator()<Shape::triangle>();
        f.template operator()<Shape::quadrilateral>();
    } else {
        f.template operator()<Shape::tetrahedron>();
        f.template operator()<Shape::prism>();
        f.template operator()<Shape::pyramid>();
        f.template operator()<Shape::hexahedron>();
    }
}

/// One value T<shape> for each shape of dimension K.
template <int K, template <Shape> class T>
class ByShape {
  public:
    template <Shape shape>
    [[nodiscard]] const T<shape>& of() const {
        return std::get<T<shape>>(values_);
    }
    template <Shape shape>
    [[nodiscard]] T<shape>& of() {
        return std::get<T<shape>>(values_);
    }
    friend bool operator==(const ByShape&, const ByShape&) = default;

  private:
    using Values = std::conditional_t<
        K == 1, std::type_identity<std::tuple<T<Shape::line>>>,
        std::conditional_t<K == 2, std::type_identity<std::tuple<T<Shape::triangle>, T<Shape::quadrilateral>>>,
                           std::type_identity<std::tuple<T<Shape::tetrahedron>, T<Shape::prism>, T<Shape::pyramid>,
                                                         T<Shape::hexahedron>>>>>;
    typename Values::type values_;
};

/// The corners of a cell, in the order of `shape_table`.
template <Shape shape>
using ShapeVertices = std::array<VertexId, shape_table<shape>.corner_count>;

/// Cells of one shape, column by column: what `Simplices` has of simplices.
template <Shape shape>
struct Cells {
    Column<ShapeVertices<shape>> vertices;
    Column<Reference> references;     ///< one a cell
    Column<std::uint32_t> required;   ///< indices of those that must not change
    Column<Reference> entities = {};  ///< see Simplices

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
    friend bool operator==(const Cells&, const Cells&) = default;
};

/// The unique edges of cells of one shape, in the order of `shape_table`; no rows in a mesh of degree 1.
template <Shape shape>
struct EdgesOfCells {
    Column<std::array<EdgeId, shape_table<shape>.edge_count>> ids;
    friend bool operator==(const EdgesOfCells&, const EdgesOfCells&) = default;
};

/// The unique faces of cells of one shape in 3D: of solids in the order of `shape_table`; of a triangle or a
/// quadrilateral itself. A face whose shape has no nodes of its own at the mesh's degree has an invalid id; no rows
/// where that holds for all faces.
template <Shape shape>
struct FacesOfCells {
    Column<std::array<FaceId, shape_table<shape>.dimension == 2 ? 1 : shape_table<shape>.face_count>> ids;
    friend bool operator==(const FacesOfCells&, const FacesOfCells&) = default;
};

/// The unique edges and faces that have nodes of their own. Their nodes go from the first corner on: along an edge to
/// the second; on a triangle first towards the second corner, then towards the third; on a quadrilateral first towards
/// the second, then towards the fourth. How an element sees them follows from its own vertices.
template <int D>
struct MeshEntities {
    Column<std::array<VertexId, 2>> edges;           ///< lower vertex first, rising; from degree 2 on
    Column<std::array<VertexId, 3>> triangles;       ///< vertices rise, and rows; 3D, from degree 3 on
    Column<std::array<VertexId, 4>> quadrilaterals;  ///< round the rim: lowest vertex first, then its lower neighbour,
                                                     ///< rows rise; 3D, from degree 2 on
    ByShape<D, EdgesOfCells> edges_of_elements;
    ByShape<D - 1, EdgesOfCells> edges_of_facets;
    Column<EdgeId> edges_of_edges;  ///< of feature edges (3D)
    ByShape<D, FacesOfCells> faces_of_elements;
    ByShape<D - 1, FacesOfCells> faces_of_facets;

    friend bool operator==(const MeshEntities&, const MeshEntities&) = default;
};

/// A mesh of one degree from 1 to 5 whose elements have any shapes of dimension D: an immutable value of columns.
/// Nodes are equispaced in the reference element (points on the curves, no control points), each stored once, with the
/// vertex, edge, face or element that it is inside of; which an element has follows from its vertices, the ids of
/// its edges and faces, and constant tables. So elements that share an edge or a face share its nodes. (That sides of
/// elements which meet are equal faces is a matter of the vertices: a check of soundness.) Elements are numbered shape
/// by shape.
///
/// The nodes of edges have the type of `QuadraticMesh::mid_nodes`, so that meshes of degree 2 share the column.
template <int D>
struct Mesh {
    static constexpr int dimension = D;

    int degree = 1;                      ///< from 1 to max_degree
    Column<Vec<D>> points;               ///< of vertices
    Column<LagrangeNode<D>> edge_nodes;  ///< degree − 1 an edge
    Column<Vec<D>> face_nodes;           ///< 3D: of the triangles, then of the quadrilaterals
    Column<Vec<D>> inner_nodes;          ///< element by element, in the order of `lagrange_nodes`
    Column<Reference> point_references;  ///< one a vertex
    Column<VertexId> corners;            ///< vertices where curves break
    Column<VertexId> required_vertices;
    ByShape<D, Cells> elements;
    ByShape<D - 1, Cells> facets;  ///< of the boundary, and between materials
    Cells<Shape::line> edges;      ///< feature edges in 3D; none in 2D, where facets are the edges
    Column<std::uint32_t> ridges;  ///< indices into `edges` (3D) or the facets (2D)
    GivenGeometry<D> geometry;
    Column<Group> groups = {};
    MeshEntities<D> entities;

    friend bool operator==(const Mesh&, const Mesh&) = default;
};

/// Number of all elements.
template <int D>
[[nodiscard]] std::size_t count_elements(const Mesh<D>& mesh) {
    std::size_t count = 0;
    each_shape<D>([&]<Shape shape>() { count += mesh.elements.template of<shape>().size(); });
    return count;
}

/// Whether the mesh is a surface in space and no more: see the same function of LinearMesh.
template <int D>
[[nodiscard]] bool is_surface_alone(const Mesh<D>& mesh) {
    std::size_t facets = 0;
    each_shape<D - 1>([&]<Shape shape>() { facets += mesh.facets.template of<shape>().size(); });
    return D == 3 && count_elements(mesh) == 0 && facets > 0;
}

/// Number of all nodes.
template <int D>
[[nodiscard]] std::size_t count_nodes(const Mesh<D>& mesh) {
    return mesh.points.size() + mesh.edge_nodes.size() + mesh.face_nodes.size() + mesh.inner_nodes.size();
}

// Between the general mesh and those of simplices. All columns are shared; nothing is copied.

template <int D>
[[nodiscard]] Mesh<D> as_mesh(LinearMesh<D> mesh);
template <int D>
[[nodiscard]] Mesh<D> as_mesh(QuadraticMesh<D> mesh);

/// Errors: the degree is not 1, elements or facets are no simplices (ErrorKind::unsupported).
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> as_linear(Mesh<D> mesh);
/// Errors: the degree is not 2, elements or facets are no simplices (ErrorKind::unsupported).
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> as_quadratic(Mesh<D> mesh);

/// The simplices of a mesh of any degree by their vertices alone; cells of other shapes are not in it.
template <int D>
[[nodiscard]] LinearMesh<D> straight_simplices(Mesh<D> mesh);

/// f(mesh) with the mesh as LinearMesh or QuadraticMesh, by its degree: for code that takes simplices of degrees 1 and
/// 2; f returns an Outcome. Errors: a higher degree, elements or facets that are no simplices (ErrorKind::unsupported).
template <int D, class F>
[[nodiscard]] auto on_simplices(Mesh<D> mesh, F&& f) -> decltype(f(LinearMesh<D>{})) {
    if (mesh.degree > 2)
        return fail(ErrorKind::unsupported,
                    "is of degree " + std::to_string(mesh.degree) + ", and this needs one of degree 1 or 2");
    if (mesh.degree == 2) {
        auto quadratic = as_quadratic(std::move(mesh));
        if (!quadratic) return fail(std::move(quadratic.error()));
        return f(std::move(*quadratic));
    }
    auto linear = as_linear(std::move(mesh));
    if (!linear) return fail(std::move(linear.error()));
    return f(std::move(*linear));
}

/// The same mesh of degree 1 in another degree, with its edges and faces: nodes are where the linear functions of a
/// cell's vertices have them (on pyramids: those of the collapsed hexahedron), so no point of any element moves.
/// Errors: the mesh is not of degree 1, the degree is not from 1 to 5 (ErrorKind::usage), a cell that names a vertex
/// twice or one that does not exist (ErrorKind::input), too many edges or faces (ErrorKind::unsupported), stopped.
template <int D>
[[nodiscard]] Outcome<Mesh<D>> elevate(Mesh<D> mesh, int degree, const Execution& execution);

/// The same mesh with f(node) in the place of each node.
template <int D, class F>
[[nodiscard]] Mesh<D> map_nodes(Mesh<D> mesh, F&& f) {
    const auto map = [&](Column<Vec<D>>& column) {
        Buffer<Vec<D>> nodes = take(std::move(column));
        for (Vec<D>& p : nodes) p = f(std::as_const(p));
        column = std::move(nodes);
    };
    map(mesh.points);
    map(mesh.face_nodes);
    map(mesh.inner_nodes);
    Buffer<LagrangeNode<D>> of_edges = take(std::move(mesh.edge_nodes));
    for (auto& [p] : of_edges) p = f(std::as_const(p));
    mesh.edge_nodes = std::move(of_edges);
    return mesh;
}

/// The nodes of a cell in the order of `lagrange_nodes`: what kernels gather.
template <Shape shape, int degree, int D>
struct Element {
    std::array<Vec<D>, element_nodes<shape, degree>> nodes;
    friend bool operator==(const Element&, const Element&) = default;
};

}  // namespace camber

namespace camber {

/// The orientation of a face within its unique face, as a number: of a triangle which of its vertices are lower than
/// which, of a quadrilateral the position of the lowest one and on which side of it the lower neighbour is.
[[nodiscard]] constexpr int orientation_of(const std::array<VertexId, 3>& v) {
    return (v[0] < v[1] ? 1 : 0) + (v[0] < v[2] ? 2 : 0) + (v[1] < v[2] ? 4 : 0);
}
[[nodiscard]] constexpr int orientation_of(const std::array<VertexId, 4>& v) {
    int lowest = 0;
    for (int i = 1; i < 4; ++i)
        if (v[i] < v[lowest]) lowest = i;
    return 2 * lowest + (v[(lowest + 1) % 4] < v[(lowest + 3) % 4] ? 1 : 0);
}

/// Returns the positions of a face's vertices in the order of the unique face.
[[nodiscard]] constexpr std::array<int, 4> corners_by_orientation(Shape shape, int orientation) {
    if (shape == Shape::quadrilateral) {
        const int first = orientation / 2, step = orientation % 2 == 1 ? 1 : 3;
        return {first, (first + step) % 4, (first + 2) % 4, (first + 3 * step) % 4};
    }
    std::array<int, 4> at{};
    const std::array<bool, 3> below{(orientation & 1) != 0, (orientation & 2) != 0,
                                    (orientation & 4) != 0};  // 0 < 1, 0 < 2, 1 < 2
    const std::array<int, 3> rank{(below[0] ? 0 : 1) + (below[1] ? 0 : 1), (below[0] ? 1 : 0) + (below[2] ? 0 : 1),
                                  (below[1] ? 1 : 0) + (below[2] ? 1 : 0)};
    for (int i = 0; i < 3; ++i) at[rank[i]] = i;
    return at;
}

/// Positions of a face's inner nodes among the nodes of the unique face, for each orientation.
template <Shape shape, int degree>
inline constexpr auto nodes_by_orientation = [] {
    constexpr int count = inner_node_count(shape, degree);
    constexpr int first = element_nodes<shape, degree> - count;
    constexpr auto& lattice = lagrange_nodes<shape, degree>;
    constexpr auto& corners = shape_table<shape>.coordinates;
    std::array<std::array<std::uint8_t, count>, 8> nodes{};
    for (int orientation = 0; orientation < 8; ++orientation) {
        const auto at = corners_by_orientation(shape, orientation);
        const int last = shape == Shape::quadrilateral ? 3 : 2;
        for (int n = 0; n < count; ++n) {  // steps from the unique face's first corner along its two directions
            std::array<int, 2> to{};
            for (int d = 0; d < 2; ++d) {
                to[d] = lattice[first + n][d];
                if (shape == Shape::quadrilateral) to[d] -= degree * corners[at[0]][d];
            }
            std::array<int, 2> steps{};
            if (shape == Shape::quadrilateral) {
                for (int d = 0; d < 2; ++d) {
                    steps[0] += to[d] * (corners[at[1]][d] - corners[at[0]][d]);
                    steps[1] += to[d] * (corners[at[last]][d] - corners[at[0]][d]);
                }
            } else {
                const std::array<int, 3> weights{degree - to[0] - to[1], to[0], to[1]};
                steps = {weights[at[1]], weights[at[last]]};
            }
            for (int m = 0; m < count; ++m)
                if (lattice[first + m][0] == steps[0] && lattice[first + m][1] == steps[1])
                    nodes[orientation][n] = static_cast<std::uint8_t>(m);
        }
    }
    return nodes;
}();

/// Appends the inner nodes of a unique face as a face with these vertices has them.
template <Shape face, int degree, int D, std::size_t N>
void append_face(const Mesh<D>& mesh, const std::array<VertexId, N>& vertices, FaceId id, Vec<D>*& out) {
    constexpr std::size_t count = inner_node_count(face, degree);
    if constexpr (count > 0) {
        std::size_t first = id.index() * count;
        if constexpr (face == Shape::quadrilateral)
            first += mesh.entities.triangles.size() * inner_node_count(Shape::triangle, degree);
        for (const std::uint8_t at : nodes_by_orientation<face, degree>[orientation_of(vertices)])
            *out++ = mesh.face_nodes[first + at];
    }
}

/// Appends the inner nodes of a unique edge from vertex a to vertex b.
template <int degree, int D>
void append_edge(const Mesh<D>& mesh, VertexId a, VertexId b, EdgeId id, Vec<D>*& out) {
    const std::size_t first = id.index() * (degree - 1);
    for (int n = 0; n < degree - 1; ++n) *out++ = mesh.edge_nodes[first + (a < b ? n : degree - 2 - n)].point;
}

/// Cell i of a list, with the edges and faces of the same list.
template <Shape shape, int degree, int D>
[[nodiscard]] Element<shape, degree, D> gather(const Mesh<D>& mesh, const Cells<shape>& cells,
                                               const EdgesOfCells<shape>& edges, const FacesOfCells<shape>& faces,
                                               std::size_t inner, std::size_t i) {
    constexpr const ShapeTable& table = shape_table<shape>;
    Element<shape, degree, D> element;
    Vec<D>* out = element.nodes.data();
    const ShapeVertices<shape>& vertices = cells.vertices[i];
    for (const VertexId v : vertices) *out++ = mesh.points[v];
    if constexpr (degree > 1) {
        for (int e = 0; e < table.edge_count; ++e)
            append_edge<degree, D>(mesh, vertices[table.edges[e][0]], vertices[table.edges[e][1]], edges.ids[i][e],
                                   out);
        if constexpr (D == 3 && table.dimension == 2 && inner_node_count(shape, degree) > 0) {
            append_face<shape, degree, D>(mesh, vertices, faces.ids[i][0], out);
        } else if constexpr (table.dimension == 3) {
            for (int f = 0; f < table.face_count; ++f) {
                const auto& [face, at] = table.faces[f];
                if (face == Shape::triangle) {
                    if constexpr (inner_node_count(Shape::triangle, degree) > 0)
                        append_face<Shape::triangle, degree, D>(
                            mesh, std::array{vertices[at[0]], vertices[at[1]], vertices[at[2]]}, faces.ids[i][f], out);
                } else {
                    append_face<Shape::quadrilateral, degree, D>(
                        mesh, std::array{vertices[at[0]], vertices[at[1]], vertices[at[2]], vertices[at[3]]},
                        faces.ids[i][f], out);
                }
            }
        }
        if constexpr (table.dimension == D)
            for (int n = 0; n < inner_node_count(shape, degree); ++n)
                *out++ = mesh.inner_nodes[inner + i * inner_node_count(shape, degree) + n];
    }
    return element;
}

/// Calls f.operator()<degree>() for a degree from 1 to max_degree; others end the program.
template <class F>
auto at_degree(int degree, F&& f) {
    switch (degree) {
        case 2: return f.template operator()<2>();
        case 3: return f.template operator()<3>();
        case 4: return f.template operator()<4>();
        case 5: return f.template operator()<5>();
        case 1: return f.template operator()<1>();
        default: std::abort();
    }
}

}  // namespace camber

export namespace camber {

/// The elements, the facets or, in 3D, the feature edges of a mesh that have one shape; refers to the mesh.
template <Shape shape_, int degree_, int D>
class CellBlock {
  public:
    static constexpr Shape shape = shape_;
    static constexpr int degree = degree_;

    CellBlock(const Mesh<D>& mesh, std::size_t first, std::size_t inner) : mesh_(&mesh), first_(first), inner_(inner) {}

    [[nodiscard]] std::size_t size() const { return cells().size(); }
    /// The number of its first cell among all elements (or facets) of the mesh.
    [[nodiscard]] std::size_t first() const { return first_; }
    [[nodiscard]] const Cells<shape>& cells() const {
        if constexpr (dimension == D)
            return mesh_->elements.template of<shape>();
        else if constexpr (dimension == D - 1)
            return mesh_->facets.template of<shape>();
        else
            return mesh_->edges;
    }
    /// The nodes of cell i of the block.
    [[nodiscard]] Element<shape, degree, D> operator[](std::size_t i) const {
        const MeshEntities<D>& of = mesh_->entities;
        if constexpr (dimension == D) {
            return gather<shape, degree, D>(*mesh_, cells(), of.edges_of_elements.template of<shape>(),
                                            of.faces_of_elements.template of<shape>(), inner_, i);
        } else if constexpr (dimension == D - 1) {
            return gather<shape, degree, D>(*mesh_, cells(), of.edges_of_facets.template of<shape>(),
                                            of.faces_of_facets.template of<shape>(), inner_, i);
        } else {
            const auto& [a, b] = mesh_->edges.vertices[i];
            Element<shape, degree, D> edge{{mesh_->points[a], mesh_->points[b]}};
            Vec<D>* out = edge.nodes.data() + 2;
            if constexpr (degree > 1) append_edge<degree, D>(*mesh_, a, b, of.edges_of_edges[i], out);
            return edge;
        }
    }

  private:
    static constexpr int dimension = shape_table<shape_>.dimension;

    const Mesh<D>* mesh_;
    std::size_t first_, inner_;
};

/// Calls f(block) for the elements (K = D), the facets (K = D − 1) or the feature edges (K = 1 in 3D) of each shape
/// that the mesh has, with a CellBlock of its degree: so kernels are templates on shape and degree, and are chosen once
/// a block.
template <int K, int D, class F>
void each_block_of(const Mesh<D>& mesh, F&& f) {
    static_assert(K == D || K == D - 1 || K == 1);
    at_degree(mesh.degree, [&]<int degree>() {
        std::size_t first = 0, inner = 0;
        each_shape<K>([&]<Shape shape>() {
            const CellBlock<shape, degree, D> block(mesh, first, inner);
            if (block.size() > 0) f(block);
            first += block.size();
            if (K == D) inner += block.size() * inner_node_count(shape, degree);
        });
    });
}
template <int D, class F>
void each_block(const Mesh<D>& mesh, F&& f) {
    each_block_of<D>(mesh, f);
}

}  // namespace camber
