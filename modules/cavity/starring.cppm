module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>
module camber.cavity:starring;
import camber.core;
import :around;
import :emptied;
import :flat_map;
import :mesh;
import :star;

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

/// A star under way, step by step; each says what is wrong. Elements in star.cpp, facets in star_surface.cpp, lines in
/// star_lines.cpp.
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
