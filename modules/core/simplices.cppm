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

/// The vertices of one K-simplex.
template <int K>
using SimplexVertices = std::array<VertexId, K + 1>;

/// Edges of a K-simplex.
template <int K>
inline constexpr int edges_per_simplex = K * (K + 1) / 2;

/// The end vertices of the local edges of a K-simplex, K = 1, 2, 3, in the order of GMF and VTK:
/// e01 e12 e20 e03 e13 e23.
template <int K>
inline constexpr auto local_edges = [] {
    std::array<std::array<int, 2>, edges_per_simplex<K>> edges{};
    for (int i = 0; i < edges_per_simplex<K>; ++i) edges[i] = shape_table<simplex<K>>.edges[i];
    return edges;
}();

/// The local vertices of the face of a K-simplex opposite local vertex i, ordered so that its normal points
/// outwards of a positively oriented simplex (for K = 2: counter-clockwise).
template <int K>
[[nodiscard]] constexpr std::array<int, K> face_opposite(int i) {
    if constexpr (K == 2) {
        return local_edges<2>[(i + 1) % 3];
    } else {
        const auto& corners = shape_table<Shape::tetrahedron>.faces[i].corners;
        return {corners[0], corners[1], corners[2]};
    }
}

/// K-simplices of a mesh, column by column.
template <int K>
struct Simplices {
    Column<SimplexVertices<K>> vertices;
    Column<Reference> references;    ///< one a simplex
    Column<std::uint32_t> required;  ///< indices of those that must not change
    /// The entity of dimension K of the geometry that each lies on, as the mesh's maker counts them; 0: not known; no
    /// rows: of none.
    Column<Reference> entities = {};

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
    friend bool operator==(const Simplices&, const Simplices&) = default;
};

/// A vertex and the row, from 0, of a table of directions.
struct DirectionRow {
    VertexId vertex;
    std::uint32_t row = 0;
    friend bool operator==(const DirectionRow&, const DirectionRow&) = default;
};
/// Directions given at vertices, as a table and who has which of its rows: several vertices may share a row, and a
/// vertex has several where a surface or a curve breaks. They are directions only: of any length, either way round.
template <int D>
struct DirectionsAtVertices {
    Column<Vec<D>> table;
    Column<DirectionRow> at;
    friend bool operator==(const DirectionsAtVertices&, const DirectionsAtVertices&) = default;
};

/// An item of the mesh (a vertex; edges and facets can be others) on an entity of the geometry that the mesh stands
/// for: a point (G = 0), a curve (1) or a surface (2) of a CAD model, or of what a mesher classifies its nodes by.
template <int G, class Item = VertexId>
struct Association {
    Item item;
    Reference entity = 0;  ///< its number among those of dimension G, as the mesh's maker counts them
    /// Where on it, in the entity's own parametrisation: t of a curve, (u, v) of a surface. None: not known; a point
    /// has none.
    std::optional<std::array<double, G>> parameters = {};
    std::optional<double> distance = {};  ///< of the item from that place (model units); none: not known
    friend bool operator==(const Association&, const Association&) = default;
};

/// What the mesh's maker says of the geometry beyond the simplices, kept from input to output. `camber.surface` takes
/// normals and tangents where they agree with the mesh; associations are for whoever has the geometry they speak of. An
/// item may have several: a vertex on a curve has a place on each surface that meets there.
template <int D>
struct GivenGeometry {
    DirectionsAtVertices<D> normals;   ///< of the surface (in 2D: of the boundary)
    DirectionsAtVertices<D> tangents;  ///< of curves: ridges in 3D, the boundary in 2D
    Column<Association<0>> on_points;
    Column<Association<1>> on_curves;
    Column<Association<2>> on_surfaces;
    friend bool operator==(const GivenGeometry&, const GivenGeometry&) = default;
};

/// A name for the simplices of one dimension that share a reference: Gmsh's physical group, a boundary condition or a
/// marker of a flow solver. Simplices in several groups have a reference with several names.
struct Group {
    int dimension = 0;  ///< of the simplices; 0: vertices
    Reference reference = 0;
    std::string name;
    friend bool operator==(const Group&, const Group&) = default;
};

/// A straight mesh of D-simplices in D dimensions: an immutable value of columns. Elements are positively
/// oriented in a sound mesh; `facets` are boundary and interface facets (triangles in 3D, edges in 2D);
/// `edges` are the feature edges of a 3D mesh (always empty in 2D, where facets are the edges).
template <int D>
struct LinearMesh {
    static constexpr int dimension = D;

    Column<Vec<D>> points;               ///< vertex coordinates
    Column<Reference> point_references;  ///< one a vertex
    Column<VertexId> corners;            ///< vertices where curves break
    Column<VertexId> required_vertices;
    Simplices<D> elements;
    Simplices<D - 1> facets;
    Simplices<1> edges;
    Column<std::uint32_t> ridges;  ///< indices into `edges` (3D) or `facets` (2D)
    GivenGeometry<D> geometry;
    Column<Group> groups = {};  ///< of several with one dimension and reference the first is the main one

    friend bool operator==(const LinearMesh&, const LinearMesh&) = default;
};

/// Whether the mesh is a surface in space and no more: what is judged of it, and what a field on it is over, are its
/// triangles, in the order of its facets, and an ElementId of either is the number of one.
template <int D>
[[nodiscard]] inline bool is_surface_alone(const LinearMesh<D>& mesh) {
    return D == 3 && mesh.elements.size() == 0 && mesh.facets.size() > 0;
}

/// The unique edges of a mesh, sorted by (lower vertex, higher vertex), and the edges of each simplex in the order
/// of `local_edges`.
template <int D>
struct EdgeSet {
    Column<std::array<VertexId, 2>> vertices;  ///< lower vertex first
    Column<std::array<EdgeId, edges_per_simplex<D>>> of_elements;
    Column<std::array<EdgeId, edges_per_simplex<D - 1>>> of_facets;
    Column<EdgeId> of_edges;  ///< of the feature edges (3D)

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
    friend bool operator==(const EdgeSet&, const EdgeSet&) = default;
};

/// The node of a P2 edge that lies on the curve, at t = 1/2. Its Bézier counterpart (camber.bezier: ControlPoint) does
/// not lie on it; the two must not be mixed up (P_11 = (4 P^l − P_20 − P_02)/2), so each has its type.
template <int D>
struct LagrangeNode {
    Vec<D> point;
    friend bool operator==(const LagrangeNode&, const LagrangeNode&) = default;
};

/// A quadratic (P2) mesh: the straight one, its unique edges, and one **Lagrange** node (a point on the curve at
/// t = 1/2) an edge. Conformity of the mid nodes is by construction.
template <int D>
struct QuadraticMesh {
    static constexpr int dimension = D;

    LinearMesh<D> linear;
    EdgeSet<D> edges;
    Column<LagrangeNode<D>> mid_nodes;  ///< one an edge of `edges`

    friend bool operator==(const QuadraticMesh&, const QuadraticMesh&) = default;
};

/// Where an edge lies, and so how its node may move.
enum class EdgeKind : std::uint8_t {
    volume,   ///< free in the volume
    surface,  ///< on a smooth piece of the boundary or of an interface
    ridge,    ///< on a curve where the boundary or an interface breaks
    fixed,    ///< not to be moved: on the boundary of a cavity, shared with elements outside
};

/// What became of an edge's node on the way from the straight mesh to the committed one.
enum class EdgeChange : std::uint8_t {
    straight,      ///< still at the middle of the chord
    projected,     ///< put onto the geometry
    optimised,     ///< put where the metric wants it
    relaxed,       ///< moved back towards the middle, or elsewhere, so that its elements become valid
    straightened,  ///< moved back all the way to the middle
};

/// New places for the vertices and the mid nodes of a mesh: planned against the mesh, judged by `validate`, repaired by
/// `relax` and `repair`, and made the mesh's own by `commit`.
template <int D>
struct Proposal {
    Column<Vec<D>> points;              ///< one a vertex; the mesh's own column where no vertex moves
    Column<LagrangeNode<D>> mid_nodes;  ///< one an edge
    Column<EdgeKind> kinds;             ///< one an edge
    Column<EdgeChange> changes;         ///< one an edge
    friend bool operator==(const Proposal&, const Proposal&) = default;
};

/// The mesh as the proposal would have it, to look at: what is to last is made by `commit`. Shares all columns.
template <int D>
[[nodiscard]] inline QuadraticMesh<D> apply_proposal(QuadraticMesh<D> mesh, const Proposal<D>& proposal) {
    mesh.linear.points = proposal.points;
    mesh.mid_nodes = proposal.mid_nodes;
    return mesh;
}

/// What messages call a K-simplex.
template <int K>
inline constexpr const char* simplex_name = name_of(simplex<K>);

// The Lagrange functions of degree 2 on a K-simplex, by barycentric coordinates.

/// Of a vertex's node: ξ (2ξ − 1).
[[nodiscard]] constexpr double vertex_shape(double xi) { return xi * (2 * xi - 1); }

/// Of the node of local edge e: 4 ξ_i ξ_j. It is also what that node adds, by how far it is from the middle of its
/// chord, to the linear function of the vertices.
template <int K>
[[nodiscard]] constexpr double edge_shape(const std::array<double, K + 1>& xi, int e) {
    const auto [i, j] = local_edges<K>[e];
    return 4 * xi[i] * xi[j];
}

/// Adds ∂/∂ξ_a, a = 0 … K, of edge_shape times a value.
template <int K, class T>
constexpr void add_edge_derivatives(const std::array<double, K + 1>& xi, int e, const T& value,
                                    std::array<T, K + 1>& partial) {
    const auto [i, j] = local_edges<K>[e];
    partial[i] += (4 * xi[j]) * value;
    partial[j] += (4 * xi[i]) * value;
}

// What a file says must not change (GMF's Required entities).

/// One mark an edge: 1 for a required one, and for the edges of required facets and elements.
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

/// One mark a vertex: 1 for a required one, and for the vertices of required edges, facets and elements.
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

/// Whether edges of the boundary are held where they are required, or those of the volume alone.
enum class RequiredBoundary : std::uint8_t { keep, geometry };
[[nodiscard]] constexpr auto words(RequiredBoundary) {
    return words_of(Word{RequiredBoundary::keep, "keep"}, Word{RequiredBoundary::geometry, "geometry"});
}

/// The kinds with the required edges `fixed`: their nodes stay.
template <int D>
[[nodiscard]] inline Column<EdgeKind> held_kinds(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                 RequiredBoundary boundary) {
    const auto required = required_edges(mesh);
    Buffer<EdgeKind> held(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < held.size(); ++e)
        if (required[e] != 0 && (boundary == RequiredBoundary::keep || kinds[e] == EdgeKind::volume))
            held[e] = EdgeKind::fixed;
    return Column<EdgeKind>(std::move(held));
}

/// The mesh without what it requires of its facets, feature edges and elements.
template <int D>
[[nodiscard]] inline QuadraticMesh<D> without_required(QuadraticMesh<D> mesh) {
    mesh.linear.elements.required = {};
    mesh.linear.facets.required = {};
    mesh.linear.edges.required = {};
    return mesh;
}

/// 1 for vertices on the boundary: at an end of an edge that is not of the volume.
template <int D>
[[nodiscard]] inline Buffer<std::uint8_t> boundary_vertices(const QuadraticMesh<D>& mesh,
                                                            const Column<EdgeKind>& kinds) {
    Buffer<std::uint8_t> marks(mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume)
            for (const VertexId v : mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

// The range of lengths that Camber computes with, in model units. Products of four lengths (determinants of triangles'
// derivatives, squared areas) and of three and their rounding errors, and squares of a metric's entries, are then
// numbers with all their digits, also for elements far thinner than they are long. From 1e-77 and 1e77 on they are
// not.

/// Elements and facets are at least as large as this in some coordinate; sizes of metrics are no smaller.
inline constexpr double min_length = 1e-60;
/// Coordinates are no larger than this, neither are sizes of metrics.
inline constexpr double max_length = 1e60;

/// For each key (a vertex, an edge …) the items that touch it, in rising order; compressed rows.
template <class Item>
struct Incidence {
    Column<std::uint32_t> offsets;  ///< keys + 1
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

/// The element across the face opposite each local vertex; an invalid id where there is none.
template <int D>
using Neighbours = Column<std::array<ElementId, D + 1>>;

/// A face of an element: that opposite local vertex `opposite`.
struct ElementFace {
    ElementId element;
    std::uint32_t opposite = 0;
    friend bool operator==(const ElementFace&, const ElementFace&) = default;
};

/// Derived data of the functions below, for meshes whose vertex ids are in range. Errors: more than two elements on a
/// face (`neighbours`), a simplex that names a vertex twice (`unique_edges`), more incidences than 32 bits count;
/// stopped.

/// Elements around each vertex.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> balls(const LinearMesh<D>& mesh, const Execution& execution);

/// Facets around each vertex.
template <int D>
[[nodiscard]] Outcome<Incidence<FacetId>> facet_balls(const LinearMesh<D>& mesh, const Execution& execution);

/// Feature edges around each vertex, by their index in LinearMesh::edges.
template <int D>
[[nodiscard]] Outcome<Incidence<EdgeId>> feature_edge_balls(const LinearMesh<D>& mesh, const Execution& execution);

/// A face of an element, named by its lowest vertex and the others, which rise.
template <int D>
struct FaceAround {
    std::array<VertexId, D - 1> others;
    ElementFace face;
};

/// The faces of which v is the lowest vertex, of all elements of its ball: equal ones side by side, by rising element.
/// Faces that name a vertex twice are left out.
template <int D>
void faces_around(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, VertexId v,
                  std::vector<FaceAround<D>>& faces);

/// visit(faces) with all elements on a face, for each face, in parallel; needs the balls of the same mesh.
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

/// The element across each face; needs the balls of the same mesh.
template <int D>
[[nodiscard]] Outcome<Neighbours<D>> neighbours(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                const Execution& execution);

/// Faces of elements without a neighbour, by rising element.
template <int D>
[[nodiscard]] Buffer<ElementFace> boundary_faces(const Neighbours<D>& neighbours);

/// Unique edges of elements, facets and feature edges (those of a surface-only mesh included).
template <int D>
[[nodiscard]] Outcome<EdgeSet<D>> unique_edges(const LinearMesh<D>& mesh, const Execution& execution);

/// The shell of each edge: its elements.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> shells(const EdgeSet<D>& edges, const Execution& execution);

/// Facets around each edge.
template <int D>
[[nodiscard]] Outcome<Incidence<FacetId>> facet_shells(const EdgeSet<D>& edges, const Execution& execution);

/// The edge between two vertices, or an invalid id: binary search in the sorted set.
template <int D>
[[nodiscard]] EdgeId find_edge(const EdgeSet<D>& edges, VertexId a, VertexId b);

}  // namespace camber
