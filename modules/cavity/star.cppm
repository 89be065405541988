module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>
export module camber.cavity:star;
import camber.core;
import :mesh;

namespace camber {

template <class Key>
class FlatMap {
  public:
    static constexpr std::uint32_t none = 0xffffffffU;

    void clear() { numbers_.clear(); }
    [[nodiscard]] std::uint32_t find(Key key) const {
        const std::uint32_t* number = numbers_.find(key);
        return number ? *number : none;
    }
    [[nodiscard]] bool contains(Key key) const { return numbers_.contains(key); }
    /// Stores the number if the key has none yet. Returns the number of the key.
    std::uint32_t put(Key key, std::uint32_t number) { return numbers_.insert(key, number); }

  private:
    ScratchMap<Key, std::uint32_t> numbers_;
};

}  // namespace camber

export namespace camber {

/// Entities that an operation removes (paper §1.3): elements, and facets and lines on them.
template <int D>
struct Cavity {
    std::vector<ElementId> elements;
    std::vector<FacetId> facets;
    std::vector<LineId> lines;

    void clear() {
        elements.clear();
        facets.clear();
        lines.clear();
    }
    friend bool operator==(const Cavity&, const Cavity&) = default;
};

/// A removed facet. The point replaces its local vertex `opposite` in a new facet.
struct JoinedFacet {
    FacetId facet;
    std::uint32_t opposite = 0;
    friend bool operator==(const JoinedFacet&, const JoinedFacet&) = default;
};
struct JoinedLine {
    LineId line;
    std::uint32_t opposite = 0;
    friend bool operator==(const JoinedLine&, const JoinedLine&) = default;
};

/// The faces that remain open without the elements of a cavity. A new simplex has the reference and orientation of a
/// listed entity, and the point instead of its local vertex `opposite`.
template <int D>
struct Star {
    std::vector<ElementFace> joined;     ///< open faces of removed elements; each gives a new element
    std::vector<ElementFace> preserved;  ///< open faces that contain the point; these give no element
    std::vector<JoinedFacet> facets;     ///< sides of removed facets; each gives a new facet
    std::vector<JoinedLine> lines;       ///< ends of removed lines; each gives a new line
    std::vector<VertexId> boundary;      ///< vertices of `joined`; each has an edge to the point
    std::vector<VertexId> vanishing;     ///< other vertices of the cavity, ascending
    VertexPlace place = VertexPlace::inside;

    void clear() {
        joined.clear();
        preserved.clear();
        facets.clear();
        lines.clear();
        boundary.clear();
        vanishing.clear();
        place = VertexPlace::inside;
    }
    friend bool operator==(const Star&, const Star&) = default;
};

/// Topological reasons why a cavity cannot be joined to a point.
enum class StarFailure : std::uint8_t {
    none,
    empty,     ///< all open faces contain the point
    required,  ///< a required, frozen or corner entity would be removed
    surface,   ///< a facet would be lost, exist twice or be on no face; or the point's `VertexPlace` would change
    line,      ///< a line would be lost or exist twice; or the point's `VertexPlace` would change
    ball,      ///< the joined faces form neither a sphere around the point nor a disc beside it
    exists,    ///< a new edge or face exists already outside the cavity
};

}  // namespace camber

/// Cavities of operations (paper §1.3). The point to which the cavity is joined determines the operation:
/// - cavity of an edge: split (a new point on the edge) or swap (a vertex of the cavity's boundary);
/// - cavity of a vertex: collapse (a neighbour), reinsertion (the vertex itself) or move (the vertex at another
///   position).
export namespace camber {

template <int D>
void cavity_of_edge(const DynamicMesh<D>& mesh, ElementId e, int k, Cavity<D>& out);

template <int D>
void cavity_of_vertex(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out);

/// Adds an element and, in a standalone surface mesh, its triangle.
template <int D>
void join(const DynamicMesh<D>& mesh, Cavity<D>& cavity, ElementId e);

/// True if `v` may collapse along an edge into `w`. Inner vertices always may, vertices on surfaces or lines only along
/// these, corners never. `around`: `cavity_of_vertex` of `v`.
template <int D>
[[nodiscard]] bool may_collapse(const DynamicMesh<D>& mesh, const Cavity<D>& around, VertexId v, VertexId w);

}  // namespace camber

namespace camber {

/// A face at the point is identified by its side opposite the point: an edge (3D) or a vertex (2D).
template <int D>
struct SideName;
template <>
struct SideName<2> {
    using Id = VertexId;
};
template <>
struct SideName<3> {
    using Id = EdgeId;
};
template <int D>
using SideId = typename SideName<D>::Id;

/// A face at the star's point. `sides`: the faces in `joined` or `preserved` from which it results; `facet`: the facet
/// on it.
struct StarFace {
    struct Side {
        std::uint32_t of = 0;
        bool preserved = false;
        std::uint8_t local = 0;  ///< for a joined face: local vertex of its new element opposite this face
    };
    std::array<Side, 2> sides{};
    std::uint32_t count = 0;            ///< number of sides; more than two is a failure
    std::uint32_t facet = 0xffffffffU;  ///< index in `Star::facets`, if a facet is on the face
};

/// Returns the side, opposite the point, of a face at the point. For a preserved face, `face` is that face and `other`
/// the local vertex of the point. For a face of a new element, `face` is the joined face and `other` the local vertex
/// opposite the new face.
template <int D, class Elements, class EdgesOf>
[[nodiscard]] SideId<D> side_without(const Elements& elements, const EdgesOf& edges_of, const ElementFace& face,
                                     int other) {
    if constexpr (D == 2) {
        const int rest = 3 - static_cast<int>(face.opposite) - other;
        return elements[face.element.index()][rest];
    } else {
        std::array<int, 2> rest{};
        int n = 0;
        for (int i = 0; i <= D; ++i)
            if (i != static_cast<int>(face.opposite) && i != other) rest[n++] = i;
        return edges_of[face.element.index()][edge_between<D>[rest[0]][rest[1]]];
    }
}

/// Lists the faces at the point. Returns false if a face has more than two sides.
template <int D, class Elements, class EdgesOf>
[[nodiscard]] bool find_faces(const Elements& elements, const EdgesOf& edges_of, const Star<D>& star, VertexId point,
                              FlatMap<SideId<D>>& names, std::vector<StarFace>& faces) {
    names.clear();
    faces.clear();
    const auto add = [&](SideId<D> name, StarFace::Side side) {
        const auto next = static_cast<std::uint32_t>(faces.size());
        const std::uint32_t at = names.put(name, next);
        if (at == next) faces.push_back({});
        StarFace& face = faces[at];
        if (face.count == 2) return false;
        face.sides[face.count++] = side;
        return true;
    };
    for (std::uint32_t j = 0; j < star.joined.size(); ++j)
        for (int i = 0; i <= D; ++i)
            if (i != static_cast<int>(star.joined[j].opposite) &&
                !add(side_without<D>(elements, edges_of, star.joined[j], i), {j, false, static_cast<std::uint8_t>(i)}))
                return false;
    for (std::uint32_t k = 0; k < star.preserved.size(); ++k) {
        const int point_index = local_vertex(elements[star.preserved[k].element.index()], point);
        if (!add(side_without<D>(elements, edges_of, star.preserved[k], point_index), {k, true, 0})) return false;
    }
    return true;
}

}  // namespace camber

export namespace camber {

/// Reusable tables of `star`; each thread needs its own workspace.
template <int D>
class StarWorkspace {
  public:
    FlatMap<ElementId> elements;
    FlatMap<FacetId> facets;
    FlatMap<LineId> lines;
    FlatMap<VertexId> vertices;  ///< index in `boundary`
    FlatMap<SideId<D>> names;    ///< index in `faces`
    std::vector<StarFace> faces;
    struct ToPoint {
        bool is_present = false;  ///< the cavity has this edge already
        bool is_line = false;
        bool lost_facet = false;
        bool preserves_facet = false;  ///< the vertex is on a border of the removed facets
        std::uint8_t facets = 0;       ///< number of facets on the edge after the operation
        std::uint8_t before = 0;       ///< for a line: number of facets before the operation, on this edge or on the
                                       ///< removed line that it continues
        Reference reference = 0;       ///< reference of the facets
    };
    std::vector<ToPoint> to_point;
    struct OpenSide {
        SideId<D> name;
        Reference reference = 0;
        JoinedFacet facet;
        bool is_line = false;
    };
    std::vector<OpenSide> open_sides;
    std::vector<ElementId> outside;
    std::vector<LineId> lines_at_point;
    std::vector<std::uint32_t> groups;
};

/// Joins the open faces of a cavity to `point`: a vertex, or invalid for a new one. Joins ridges first, then facets by
/// reference, then elements of all materials (paper §1.3). Checks the topology completely: if the result is `none`, the
/// new mesh is conforming and has the same features, for all positions of its vertices. `out` is valid only if the
/// result is `none`.
template <int D>
[[nodiscard]] StarFailure star(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point,
                               StarWorkspace<D>& workspace, Star<D>& out);

}  // namespace camber

namespace camber {

inline constexpr std::uint32_t none_found = 0xffffffffU;

class Groups {
  public:
    Groups(std::vector<std::uint32_t>& storage, std::size_t n) : of_(storage), count_(n) {
        of_.resize(n);
        std::iota(of_.begin(), of_.end(), 0U);
    }
    void join(std::uint32_t i, std::uint32_t j) {
        const std::uint32_t a = root(i);
        const std::uint32_t b = root(j);
        if (a == b) return;
        of_[std::max(a, b)] = std::min(a, b);
        --count_;
    }
    [[nodiscard]] std::size_t count() const { return count_; }
    [[nodiscard]] std::uint32_t root(std::uint32_t i) {
        while (of_[i] != i) i = of_[i] = of_[of_[i]];
        return i;
    }

  private:
    std::vector<std::uint32_t>& of_;
    std::size_t count_;
};

template <int D>
class StarBuilder {
  public:
    StarBuilder(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point, StarWorkspace<D>& workspace,
                Star<D>& out)
        : mesh_(mesh), cavity_(cavity), point_(point), w_(workspace), out_(out) {}

    [[nodiscard]] StarFailure run();

  private:
    struct LineAt {
        VertexId vertex;
        Reference reference = 0;
        JoinedLine line;
    };
    StarFailure take_parts();
    [[nodiscard]] bool is_open(ElementId e, int face) const {
        const FaceNeighbour across = mesh_.face_neighbours[e][face];
        if (across.is_facet()) return !w_.facets.contains(across.facet());
        return !across.valid() || !w_.elements.contains(across.element());
    }
    StarFailure open_faces();
    void collect_boundary();
    StarFailure vertices();
    /// True if the cavity is all elements around the point, which is an inner vertex.
    [[nodiscard]] bool is_ball_inside() const;
    StarFailure faces_at_point();
    void preserve_facet_at(EdgeId edge);
    void list_facet_sides();
    [[nodiscard]] auto vertices_of(SideId<D> side) const {
        if constexpr (D == 2)
            return std::array{side};
        else
            return mesh_.edges[side];
    }
    [[nodiscard]] bool contains_point(SideId<D> side) const {
        return point_.valid() && std::ranges::count(vertices_of(side), point_) > 0;
    }
    using OpenSide = typename StarWorkspace<D>::OpenSide;
    [[nodiscard]] bool is_inside(std::span<const OpenSide> sides, std::size_t first, std::size_t last) const;
    /// True if each connected piece of removed facets has a border. A closed piece would vanish.
    [[nodiscard]] bool pieces_have_sides();
    /// True if each connected piece of removed lines has an end that stays in the mesh or is the point.
    [[nodiscard]] bool pieces_have_ends(std::span<const LineAt> ends);
    /// Joins the border sides of removed facets to the point, before elements (paper §1.3). A side between two removed
    /// facets of one reference is on the border only if a line stays there.
    StarFailure facets();
    [[nodiscard]] Reference reference_beside(const StarFace::Side& side) const;
    static constexpr Reference no_reference = std::numeric_limits<Reference>::min();
    /// Checks that a face at the point has two elements, or one element and a boundary facet. Between materials, it
    /// must have a facet.
    StarFailure faces_complete();
    [[nodiscard]] bool survives(EdgeId edge) const;
    void has_line(EdgeId edge);
    StarFailure lines();
    /// Checks that the joined faces are connected, and have the Euler characteristic V − E + F of a sphere around the
    /// point or of a disc beside it (2D: of a chain).
    StarFailure ball_around();
    /// True if the cavity's elements at the point are connected through faces. Otherwise new elements would form a ring
    /// at the point, or touch only in the point.
    [[nodiscard]] bool is_beside_one_part();
    StarFailure check_existing();
    /// Counts a facet on its edges at the point. Returns false if an edge without a line has facets of two references.
    [[nodiscard]] bool count_facet(const SimplexVertices<D - 1>& facet, Reference reference);
    void count_before(const SimplexVertices<D - 1>& facet);
    /// True if each line at the point has as many facets as before, or as the line that it continues (3D). Otherwise a
    /// surface would begin or end there.
    [[nodiscard]] bool lines_preserve_facets();
    /// Checks that an edge without a line has no facets, or two facets of one reference. The point must be on surfaces
    /// if and only if it was before.
    StarFailure surface_at_point();
    /// True if the facets joined to the point form one chain around it (3D). Otherwise two surfaces would meet at the
    /// point.
    [[nodiscard]] bool is_one_fan();
    [[nodiscard]] bool share_a_vertex(const JoinedFacet& a, const JoinedFacet& b) const;
    void meet(Reference reference) {
        mixed_ = mixed_ || (passing_ > 0 && reference != passing_reference_);
        passing_reference_ = reference;
        ++passing_;
    }
    /// Checks that no line passes through the point, or exactly two lines of one reference.
    StarFailure line_at_point();
    std::size_t facets_at_point_ = 0;
    std::size_t passed_before_ = 0;  ///< number of lines (2D: facets) at the point before the operation
    std::size_t passing_ = 0;
    Reference passing_reference_ = 0;
    bool mixed_ = false;
    const DynamicMesh<D>& mesh_;
    const Cavity<D>& cavity_;
    VertexId point_;
    StarWorkspace<D>& w_;
    Star<D>& out_;
};

}  // namespace camber
