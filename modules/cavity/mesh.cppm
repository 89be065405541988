module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>
export module camber.cavity:mesh;
import camber.core;

export namespace camber {

struct LineTag;
/// A feature edge of the geometry or the input (3D).
using LineId = Id<LineTag>;

/// The neighbour across a face: an element or a facet. The `sides` of a facet give the element beyond it, so no table
/// of faces is necessary. Ids are below 2^31.
class FaceNeighbour {
  public:
    constexpr FaceNeighbour() = default;
    explicit constexpr FaceNeighbour(ElementId e) : value_(e.value) {}
    explicit constexpr FaceNeighbour(FacetId f) : value_(f.value | facet_bit) {}

    [[nodiscard]] constexpr bool valid() const { return value_ != 0xffffffffU; }
    [[nodiscard]] constexpr bool is_element() const { return (value_ & facet_bit) == 0; }
    [[nodiscard]] constexpr bool is_facet() const { return !is_element() && valid(); }
    [[nodiscard]] constexpr ElementId element() const { return ElementId(std::size_t{value_}); }
    [[nodiscard]] constexpr FacetId facet() const { return FacetId(std::size_t{value_ & ~facet_bit}); }
    friend constexpr bool operator==(FaceNeighbour, FaceNeighbour) = default;

  private:
    static constexpr std::uint32_t facet_bit = 0x80000000U;
    std::uint32_t value_ = 0xffffffffU;
};

/// Kind of position of a vertex. In 2D, facets form the surface, and there are no lines.
enum class VertexPlace : std::uint8_t {
    inside,
    surface,   ///< on a smooth part of the boundary or an interface
    line,      ///< on a curve: exactly two lines, with one reference, meet here
    corner,    ///< fixed: lines end here, more than two meet here, or the input lists the vertex
    infinity,  ///< auxiliary vertex, see `make_dynamic_surface`
};

enum class Mark : std::uint8_t {
    required = 1,        ///< must not change
    frozen = 2,          ///< fixed: a facet at the vertex has no elements, or the mesh touches itself there
    has_input_data = 4,  ///< the input has directions or associations for the vertex
    moved = 8,
    ridge = 16,      ///< a ridge listed by the input
    implied = 32,    ///< a ridge that the input does not list
    corner = 64,     ///< a corner listed by the input
    embedded = 128,  ///< a line that is neither a listed nor an implied ridge
};
class Marks {
  public:
    constexpr Marks() = default;
    constexpr Marks(Mark mark) : bits_(static_cast<std::uint8_t>(mark)) {}  // NOLINT(*-explicit-*)
    [[nodiscard]] constexpr bool has(Mark mark) const { return (bits_ & static_cast<std::uint8_t>(mark)) != 0; }
    constexpr Marks& operator|=(Marks other) {
        bits_ = static_cast<std::uint8_t>(bits_ | other.bits_);
        return *this;
    }
    [[nodiscard]] friend constexpr Marks operator|(Marks a, Marks b) { return a |= b; }
    friend constexpr bool operator==(Marks, Marks) = default;

  private:
    std::uint8_t bits_ = 0;
};

struct VertexState {
    VertexPlace place = VertexPlace::inside;
    Marks marks;
    friend constexpr bool operator==(VertexState, VertexState) = default;
};

/// Elements on both sides of a facet; the second is invalid on the boundary.
using FacetSides = std::array<ElementId, 2>;

template <int K>
struct DynamicSimplices {
    Column<SimplexVertices<K>> vertices;
    Column<Reference> references;
    Column<Reference> entities;  ///< may be empty
    Column<Marks> marks;

    [[nodiscard]] std::size_t size() const { return vertices.size(); }  ///< number of slots, including free ones
    friend bool operator==(const DynamicSimplices&, const DynamicSimplices&) = default;
};

struct FreeSlots {
    Column<std::uint32_t> vertices, edges, lines, facets, elements;
    friend bool operator==(const FreeSlots&, const FreeSlots&) = default;
};

/// Identifies one state of a mesh. Copies share the stamp; a commit creates a new one.
using Stamp = std::shared_ptr<const char>;
[[nodiscard]] inline Stamp new_stamp() { return std::make_shared<const char>(); }

/// A linear or quadratic mesh whose topology changes in time proportional to the change. It consists of immutable
/// columns, like `LinearMesh`. Ids are stable. Slots are reused, the last freed first. In free slots, the vertices of
/// an element, facet or edge are invalid, and so are the edge of a line and the element of a vertex (unless the vertex
/// is frozen).
template <int D>
struct DynamicMesh {
    static constexpr int dimension = D;

    Column<Vec<D>> points;
    Column<Reference> point_references;
    Column<VertexState> states;
    Column<ElementId> element_of;

    DynamicSimplices<D> elements;
    Column<std::array<FaceNeighbour, D + 1>> face_neighbours;
    Column<std::array<EdgeId, edges_per_simplex<D>>> edges_of;  ///< in the order of `local_edges`
    Column<std::array<VertexId, 2>> edges;                      ///< lower vertex first
    Column<LineId> line_of;                                     ///< empty in 2D
    Column<LagrangeNode<D>> nodes;                              ///< empty for a straight mesh
    DynamicSimplices<D - 1> facets;
    Column<FacetSides> sides;
    Column<EdgeId> lines;  ///< edge of each line (3D)
    Column<Reference> line_references, line_entities;
    Column<Marks> line_marks;

    FreeSlots free;
    InputGeometry<D> geometry;
    Column<Group> groups;
    Column<VertexId> at_infinity;  ///< only in standalone surface meshes
    Stamp stamp;

    [[nodiscard]] std::size_t vertex_count() const { return points.size() - free.vertices.size(); }
    [[nodiscard]] std::size_t edge_count() const { return edges.size() - free.edges.size(); }
    [[nodiscard]] std::size_t line_count() const { return lines.size() - free.lines.size(); }
    [[nodiscard]] std::size_t facet_count() const { return facets.size() - free.facets.size(); }
    [[nodiscard]] std::size_t element_count() const { return elements.size() - free.elements.size(); }

    [[nodiscard]] bool is_curved() const { return !nodes.empty(); }
    [[nodiscard]] bool is_surface() const { return !at_infinity.empty(); }
    [[nodiscard]] bool is_at_infinity(VertexId v) const { return states[v].place == VertexPlace::infinity; }
    [[nodiscard]] bool is_at_infinity(EdgeId e) const {
        return is_surface() && (is_at_infinity(edges[e][0]) || is_at_infinity(edges[e][1]));
    }
    [[nodiscard]] bool is_at_infinity(FacetId f) const {
        return is_surface() && std::ranges::any_of(facets.vertices[f], [&](VertexId v) { return is_at_infinity(v); });
    }
    [[nodiscard]] bool is_free(ElementId e) const { return !elements.vertices[e][0].valid(); }
    [[nodiscard]] bool is_free(FacetId f) const { return !facets.vertices[f][0].valid(); }
    [[nodiscard]] bool is_free(EdgeId e) const { return !edges[e][0].valid(); }
    [[nodiscard]] bool is_free(LineId l) const { return !lines[l].valid(); }
    [[nodiscard]] bool is_free(VertexId v) const {
        return !element_of[v].valid() && !states[v].marks.has(Mark::frozen);
    }
    [[nodiscard]] LineId line_at(EdgeId e) const { return line_of.empty() ? LineId{} : line_of[e]; }
    [[nodiscard]] bool is_embedded(LineId l) const { return l.valid() && line_marks[l].has(Mark::embedded); }
    [[nodiscard]] bool breaks_at(EdgeId e) const { return line_at(e).valid() && !is_embedded(line_at(e)); }
};

template <int K>
inline constexpr auto edge_between = [] {
    std::array<std::array<int, K + 1>, K + 1> table{};
    for (int k = 0; k < edges_per_simplex<K>; ++k) {
        const auto [a, b] = local_edges<K>[k];
        table[a][b] = table[b][a] = k;
    }
    return table;
}();

/// Returns −1 if `v` is not found.
template <std::size_t N>
[[nodiscard]] constexpr int local_vertex(const std::array<VertexId, N>& simplex, VertexId v) {
    for (std::size_t i = 0; i < N; ++i)
        if (simplex[i] == v) return static_cast<int>(i);
    return -1;
}

[[nodiscard]] inline std::array<VertexId, 3> triangle_of(const SimplexVertices<3>& element) {
    return {element[0], element[1], element[2]};
}

}  // namespace camber

/// Neighbourhoods are found by walks, in time proportional to the result.
export namespace camber {

/// Element across a face, or across the facet on that face; invalid on the boundary.
template <int D>
[[nodiscard]] inline ElementId element_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    if (!across.valid()) return {};
    if (across.is_element()) return across.element();
    const FacetSides& sides = mesh.sides[across.facet()];
    return sides[0] == e ? sides[1] : sides[0];
}

/// Facet on a face of an element; invalid if there is none.
template <int D>
[[nodiscard]] inline FacetId facet_at(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    return across.is_facet() ? across.facet() : FacetId{};
}

[[nodiscard]] inline FacetId facet_of(const DynamicMesh<3>& mesh, ElementId e) { return facet_at(mesh, e, 3); }

/// Finds the elements around a vertex. Walks from element to element through faces, starting at `element_of`.
template <int D>
void ball(const DynamicMesh<D>& mesh, VertexId v, std::vector<ElementId>& found);

/// Finds the elements around an edge. Walks from `e` through faces in one direction and, if it reaches the boundary,
/// also in the other.
template <int D>
void shell(const DynamicMesh<D>& mesh, ElementId e, int local_edge, std::vector<ElementId>& found);

/// Finds the facets that are faces of these elements and contain the vertex (or edge), in ascending order.
template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                 std::vector<FacetId>& found);
template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, EdgeId edge,
                 std::vector<FacetId>& found);
/// Finds the lines that are edges of these elements and end at the vertex, in ascending order.
template <int D>
void lines_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                std::vector<LineId>& found);

/// True if this element shows that the edge's node is fixed: the edge is on one of its facets or on a line, or the
/// element is required. Also true if both ends are frozen, because facets without elements may have the edge.
template <int D>
[[nodiscard]] inline bool is_node_fixed(const DynamicMesh<D>& mesh, ElementId e, int local_edge) {
    const EdgeId edge = mesh.edges_of[e][local_edge];
    const auto& [a, b] = mesh.edges[edge];
    if (mesh.elements.marks[e].has(Mark::required) || mesh.line_at(edge).valid()) return true;
    if (mesh.states[a].marks.has(Mark::frozen) && mesh.states[b].marks.has(Mark::frozen)) return true;
    for (int face = 0; face <= D; ++face) {
        if (face == local_edges<D>[local_edge][0] || face == local_edges<D>[local_edge][1]) continue;
        const FaceNeighbour across = mesh.face_neighbours[e][face];
        if (!across.valid() || across.is_facet()) return true;
    }
    return false;
}

/// Edge of the facet opposite its vertex `k`. Precondition: the facet has an element.
[[nodiscard]] EdgeId facet_edge(const DynamicMesh<3>& mesh, FacetId f, int k);

/// Corners and ridges that the mesh does not list. Ridges have kind `ridge` among the kinds of the unique edges (3D).
/// Empty spans: none. `find_features` of camber.surface computes them.
struct BreaksOfMesh {
    std::span<const EdgeKind> edge_kinds;
    std::span<const VertexId> corners;
};

/// Creates a dynamic mesh.
/// - Lines (3D) are the listed edges, edges of kind `ridge`, and edges with one facet, with more than two facets, or
///   with facets of different references or entities. Lines whose kind is not `ridge` are embedded.
/// - Corners are listed corners, those of `breaks`, and vertices associated with points or in vertex groups. A vertex
///   on lines is a corner unless exactly two lines of the same reference, entity and kind meet there. Also a corner: a
///   vertex at which a line without facets meets a facet. In 2D, facets count as lines, and ends of listed ridges are
///   corners.
/// - Frozen are vertices without elements, vertices of facets or listed edges without elements, and vertices at which
///   the mesh touches itself.
///
/// Errors: input (a face of the boundary or between two references without a facet, which camber.soundness adds; two
/// facets or more than two elements on a face); internal (`edges` or `breaks` of another mesh); unsupported (more than
/// 2^31 − 2 elements); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const BreaksOfMesh& breaks, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                                   const Execution& execution);

/// Creates the dynamic mesh of a standalone surface (triangles in space, no tetrahedra). Each triangle and a vertex at
/// infinity form an element, as in CGAL's triangulations. The vertex at infinity is the element's last one. Faces that
/// join border edges to infinity are facets of a separate reference. `compacted` omits all entities at infinity. Border
/// edges and edges of more than two triangles are lines and do not change. Errors: those of `make_dynamic`, internal
/// (not a standalone surface).
[[nodiscard]] Outcome<DynamicMesh<3>> make_dynamic_surface(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                           const BreaksOfMesh& breaks, const Execution& execution);

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic_with(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                        const BreaksOfMesh& breaks,
                                                        std::span<const VertexId> at_infinity,
                                                        const Execution& execution);

}  // namespace camber

export namespace camber {

/// Elements with their facets and lines: a whole mesh, or a part cut along faces.
template <int D>
struct MeshPart {
    LinearMesh<D> mesh;  ///< its edges are the lines, each listed once; it has no directions or groups
    Column<VertexState> states;
    Column<Marks> facet_marks;  ///< `frozen`: the facet is shared with another part
    Column<Marks> line_marks;
};

template <int D>
struct DynamicPart {
    DynamicMesh<D> mesh;
    Column<std::uint8_t> on_rim;  ///< 1: the vertex is on the cut, which other parts share
};

/// Creates a dynamic mesh in which the rim (the cut) does not change. Vertices of the rim are required; on surfaces,
/// they are temporarily corners. Frozen facets, and lines on the rim, are required. Surface edges on the rim become
/// lines, because the surface does not end there. A vertex is frozen if a walk around it does not find all of its
/// elements. Errors: input (two facets or more than two elements on a face), internal (columns of wrong size), stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<DynamicPart<D>> make_dynamic_part(const MeshPart<D>& part, const Execution& execution);

template <int D>
struct CompactMesh {
    LinearMesh<D> mesh;
    EdgeSet<D> edges;
    Column<LagrangeNode<D>> nodes;  ///< empty for a straight mesh
    MeshMaps maps;
};

/// Returns the mesh without free slots. Entities keep their order. Implied lines are omitted. Vertices that did not
/// move keep directions and associations. Moved vertices stay associated only with surfaces (2D: curves), without
/// parameters. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CompactMesh<D>> compacted(const DynamicMesh<D>& mesh, const Execution& execution);

/// Checks the whole mesh. Vertices of entities exist. Two neighbours share the vertices of their face, and each lists
/// the other. Each pair of vertices has at most one edge id, and only edges of elements have one. Faces on the boundary
/// or between references are facets. Lines are edges. Free lists contain exactly the free slots. Errors: internal (the
/// first violation), stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> check_consistency(const DynamicMesh<D>& mesh, const Execution& execution);

}  // namespace camber

namespace camber {

inline constexpr const char* prepare_it = "prepare the mesh first";

/// Creates neighbours, edges and facets, but neither lines nor vertex states. A face may have neither a neighbour nor a
/// facet. Errors: input (two facets or more than two elements on a face), stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> with_faces(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Incidence<ElementId>& balls, const Execution& execution);

/// True if walks through faces miss elements of the vertex, or elements of one of its lines. `around`: number of
/// elements at the vertex.
template <int D>
[[nodiscard]] bool is_pinched(const DynamicMesh<D>& mesh, std::size_t around, VertexId v,
                              const Incidence<ElementId>& shells, std::vector<ElementId>& found);

}  // namespace camber
