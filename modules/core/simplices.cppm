module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
/// Simplicial meshes of degree 1 and 2, and their topology.
export module camber.core:simplices;
import :columns;
import :execution;
import :outcome;
import :shape;
import :tensors;

export namespace camber {

template <int K>
using SimplexVertices = std::array<VertexId, K + 1>;

template <int K>
inline constexpr int edges_per_simplex = K * (K + 1) / 2;

/// Local edges for K = 1, 2, 3, in the order of GMF and VTK: e01 e12 e20 e03 e13 e23.
template <int K>
inline constexpr auto local_edges = [] {
    std::array<std::array<int, 2>, edges_per_simplex<K>> edges{};
    for (int i = 0; i < edges_per_simplex<K>; ++i) edges[i] = shape_table<simplex<K>>.edges[i];
    return edges;
}();

/// Vertices of the face opposite local vertex i. Its normal is outward for elements of positive orientation (K = 2:
/// counter-clockwise).
template <int K>
[[nodiscard]] constexpr std::array<int, K> face_opposite(int i) {
    if constexpr (K == 2) {
        return local_edges<2>[(i + 1) % 3];
    } else {
        const auto& corners = shape_table<Shape::tetrahedron>.faces[i].corners;
        return {corners[0], corners[1], corners[2]};
    }
}

template <int K>
struct Simplices {
    Column<SimplexVertices<K>> vertices;
    Column<Reference> references;
    Column<std::uint32_t> required;  ///< indices of simplices that must not change
    /// Geometric entity of dimension K for each simplex, numbered by the mesh generator. 0: unknown; empty column: no
    /// associations.
    Column<Reference> entities = {};

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
    friend bool operator==(const Simplices&, const Simplices&) = default;
};

/// A vertex, and the index `row` of one of its directions in the table.
struct DirectionRow {
    VertexId vertex;
    std::uint32_t row = 0;
    friend bool operator==(const DirectionRow&, const DirectionRow&) = default;
};
/// Directions at vertices, as a table. Vertices may share a row. A vertex has several directions where a surface or a
/// curve is not smooth. The length and sign of a direction have no meaning.
template <int D>
struct DirectionsAtVertices {
    Column<Vec<D>> table;
    Column<DirectionRow> at;
    friend bool operator==(const DirectionsAtVertices&, const DirectionsAtVertices&) = default;
};

/// Associates a mesh item with a point (G = 0), curve (1) or surface (2) of a CAD model or of a generator's
/// classification.
template <int G, class Item = VertexId>
struct Association {
    Item item;
    Reference entity = 0;  ///< numbered by the mesh generator within dimension G
    /// Parameters of the item: t on a curve, (u, v) on a surface. None if they are unknown or the entity is a point.
    std::optional<std::array<double, G>> parameters = {};
    std::optional<double> distance = {};  ///< distance between the item and the position with these parameters (model
                                          ///< units); none: unknown
    friend bool operator==(const Association&, const Association&) = default;
};

/// Geometry data of the mesh file, preserved from input to output. `camber.surface` uses normals and tangents if they
/// agree with the mesh. An item may have several associations: a vertex on a curve also has positions on adjacent
/// surfaces.
template <int D>
struct InputGeometry {
    DirectionsAtVertices<D> normals;   ///< normals of the surface (2D: boundary)
    DirectionsAtVertices<D> tangents;  ///< tangents of ridges (2D: boundary)
    Column<Association<0>> on_points;
    Column<Association<1>> on_curves;
    Column<Association<2>> on_surfaces;
    friend bool operator==(const InputGeometry&, const InputGeometry&) = default;
};

/// Name of the entities with a given dimension and reference: physical group of Gmsh, boundary condition or solver
/// marker. If simplices are in several groups, a reference has several names.
struct Group {
    int dimension = 0;
    Reference reference = 0;
    std::string name;
    friend bool operator==(const Group&, const Group&) = default;
};

/// A straight mesh of D-simplices, stored in immutable columns. The elements of a sound mesh have positive volume.
/// `facets`: boundary and interfaces (triangles in 3D, edges in 2D); `edges`: feature edges in 3D, empty in 2D.
template <int D>
struct LinearMesh {
    static constexpr int dimension = D;

    Column<Vec<D>> points;
    Column<Reference> point_references;
    Column<VertexId> corners;  ///< end points and corners of feature curves
    Column<VertexId> required_vertices;
    Simplices<D> elements;
    Simplices<D - 1> facets;
    Simplices<1> edges;
    Column<std::uint32_t> ridges;  ///< indices into `edges` (3D) or `facets` (2D)
    InputGeometry<D> geometry;
    Column<Group> groups = {};  ///< the first group with a dimension and reference is the main one

    friend bool operator==(const LinearMesh&, const LinearMesh&) = default;
};

/// True for a standalone surface mesh. Checks and fields then use its facets, and an ElementId is the index of a facet.
template <int D>
[[nodiscard]] inline bool is_standalone_surface(const LinearMesh<D>& mesh) {
    return D == 3 && mesh.elements.size() == 0 && mesh.facets.size() > 0;
}

/// Unique edges, sorted by (lower vertex, higher vertex). The edges of each simplex are in the order of `local_edges`.
template <int D>
struct EdgeSet {
    Column<std::array<VertexId, 2>> vertices;
    Column<std::array<EdgeId, edges_per_simplex<D>>> of_elements;
    Column<std::array<EdgeId, edges_per_simplex<D - 1>>> of_facets;
    Column<EdgeId> of_edges;

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
    friend bool operator==(const EdgeSet&, const EdgeSet&) = default;
};

/// Point of a P2 edge at t = 1/2. The Bézier control point (camber.bezier: ControlPoint) is another point, with its own
/// type: P_11 = (4 P^l − P_20 − P_02)/2, where P^l is the Lagrange node.
template <int D>
struct LagrangeNode {
    Vec<D> point;
    friend bool operator==(const LagrangeNode&, const LagrangeNode&) = default;
};

/// A quadratic (P2) mesh: straight mesh, unique edges, and a **Lagrange** node for each edge. It is conforming, because
/// elements share edge nodes.
template <int D>
struct QuadraticMesh {
    static constexpr int dimension = D;

    LinearMesh<D> linear;
    EdgeSet<D> edges;
    Column<LagrangeNode<D>> mid_nodes;

    friend bool operator==(const QuadraticMesh&, const QuadraticMesh&) = default;
};

/// Location of an edge, which determines how its node may move.
enum class EdgeKind : std::uint8_t {
    volume,   ///< in the volume; its node is free
    surface,  ///< on a smooth part of a boundary or interface
    ridge,    ///< on a curve where the boundary or interface is not smooth
    fixed,    ///< on the boundary of a cavity, shared with elements outside it
};

/// Last change of an edge node before the commit.
enum class EdgeChange : std::uint8_t {
    straight,  ///< chord midpoint
    projected,
    optimised,
    relaxed,       ///< moved to make elements valid, mostly towards the midpoint
    straightened,  ///< moved back to the midpoint
};

/// Proposed positions of vertices and mid nodes. `validate` checks a proposal, `relax` and `repair` repair it, and
/// `commit` applies it.
template <int D>
struct Proposal {
    Column<Vec<D>> points;  ///< the mesh's own column if no vertex moves
    Column<LagrangeNode<D>> mid_nodes;
    Column<EdgeKind> kinds;
    Column<EdgeChange> changes;
    friend bool operator==(const Proposal&, const Proposal&) = default;
};

/// Mesh with the proposed positions, for inspection only; use `commit` to apply a proposal.
template <int D>
[[nodiscard]] inline QuadraticMesh<D> apply_proposal(QuadraticMesh<D> mesh, const Proposal<D>& proposal) {
    mesh.linear.points = proposal.points;
    mesh.mid_nodes = proposal.mid_nodes;
    return mesh;
}

template <int K>
inline constexpr const char* simplex_name = name_of(simplex<K>);

// Lagrange functions of degree 2 on a K-simplex in barycentric coordinates.

[[nodiscard]] constexpr double vertex_shape(double xi) { return xi * (2 * xi - 1); }

/// Lagrange function of the node of local edge e = (i, j): 4 ξ_i ξ_j. Its product with the node's offset from the chord
/// midpoint is the deviation from the linear map.
template <int K>
[[nodiscard]] constexpr double edge_shape(const std::array<double, K + 1>& xi, int e) {
    const auto [i, j] = local_edges<K>[e];
    return 4 * xi[i] * xi[j];
}

/// Adds the derivatives of edge_shape times `value` by ξ_a, a = 0 … K, to `partial`.
template <int K, class T>
constexpr void add_edge_derivatives(const std::array<double, K + 1>& xi, int e, const T& value,
                                    std::array<T, K + 1>& partial) {
    const auto [i, j] = local_edges<K>[e];
    partial[i] += (4 * xi[j]) * value;
    partial[j] += (4 * xi[i]) * value;
}

// Entities that must not change (Required entities of GMF files).

/// Marks required feature edges, and the edges of required facets and elements.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> required_edges(const QuadraticMesh<D>& mesh) {
    Buffer<std::uint8_t> marks(mesh.edges.size(), 0);
    for (const std::uint32_t s : mesh.linear.elements.required)
        for (const EdgeId e : mesh.edges.of_elements[s]) marks[e.index()] = 1;
    for (const std::uint32_t f : mesh.linear.facets.required)
        for (const EdgeId e : mesh.edges.of_facets[f]) marks[e.index()] = 1;
    for (const std::uint32_t e : mesh.linear.edges.required)
        if (e < mesh.edges.of_edges.size()) marks[mesh.edges.of_edges[e].index()] = 1;
    return marks;
}

/// Marks required vertices, and the vertices of required edges, facets and elements.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> required_vertices(const LinearMesh<D>& mesh) {
    Buffer<std::uint8_t> marks(mesh.points.size(), 0);
    for (const VertexId v : mesh.required_vertices) marks[v.index()] = 1;
    const auto mark = [&](const auto& simplices) {
        for (const std::uint32_t s : simplices.required)
            for (const VertexId v : simplices.vertices[s]) marks[v.index()] = 1;
    };
    mark(mesh.elements);
    mark(mesh.facets);
    mark(mesh.edges);
    return marks;
}

/// Required boundary edges that are fixed. `keep`: all required edges are fixed; `geometry`: only those in the volume.
enum class RequiredBoundary : std::uint8_t { keep, geometry };
[[nodiscard]] constexpr auto words(RequiredBoundary) {
    return words_of(Word{RequiredBoundary::keep, "keep"}, Word{RequiredBoundary::geometry, "geometry"});
}

template <int D>
[[nodiscard]] inline Column<EdgeKind> kinds_with_required_fixed(const QuadraticMesh<D>& mesh,
                                                                const Column<EdgeKind>& kinds,
                                                                RequiredBoundary boundary) {
    const auto required = required_edges(mesh);
    Buffer<EdgeKind> fixed_kinds(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < fixed_kinds.size(); ++e)
        if (required[e] != 0 && (boundary == RequiredBoundary::keep || kinds[e] == EdgeKind::volume))
            fixed_kinds[e] = EdgeKind::fixed;
    return Column<EdgeKind>(std::move(fixed_kinds));
}

template <int D>
[[nodiscard]] inline QuadraticMesh<D> without_required(QuadraticMesh<D> mesh) {
    mesh.linear.elements.required = {};
    mesh.linear.facets.required = {};
    mesh.linear.edges.required = {};
    return mesh;
}

/// Marks the ends of all edges that are not volume edges.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> boundary_vertices(const QuadraticMesh<D>& mesh,
                                                            const Column<EdgeKind>& kinds) {
    Buffer<std::uint8_t> marks(mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume)
            for (const VertexId v : mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

// Range of lengths in computations, in model units. Within this range, three kinds of values have full precision, also
// for very thin elements: products of four lengths (determinants of triangles' derivatives, squared areas), products of
// three lengths with their rounding errors, and squares of metric entries. Below 1e-77 and above 1e77 such values lose
// precision.

/// Minimum metric size. Elements and facets must also have at least this extent along one coordinate axis.
inline constexpr double min_length = 1e-60;
/// Maximum magnitude of coordinates and metric sizes.
inline constexpr double max_length = 1e60;

/// Compressed rows: for each key (vertex, edge …), the items at it, in ascending order.
template <class Item>
struct Incidence {
    Column<std::uint32_t> offsets;  ///< number of keys + 1
    Column<Item> items;

    [[nodiscard]] std::size_t size() const { return offsets.empty() ? 0 : offsets.size() - 1; }
    [[nodiscard]] std::span<const Item> operator[](std::size_t key) const {
        return {items.data() + offsets[key], items.data() + offsets[key + 1]};
    }
    template <class Tag>
    [[nodiscard]] std::span<const Item> operator[](Id<Tag> key) const {
        return (*this)[key.index()];
    }
};

/// For each local vertex of an element: the element across the opposite face, or an invalid id.
template <int D>
using Neighbours = Column<std::array<ElementId, D + 1>>;

struct ElementFace {
    ElementId element;
    std::uint32_t opposite = 0;
    friend bool operator==(const ElementFace&, const ElementFace&) = default;
};

/// Topology of a mesh. All vertex ids must be in range. Errors: more than two elements on a face (`neighbours`), a
/// repeated vertex in a simplex (`unique_edges`), more than 2^32 incidences; stopped.

template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> balls(const LinearMesh<D>& mesh, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Incidence<FacetId>> facet_balls(const LinearMesh<D>& mesh, const Execution& execution);

/// Returns the feature edges at each vertex, as indices into LinearMesh::edges.
template <int D>
[[nodiscard]] Outcome<Incidence<EdgeId>> feature_edge_balls(const LinearMesh<D>& mesh, const Execution& execution);

/// A face of an element, stored without its lowest vertex. `others` are its other vertices in ascending order.
template <int D>
struct FaceAround {
    std::array<VertexId, D - 1> others;
    ElementFace face;
};

/// Collects the faces of all elements whose lowest vertex is v. Equal faces are adjacent, in ascending order of
/// elements. Faces with a repeated vertex are skipped.
template <int D>
void faces_around(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, VertexId v,
                  std::vector<FaceAround<D>>& faces);

/// Calls visit(all elements on a face) for each face in parallel. `balls` belongs to the same mesh.
template <int D, class Visit>
[[nodiscard]] Outcome<Done> each_face(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                      const Execution& execution, Visit&& visit) {
    return each_chunk(execution, balls.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<FaceAround<D>> faces;
        for (std::size_t v = begin; v < end; ++v) {
            faces_around<D>(mesh, balls, VertexId(v), faces);
            for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
                while (last < faces.size() && faces[last].others == faces[first].others) ++last;
                visit(std::span<const FaceAround<D>>(faces).subspan(first, last - first));
            }
        }
    });
}

template <int D>
[[nodiscard]] Outcome<Neighbours<D>> neighbours(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                const Execution& execution);

/// Returns the faces without a neighbour, sorted by element.
template <int D>
[[nodiscard]] Buffer<ElementFace> boundary_faces(const Neighbours<D>& neighbours);

/// Returns the unique edges of elements, facets and feature edges, also for a surface mesh.
template <int D>
[[nodiscard]] Outcome<EdgeSet<D>> unique_edges(const LinearMesh<D>& mesh, const Execution& execution);

/// Returns the elements around each edge.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> shells(const EdgeSet<D>& edges, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Incidence<FacetId>> facet_shells(const EdgeSet<D>& edges, const Execution& execution);

/// Returns the edge between a and b, or an invalid id. Uses binary search.
template <int D>
[[nodiscard]] EdgeId find_edge(const EdgeSet<D>& edges, VertexId a, VertexId b);

}  // namespace camber
