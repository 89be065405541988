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

/// Numbers by ids.
template <class Key>
class FlatMap {
  public:
    static constexpr std::uint32_t none = 0xffffffffU;

    void clear() { numbers_.clear(); }
    /// The key's number; `none` if it has none.
    [[nodiscard]] std::uint32_t find(Key key) const {
        const std::uint32_t* number = numbers_.find(key);
        return number ? *number : none;
    }
    [[nodiscard]] bool contains(Key key) const { return numbers_.contains(key); }
    /// The key's number, which is `number` if it had none.
    std::uint32_t put(Key key, std::uint32_t number) { return numbers_.insert(key, number); }

  private:
    ScratchMap<Key, std::uint32_t> numbers_;
};

}  // namespace camber

export namespace camber {

/// What an operation takes out of a mesh (paper §1.3): elements, and of what lies on their faces and edges the facets
/// and lines that are to be replaced with them.
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

/// A facet of the cavity, by the local vertex in whose place the point comes; the same of a line.
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

/// What is left open around an emptied cavity, and so is to be joined to the point. The new simplices take reference
/// and orientation from those that they are named by, with the point in the place of the local vertex `opposite`.
template <int D>
struct Star {
    std::vector<ElementFace> joined;          ///< faces of removed elements: each makes an element
    std::vector<ElementFace> kept;            ///< such faces that hold the point already: they make none
    std::vector<JoinedFacet> facets;          ///< (3D: edges of removed facets; 2D: their vertices): each makes a facet
    std::vector<JoinedLine> lines;            ///< ends of removed lines: each makes a line
    std::vector<VertexId> boundary;           ///< the vertices of `joined`, as met there: the point has an edge to each
    std::vector<VertexId> vanishing;          ///< vertices of the cavity that are not on its boundary, rising
    VertexPlace place = VertexPlace::inside;  ///< of the point, by what is joined to it

    void clear() {
        joined.clear();
        kept.clear();
        facets.clear();
        lines.clear();
        boundary.clear();
        vanishing.clear();
        place = VertexPlace::inside;
    }
    friend bool operator==(const Star&, const Star&) = default;
};

/// Why a cavity cannot be joined to a point, whatever their places.
enum class StarFailure : std::uint8_t {
    none,
    empty,     ///< nothing is left open that does not hold the point
    required,  ///< a required, frozen or corner entity would go
    surface,   ///< facets would be lost, doubled, come to lie on no face, or make the point what it is not
    line,      ///< the same of lines
    ball,      ///< what is left open is not a sphere around the point, or a disc beside it
    exists,    ///< an edge or face that the star would make is in the mesh already, outside of the cavity
};

}  // namespace camber

/// Operations as cavities (paper §1.3): what is taken out for each, with the facets and lines that go with it. Joined
/// to a new point on the edge it is a split, to a vertex of its boundary a swap, to a neighbour a collapse, to the
/// vertex itself a reinsertion, elsewhere a move.
export namespace camber {

/// The elements around local edge k of an element, the facets on it and its line: of a split, or, where no line is, of
/// a swap.
template <int D>
void cavity_of_edge(const DynamicMesh<D>& mesh, ElementId e, int k, Cavity<D>& out);

/// Everything around a vertex: of a reinsertion, a move, or a collapse.
template <int D>
void cavity_of_vertex(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out);

/// An element joins a cavity, of a surface alone with its triangle.
template <int D>
void join(const DynamicMesh<D>& mesh, Cavity<D>& cavity, ElementId e);

/// Whether v may go into w, the other end of one of its edges, by where they lie: from the inside anywhere, from a
/// surface along it, from a line along it, from a corner nowhere. `around`: cavity_of_vertex of v.
template <int D>
[[nodiscard]] bool may_collapse(const DynamicMesh<D>& mesh, const Cavity<D>& around, VertexId v, VertexId w);

}  // namespace camber

namespace camber {

/// What the faces of a star at its point are named by: their sides opposite the point. 3D: edges; 2D: vertices.
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

/// A face of the star at the point: of which joined faces' elements, or kept faces, and the facet on it.
struct StarFace {
    struct Side {
        std::uint32_t of = 0;  ///< index in `joined` or `kept`
        bool kept = false;
        std::uint8_t local = 0;  ///< joined: the local vertex of the new element that is opposite
    };
    std::array<Side, 2> sides{};
    std::uint32_t count = 0;            ///< of sides; more than two is a failure
    std::uint32_t facet = 0xffffffffU;  ///< index in `facets`
};

/// The name of the face of the new element of `joined` that is opposite its local vertex `local`, which holds the
/// point; and that of a kept face, where the point is its local vertex `point`.
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

/// The faces of the new elements at the point, and of the kept ones, by their names; false where one would have more
/// than two sides.
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
    for (std::uint32_t k = 0; k < star.kept.size(); ++k) {
        const int held = local_vertex(elements[star.kept[k].element.index()], point);
        if (!add(side_without<D>(elements, edges_of, star.kept[k], held), {k, true, 0})) return false;
    }
    return true;
}

}  // namespace camber

export namespace camber {

/// Tables that `star` fills anew each time; one for each thread.
template <int D>
class StarWorkspace {
  public:
    FlatMap<ElementId> elements;
    FlatMap<FacetId> facets;
    FlatMap<LineId> lines;
    FlatMap<VertexId> vertices;  ///< of the boundary: index in `at`
    FlatMap<SideId<D>> names;    ///< index in `faces`
    std::vector<StarFace> faces;
    /// What is known of the edge from the point to a vertex of the boundary.
    struct ToPoint {
        bool is_there = false;     ///< in the cavity already
        bool is_line = false;      ///< it has a line, or gets one
        bool lost_facet = false;   ///< of the vertex: one of its facets is removed
        bool keeps_facet = false;  ///< of the vertex: a side of a removed facet that stays open holds it
        std::uint8_t facets = 0;   ///< on the edge, afterwards
        std::uint8_t before = 0;   ///< a line's: on the edge, or on the line that it comes of, before
        Reference reference = 0;   ///< of these
    };
    std::vector<ToPoint> to_point;
    struct OpenSide {
        SideId<D> name;
        Reference reference = 0;
        JoinedFacet facet;
        bool is_line = false;
    };
    std::vector<OpenSide> open_sides;
    std::vector<ElementId> outside;  ///< all elements at the point
    std::vector<LineId> lines_at_point;
    std::vector<std::uint32_t> groups;
};

/// Empties the cavity and joins what is left open to the point: a vertex of the mesh, or an invalid id for one that is
/// not in it. Ridges, then facets, by reference, then elements (paper §1.3), of any number of materials. Says of the
/// topology all that there is to say: whatever the places of the vertices, the result is a mesh again, with the
/// features that it had. `out` means something only where the result is `none`.
template <int D>
[[nodiscard]] StarFailure star(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point,
                               StarWorkspace<D>& workspace, Star<D>& out);

}  // namespace camber

namespace camber {

inline constexpr std::uint32_t nothing = 0xffffffffU;

/// Items that hang together (union and find).
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
    /// The item that stands for all that hang together with i.
    [[nodiscard]] std::uint32_t root(std::uint32_t i) {
        while (of_[i] != i) i = of_[i] = of_[of_[i]];
        return i;
    }

  private:
    std::vector<std::uint32_t>& of_;
    std::size_t count_;
};

/// A star under way, step by step; each says what is wrong.
template <int D>
class Starring {
  public:
    Starring(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point, StarWorkspace<D>& workspace,
             Star<D>& out)
        : mesh_(mesh), cavity_(cavity), point_(point), w_(workspace), out_(out) {}

    [[nodiscard]] StarFailure run();

  private:
    struct LineAt {
        VertexId vertex;
        Reference reference = 0;
        JoinedLine line;
    };
    /// The cavity as sets; what may not go is not in it.
    StarFailure take_parts();
    [[nodiscard]] bool is_open(ElementId e, int face) const {
        const FaceNeighbour across = mesh_.face_neighbours[e][face];
        if (across.is_facet()) return !w_.facets.contains(across.facet());
        return !across.valid() || !w_.elements.contains(across.element());
    }
    StarFailure open_faces();
    /// The vertices of what is joined.
    void collect_boundary();
    /// Which of them the point has edges to already, and what is not among them, and so vanishes.
    StarFailure vertices();
    /// All that is around a vertex inside, and nothing else, put together again: the mesh as it was.
    [[nodiscard]] bool is_ball_inside() const;
    StarFailure faces_at_point();
    /// A vertex on a line that goes is on the border of its patch.
    void keep_facet_at(EdgeId edge);
    /// The sides of removed facets (3D: edges; 2D: vertices), but for those on lines that go as well.
    void list_facet_sides();
    [[nodiscard]] auto vertices_of(SideId<D> side) const {
        if constexpr (D == 2)
            return std::array{side};
        else
            return mesh_.edges[side];
    }
    [[nodiscard]] bool holds_point(SideId<D> side) const {
        return point_.valid() && std::ranges::count(vertices_of(side), point_) > 0;
    }
    using OpenSide = typename StarWorkspace<D>::OpenSide;
    /// Whether these sides, of one name and reference, are two of a patch that goes on there.
    [[nodiscard]] bool is_inside(std::span<const OpenSide> sides, std::size_t first, std::size_t last) const;
    /// Whether every piece of the removed surface has a side left: a closed one would be gone.
    [[nodiscard]] bool pieces_have_sides();
    /// The same of lines: an end that stays, or is the point.
    [[nodiscard]] bool pieces_have_ends(std::span<const LineAt> ends);
    /// What two removed facets of one reference share is inside of their patch, unless a line that stays runs there;
    /// what is left bounds it (paper §1.3: faces are joined before elements).
    StarFailure facets();
    [[nodiscard]] Reference reference_beside(const StarFace::Side& side) const;
    static constexpr Reference nowhere = std::numeric_limits<Reference>::min();
    /// Every face at the point has an element on both sides, or on one and is a facet of the boundary; materials meet
    /// in facets only.
    StarFailure faces_complete();
    /// An edge of the cavity that the mesh will have afterwards (3D).
    [[nodiscard]] bool survives(EdgeId edge) const;
    /// An edge from the point to the cavity's boundary that has a line of its own already.
    void has_line(EdgeId edge);
    StarFailure lines();
    /// V − E + F of the faces that are joined, and whether they hang together: a sphere around the point, or a disc
    /// beside it (2D: a closed chain, or an open one).
    StarFailure ball_around();
    /// The cavity's elements at a point of the mesh hang together by their faces there: otherwise what is put in their
    /// place would tie the point's surroundings into a ring, or, where there is none, be tied to it by the point alone.
    [[nodiscard]] bool is_beside_one_part();
    /// Around a point of the mesh, outside of the cavity: none of the star's new edges and faces.
    StarFailure nothing_exists();
    /// Counts a facet that has the point, on its edges there.
    [[nodiscard]] bool count_facet(const SimplexVertices<D - 1>& facet, Reference reference);
    /// A facet at the point, before: counted on its edges there.
    void count_before(const SimplexVertices<D - 1>& facet);
    /// Whether each line at the point has as many facets as it had, or as the line that it comes of: a surface that
    /// came to a line which it did not end at, or left one, would be another surface (3D).
    [[nodiscard]] bool lines_keep_their_facets();
    /// Edges at the point that are no lines have no facets, or two of one reference; the point is on surfaces if it
    /// was.
    StarFailure surface_at_point();
    /// The sides that are joined to a point of a surface make one chain (3D): otherwise two surfaces would meet there.
    [[nodiscard]] bool is_one_fan();
    [[nodiscard]] bool share_a_vertex(const JoinedFacet& a, const JoinedFacet& b) const;
    /// What passes through the point: lines (3D), facets (2D).
    void meet(Reference reference) {
        mixed_ = mixed_ || (passing_ > 0 && reference != passing_reference_);
        passing_reference_ = reference;
        ++passing_;
    }
    /// A line goes on through a point, with one reference, or is not there.
    StarFailure line_at_point();
    std::size_t facets_at_point_ = 0;
    std::size_t passed_before_ = 0;  ///< what passed through the point before
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
