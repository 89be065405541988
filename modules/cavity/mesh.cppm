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
/// An edge that lies on a curve of the geometry, or is listed by the mesh's maker (3D).
using LineId = Id<LineTag>;

/// What lies across a face of an element: another element, or a facet, whose `sides` tell of the element beyond it. So
/// facets are met where they are, and no table of faces is needed. Elements and facets are below 2^31.
class FaceNeighbour {
  public:
    constexpr FaceNeighbour() = default;
    explicit constexpr FaceNeighbour(ElementId e) : value_(e.value) {}
    explicit constexpr FaceNeighbour(FacetId f) : value_(f.value | facet_bit) {}

    /// Not so at a face of the boundary that no facet tells of.
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

/// Where a vertex lies, and so what may become of it. In 2D facets are the curves: there are no lines.
enum class VertexPlace : std::uint8_t {
    inside,
    surface,   ///< on one smooth piece of the boundary or of an interface
    line,      ///< on a curve, where two lines of one reference meet
    corner,    ///< where lines end or meet, or by the word of the mesh's maker: it stays
    infinity,  ///< of a surface alone: not a point of it, see make_dynamic_surface
};

/// What is known of an entity, as bits.
enum class Mark : std::uint8_t {
    required = 1,  ///< must not change
    frozen = 2,    ///< stays, since what is around it is more than its elements tell: facets without elements, a pinch
    given = 4,     ///< the maker's directions or associations are of it
    moved = 8,     ///< a vertex that is not where the mesh began
    ridge = 16,    ///< a line that the maker lists among ridges
    implied = 32,  ///< a line that the maker did not list: found where facets break
    corner = 64,   ///< a vertex that the maker lists among corners
    embedded = 128,  ///< a line at which nothing breaks: on a smooth surface, or inside
};
/// A set of marks.
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

/// A vertex but for its point.
struct VertexState {
    VertexPlace place = VertexPlace::inside;
    Marks marks;
    friend constexpr bool operator==(VertexState, VertexState) = default;
};

/// The elements on both sides of a facet; on the boundary of the domain the second is invalid.
using FacetSides = std::array<ElementId, 2>;

/// K-simplices some of whose places are free: those name no vertex.
template <int K>
struct DynamicSimplices {
    Column<SimplexVertices<K>> vertices;
    Column<Reference> references;
    Column<Reference> entities;  ///< no rows: of none
    Column<Marks> marks;

    [[nodiscard]] std::size_t size() const { return vertices.size(); }  ///< places, free ones too
    friend bool operator==(const DynamicSimplices&, const DynamicSimplices&) = default;
};

/// Places that are free, for each kind; the last is taken first.
struct FreePlaces {
    Column<std::uint32_t> vertices, edges, lines, facets, elements;
    friend bool operator==(const FreePlaces&, const FreePlaces&) = default;
};

/// Tells one value of a mesh from all others: copies have the same, each commit makes another.
using Stamp = std::shared_ptr<const char>;
[[nodiscard]] inline Stamp new_stamp() { return std::make_shared<const char>(); }

/// A mesh, straight or of degree 2, whose topology changes at the cost of what is changed: an immutable value of
/// columns, as LinearMesh, with neighbours, edges, lines and facets that `commit` keeps up to date. Ids are stable:
/// what is removed leaves its place free, and places are taken again. Free places: elements, facets and edges name no
/// vertex, lines no edge, vertices no element (those that belonged to none when the mesh was made are frozen).
template <int D>
struct DynamicMesh {
    static constexpr int dimension = D;

    Column<Vec<D>> points;
    Column<Reference> point_references;
    Column<VertexState> states;    ///< one a vertex
    Column<ElementId> element_of;  ///< one of the elements of each vertex

    DynamicSimplices<D> elements;
    Column<std::array<FaceNeighbour, D + 1>> face_neighbours;   ///< each element's faces
    Column<std::array<EdgeId, edges_per_simplex<D>>> edges_of;  ///< in the order of `local_edges`
    Column<std::array<VertexId, 2>> edges;                      ///< lower vertex first
    Column<LineId> line_of;                                     ///< of each edge; no rows in 2D
    Column<LagrangeNode<D>> nodes;                              ///< of each edge; no rows: a straight mesh
    DynamicSimplices<D - 1> facets;
    Column<FacetSides> sides;
    Column<EdgeId> lines;  ///< 3D
    Column<Reference> line_references, line_entities;
    Column<Marks> line_marks;

    FreePlaces free;
    GivenGeometry<D> geometry;  ///< as the maker gave it, of vertices that are marked so
    Column<Group> groups;
    Column<VertexId> at_infinity;  ///< of a surface alone, see make_dynamic_surface
    Stamp stamp;

    [[nodiscard]] std::size_t vertex_count() const { return points.size() - free.vertices.size(); }
    [[nodiscard]] std::size_t edge_count() const { return edges.size() - free.edges.size(); }
    [[nodiscard]] std::size_t line_count() const { return lines.size() - free.lines.size(); }
    [[nodiscard]] std::size_t facet_count() const { return facets.size() - free.facets.size(); }
    [[nodiscard]] std::size_t element_count() const { return elements.size() - free.elements.size(); }

    [[nodiscard]] bool is_curved() const { return !nodes.empty(); }
    [[nodiscard]] bool is_surface() const { return !at_infinity.empty(); }
    [[nodiscard]] bool is_at_infinity(VertexId v) const { return states[v].place == VertexPlace::infinity; }
    /// Of a surface alone: not of it, but of what its triangles are joined with.
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
    /// The line on an edge, if there is one.
    [[nodiscard]] LineId line_at(EdgeId e) const { return line_of.empty() ? LineId{} : line_of[e]; }
    [[nodiscard]] bool is_embedded(LineId l) const { return l.valid() && line_marks[l].has(Mark::embedded); }
    /// Whether surfaces end or break along an edge (3D).
    [[nodiscard]] bool breaks_at(EdgeId e) const { return line_at(e).valid() && !is_embedded(line_at(e)); }
};

/// The local edge between two local vertices of a K-simplex.
template <int K>
inline constexpr auto edge_between = [] {
    std::array<std::array<int, K + 1>, K + 1> table{};
    for (int k = 0; k < edges_per_simplex<K>; ++k) {
        const auto [a, b] = local_edges<K>[k];
        table[a][b] = table[b][a] = k;
    }
    return table;
}();

/// Which local vertex of a simplex v is; −1 for none.
template <std::size_t N>
[[nodiscard]] constexpr int local_vertex(const std::array<VertexId, N>& simplex, VertexId v) {
    for (std::size_t i = 0; i < N; ++i)
        if (simplex[i] == v) return static_cast<int>(i);
    return -1;
}

/// Of an element of a surface alone: its triangle, which is in front of the vertex at infinity.
[[nodiscard]] inline std::array<VertexId, 3> triangle_of(const SimplexVertices<3>& element) {
    return {element[0], element[1], element[2]};
}

}  // namespace camber

/// What is around an entity, by walking from element to element: at the cost of what is found.
export namespace camber {

/// The element across a face, beyond a facet too; invalid on the boundary.
template <int D>
[[nodiscard]] inline ElementId element_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    if (!across.valid()) return {};
    if (across.is_element()) return across.element();
    const FacetSides& sides = mesh.sides[across.facet()];
    return sides[0] == e ? sides[1] : sides[0];
}

/// The facet on a face of an element, if there is one.
template <int D>
[[nodiscard]] inline FacetId facet_at(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    return across.is_facet() ? across.facet() : FacetId{};
}

/// Of a surface alone: the facet that an element stands for.
[[nodiscard]] inline FacetId facet_of(const DynamicMesh<3>& mesh, ElementId e) { return facet_at(mesh, e, 3); }

/// The elements around a vertex that faces connect, into `found`; in the order of the walk, which begins at element_of.
template <int D>
void ball(const DynamicMesh<D>& mesh, VertexId v, std::vector<ElementId>& found);

/// The elements around an edge of element e that faces connect, into `found`: from e one way round, then, where that
/// ends at the boundary, the other way.
template <int D>
void shell(const DynamicMesh<D>& mesh, ElementId e, int local_edge, std::vector<ElementId>& found);

/// The facets with this vertex, or edge, among those on faces of these elements, into `found`, rising.
template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                 std::vector<FacetId>& found);
template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, EdgeId edge,
                 std::vector<FacetId>& found);
/// The lines with this vertex among the edges of these elements, into `found`, rising.
template <int D>
void lines_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                std::vector<LineId>& found);

/// Whether the node of an element's edge stays, by what this element tells: that of the boundary, of an interface, of a
/// line, of a required element, and where facets without elements may have it.
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

/// The edge of a facet opposite its local vertex k (3D), by the element on its first side.
[[nodiscard]] EdgeId facet_edge(const DynamicMesh<3>& mesh, FacetId f, int k);

/// Where the boundary and interfaces break, beyond what the mesh lists: edges of kind `ridge` (3D), one a unique edge,
/// and vertices that are corners. camber.surface finds them (`find_features`); none: an empty span.
struct BreaksOfMesh {
    std::span<const EdgeKind> edge_kinds;
    std::span<const VertexId> corners;
};

/// The mesh with all that changes of it need. Lines are the edges that the mesh lists, those of kind `ridge`, and
/// those with other than two facets or with facets of two references or entities (3D); embedded are those that `breaks`
/// tells to be of another kind than `ridge`. Vertices are corners by the
/// mesh's word, by `breaks`, where an association with a point or a group of vertices names them, and where they have
/// other than two lines, or lines that differ in reference, entity or kind, or where a line of the volume meets a
/// facet; in 2D where they have other than two facets, or facets that do. What cannot be changed soundly is frozen:
/// vertices of no element, of facets or listed edges on no element, and where the mesh touches itself in a vertex or an
/// edge only. Errors: a face of the boundary, or between two references, that has no facet (camber.soundness prepares
/// meshes so that there is none), two facets or more than two elements on a face (input); `edges` or `breaks` of
/// another mesh (internal); more than 2^31 − 2 elements (unsupported); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const BreaksOfMesh& breaks, const Execution& execution);

/// The same of a mesh of degree 2, with its nodes.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                                   const Execution& execution);

/// A surface alone (triangles in space, no tetrahedra) as what bounds a mesh: each triangle is joined to a vertex at
/// infinity, the last of its element, so that operations on surfaces, ridges and corners are those of any mesh (as
/// with the infinite vertex of CGAL's triangulations). Elements stand for their triangles; where the surface ends, the
/// faces between its edges and infinity are facets of a reference of their own; `compacted` leaves all of that out.
/// Lines are also the edges where the surface ends, or more than two triangles meet: these stay as they are. Errors: as
/// of make_dynamic; a mesh that is no surface alone (internal).
[[nodiscard]] Outcome<DynamicMesh<3>> make_dynamic_surface(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                           const BreaksOfMesh& breaks, const Execution& execution);

}  // namespace camber

namespace camber {

/// The same, with vertices that are at infinity.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic_with(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                        const BreaksOfMesh& breaks,
                                                        std::span<const VertexId> at_infinity,
                                                        const Execution& execution);

}  // namespace camber

export namespace camber {

/// Some elements of a mesh that changes, with what is on them: the whole mesh, or what a cut along faces leaves.
template <int D>
struct MeshPart {
    LinearMesh<D> mesh;          ///< feature edges: its lines, each once; neither directions nor groups
    Column<VertexState> states;  ///< one a vertex, as in the whole
    Column<Marks> facet_marks;   ///< frozen: of facets between this part and another
    Column<Marks> line_marks;    ///< one a feature edge
};

/// A part, ready to be changed.
template <int D>
struct DynamicPart {
    DynamicMesh<D> mesh;
    Column<std::uint8_t> on_rim;  ///< of each vertex: whether it is on the cut, and so of other parts too
};

/// The part as a mesh that changes while its rim stays: vertices there are required, those of surfaces corners for the
/// time being, as are frozen facets and lines of the rim. Where a surface goes on beyond the rim a line is added behind
/// those that are given: of surfaces there are then no ends. Vertices where the walk from face to face does not find
/// all of the part are frozen. Errors: two facets or more than two elements on a face (input); rows that do not fit
/// (internal); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicPart<D>> make_dynamic_part(const MeshPart<D>& part, const Execution& execution);

/// A mesh without free places, and where its entities went from those of the mesh that changes.
template <int D>
struct CompactMesh {
    LinearMesh<D> mesh;
    EdgeSet<D> edges;
    Column<LagrangeNode<D>> nodes;  ///< one an edge; no rows: a straight mesh
    MeshMaps maps;
};

/// The mesh as it is: entities keep their order. Lines are edges of the mesh but for those that it did not list when it
/// was made. Directions and associations are those of vertices that have not gone or moved; one that has moved keeps
/// that with the surface (2D: the curve) that it is on, without its place there. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CompactMesh<D>> compacted(const DynamicMesh<D>& mesh, const Execution& execution);

/// Whether all that a DynamicMesh says of itself agrees: simplices name vertices that are there; what is across a face
/// shares it and says the same of this side; edges are those between the elements' vertices, one id a pair; every face
/// between two references or of the boundary is a facet; lines are edges; free lists are the free places. The cost is
/// that of the whole mesh. Errors (internal): the first that does not, with its entity; stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> check_consistency(const DynamicMesh<D>& mesh, const Execution& execution);

}  // namespace camber

/// What meshes that change are made of, whole or a part of one.
namespace camber {

inline constexpr const char* prepare_it = "prepare the mesh first";

/// The mesh with neighbours, edges and facets; faces may have neither a facet nor an element beyond. Lines and states
/// of vertices are still to be made. Errors: two facets or more than two elements on a face (input); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> with_faces(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Incidence<ElementId>& balls, const Execution& execution);

/// Whether the walk from face to face misses some of the `around` elements of a vertex, or of the shells of its lines.
template <int D>
[[nodiscard]] bool is_pinched(const DynamicMesh<D>& mesh, std::size_t around, VertexId v,
                              const Incidence<ElementId>& shells, std::vector<ElementId>& found);

}  // namespace camber
