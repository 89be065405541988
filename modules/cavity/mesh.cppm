module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
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
