module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
/// Meshes of degree 1 to 5 with several element shapes.
export module camber.core:mesh;
import :columns;
import :execution;
import :outcome;
import :shape;
import :simplices;
import :tensors;

export namespace camber {

inline constexpr int max_degree = 5;

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

/// Vertices of a cell, in the order of `shape_table`.
template <Shape shape>
using ShapeVertices = std::array<VertexId, shape_table<shape>.corner_count>;

/// Cells of one shape; see `Simplices`.
template <Shape shape>
struct Cells {
    Column<ShapeVertices<shape>> vertices;
    Column<Reference> references;
    Column<std::uint32_t> required;
    Column<Reference> entities = {};

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
    friend bool operator==(const Cells&, const Cells&) = default;
};

/// Ids of the unique edges of each cell, in the order of `shape_table`. Empty for degree 1.
template <Shape shape>
struct EdgesOfCells {
    Column<std::array<EdgeId, shape_table<shape>.edge_count>> ids;
    friend bool operator==(const EdgesOfCells&, const EdgesOfCells&) = default;
};

/// Ids of the unique faces of each cell in 3D: faces of a solid in the order of `shape_table`, or the 2D cell itself.
/// Faces without inner nodes at the mesh's degree have invalid ids; the column is empty if no face has any.
template <Shape shape>
struct FacesOfCells {
    Column<std::array<FaceId, shape_table<shape>.dimension == 2 ? 1 : shape_table<shape>.face_count>> ids;
    friend bool operator==(const FacesOfCells&, const FacesOfCells&) = default;
};

/// Unique edges and faces with inner nodes. The inner nodes are numbered from the first corner: on an edge, towards the
/// second corner; on a triangle, first towards the second corner, then towards the third; on a quadrilateral, first
/// towards the second corner, then towards the fourth.
template <int D>
struct MeshEntities {
    Column<std::array<VertexId, 2>> edges;           ///< from degree 2 on; lower vertex first; sorted rows
    Column<std::array<VertexId, 3>> triangles;       ///< 3D, from degree 3 on; ascending vertices; sorted rows
    Column<std::array<VertexId, 4>> quadrilaterals;  ///< 3D, from degree 2 on; each from its lowest vertex, then its
                                                     ///< lower neighbour in the cycle; sorted rows
    ByShape<D, EdgesOfCells> edges_of_elements;
    ByShape<D - 1, EdgesOfCells> edges_of_facets;
    Column<EdgeId> edges_of_edges;
    ByShape<D, FacesOfCells> faces_of_elements;
    ByShape<D - 1, FacesOfCells> faces_of_facets;

    friend bool operator==(const MeshEntities&, const MeshEntities&) = default;
};

/// A mesh of one degree from 1 to 5 with elements of any shapes of dimension D, stored in immutable columns. Nodes are
/// points on the geometry, equispaced in the reference element. Each node is stored once, with the vertex, edge, face
/// or element that has it in its interior, so that elements share nodes. The nodes of an element follow from its
/// vertices and the ids of its edges and faces. Elements are numbered shape by shape. camber.soundness checks that
/// adjacent faces match.
template <int D>
struct Mesh {
    static constexpr int dimension = D;

    int degree = 1;
    Column<Vec<D>> points;
    Column<LagrangeNode<D>> edge_nodes;  ///< degree − 1 nodes for each edge
    Column<Vec<D>> face_nodes;           ///< 3D: nodes of triangles, then of quadrilaterals
    Column<Vec<D>> inner_nodes;          ///< element by element, in the order of `lagrange_nodes`
    Column<Reference> point_references;
    Column<VertexId> corners;  ///< end points and corners of feature curves
    Column<VertexId> required_vertices;
    ByShape<D, Cells> elements;
    ByShape<D - 1, Cells> facets;  ///< boundary and material interfaces
    Cells<Shape::line> edges;
    Column<std::uint32_t> ridges;  ///< indices into `edges` (3D) or `facets` (2D)
    InputGeometry<D> geometry;
    Column<Group> groups = {};
    MeshEntities<D> entities;

    friend bool operator==(const Mesh&, const Mesh&) = default;
};

template <int D>
[[nodiscard]] std::size_t count_elements(const Mesh<D>& mesh) {
    std::size_t count = 0;
    each_shape<D>([&]<Shape shape>() { count += mesh.elements.template of<shape>().size(); });
    return count;
}

template <int D>
[[nodiscard]] bool is_standalone_surface(const Mesh<D>& mesh) {
    std::size_t facets = 0;
    each_shape<D - 1>([&]<Shape shape>() { facets += mesh.facets.template of<shape>().size(); });
    return D == 3 && count_elements(mesh) == 0 && facets > 0;
}

template <int D>
[[nodiscard]] std::size_t count_nodes(const Mesh<D>& mesh) {
    return mesh.points.size() + mesh.edge_nodes.size() + mesh.face_nodes.size() + mesh.inner_nodes.size();
}

// Conversion between general and simplicial meshes. All columns are shared, without copies.

template <int D>
[[nodiscard]] Mesh<D> as_mesh(LinearMesh<D> mesh);
template <int D>
[[nodiscard]] Mesh<D> as_mesh(QuadraticMesh<D> mesh);

/// Errors (unsupported): the degree is not 1, or there are non-simplices.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> as_linear(Mesh<D> mesh);
/// Errors (unsupported): the degree is not 2, or there are non-simplices.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> as_quadratic(Mesh<D> mesh);

/// Simplices of a mesh of any degree as a straight mesh, without cells of other shapes.
template <int D>
[[nodiscard]] LinearMesh<D> straight_simplices(Mesh<D> mesh);

/// Calls f(mesh) → Outcome with the mesh as a LinearMesh or QuadraticMesh. Errors (unsupported): a higher degree, or
/// non-simplices.
template <int D, class F>
[[nodiscard]] auto on_simplices(Mesh<D> mesh, F&& f) -> decltype(f(LinearMesh<D>{})) {
    if (mesh.degree > 2)
        return fail(ErrorKind::unsupported, "is of degree " + std::to_string(mesh.degree) +
                                                ", but this operation needs a mesh of degree 1 or "
                                                "2");
    if (mesh.degree == 2) {
        auto quadratic = as_quadratic(std::move(mesh));
        if (!quadratic) return fail(std::move(quadratic.error()));
        return f(std::move(*quadratic));
    }
    auto linear = as_linear(std::move(mesh));
    if (!linear) return fail(std::move(linear.error()));
    return f(std::move(*linear));
}

/// Raises the degree of a linear mesh without a change of its geometry, and adds its unique edges and faces. Node
/// positions follow from the linear corner functions (pyramids: those of the collapsed hexahedron). Errors: usage (the
/// mesh is not of degree 1, or `degree` is not from 1 to 5), input (a cell with a repeated or invalid vertex),
/// unsupported (too many edges or faces), stopped.
template <int D>
[[nodiscard]] Outcome<Mesh<D>> elevate(Mesh<D> mesh, int degree, const Execution& execution);

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

/// Positions of the nodes of an element, in the order of `lagrange_nodes`.
template <Shape shape, int degree, int D>
struct Element {
    std::array<Vec<D>, element_nodes<shape, degree>> nodes;
    friend bool operator==(const Element&, const Element&) = default;
};

}  // namespace camber

namespace camber {

/// Returns a number for the orientation of an element's face relative to the unique face. Triangle: three bits, for v0
/// < v1, v0 < v2 and v1 < v2. Quadrilateral: twice the position of the lowest vertex, plus 1 if the next vertex is
/// lower than the previous one.
[[nodiscard]] constexpr int orientation_of(const std::array<VertexId, 3>& v) {
    return (v[0] < v[1] ? 1 : 0) + (v[0] < v[2] ? 2 : 0) + (v[1] < v[2] ? 4 : 0);
}
[[nodiscard]] constexpr int orientation_of(const std::array<VertexId, 4>& v) {
    int lowest = 0;
    for (int i = 1; i < 4; ++i)
        if (v[i] < v[lowest]) lowest = i;
    return 2 * lowest + (v[(lowest + 1) % 4] < v[(lowest + 3) % 4] ? 1 : 0);
}

/// Returns, for each corner of the unique face, its position among the element's face vertices.
[[nodiscard]] constexpr std::array<int, 4> corners_by_orientation(Shape shape, int orientation) {
    if (shape == Shape::quadrilateral) {
        const int first = orientation / 2, step = orientation % 2 == 1 ? 1 : 3;
        return {first, (first + step) % 4, (first + 2) % 4, (first + 3 * step) % 4};
    }
    std::array<int, 4> at{};
    const std::array<bool, 3> below{(orientation & 1) != 0, (orientation & 2) != 0,
                                    (orientation & 4) != 0};  // bits of v0 < v1, v0 < v2 and v1 < v2
    const std::array<int, 3> rank{(below[0] ? 0 : 1) + (below[1] ? 0 : 1), (below[0] ? 1 : 0) + (below[2] ? 0 : 1),
                                  (below[1] ? 1 : 0) + (below[2] ? 1 : 0)};
    for (int i = 0; i < 3; ++i) at[rank[i]] = i;
    return at;
}

/// Gives, for each inner node of an element's face, its position among the inner nodes of the unique face.
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
        for (int n = 0; n < count; ++n) {  // steps from the first corner of the unique face along its two directions
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

template <int degree, int D>
void append_edge(const Mesh<D>& mesh, VertexId a, VertexId b, EdgeId id, Vec<D>*& out) {
    const std::size_t first = id.index() * (degree - 1);
    for (int n = 0; n < degree - 1; ++n) *out++ = mesh.edge_nodes[first + (a < b ? n : degree - 2 - n)].point;
}

/// Collects the nodes of cell i of `cells`. `inner` is the index of its first inner node.
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

/// Calls f with the degree as a constant. Aborts for a degree outside 1 to max_degree.
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

template <Shape shape_, int degree_, int D>
class CellBlock {
  public:
    static constexpr Shape shape = shape_;
    static constexpr int degree = degree_;

    CellBlock(const Mesh<D>& mesh, std::size_t first, std::size_t inner) : mesh_(&mesh), first_(first), inner_(inner) {}

    [[nodiscard]] std::size_t size() const { return cells().size(); }
    /// Number of this block's first cell among all cells of its dimension.
    [[nodiscard]] std::size_t first() const { return first_; }
    [[nodiscard]] const Cells<shape>& cells() const {
        if constexpr (dimension == D)
            return mesh_->elements.template of<shape>();
        else if constexpr (dimension == D - 1)
            return mesh_->facets.template of<shape>();
        else
            return mesh_->edges;
    }
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

/// Calls f(block) for each shape in the mesh: elements (K = D), facets (K = D − 1) or feature edges (K = 1 in 3D).
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
