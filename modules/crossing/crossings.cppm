module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>
export module camber.crossing:crossings;
import camber.core;
import camber.bezier;

export namespace camber {

/// A P2 facet in D dimensions (a triangle in space, an edge in the plane) by the mesh's Lagrange nodes: its vertices,
/// then the mid nodes in the order of `local_edges`.
template <int D>
struct NodalFacet {
    static constexpr int nodes_of_facet = quadratic_nodes<D - 1>;
    std::array<Vec<D>, nodes_of_facet> nodes{};
    friend bool operator==(const NodalFacet&, const NodalFacet&) = default;
};

/// The facet of these vertices with its nodes at the middle of the chords.
template <int D>
[[nodiscard]] inline NodalFacet<D> straight_facet(const std::array<Vec<D>, D>& vertices) {
    NodalFacet<D> facet;
    std::copy(vertices.begin(), vertices.end(), facet.nodes.begin());
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        facet.nodes[D + e] = midpoint(vertices[i], vertices[j]);
    }
    return facet;
}

/// Facet f of the mesh, with other places of points and mid nodes: those of a proposal.
template <int D>
[[nodiscard]] inline NodalFacet<D> nodal_facet(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                               std::span<const LagrangeNode<D>> mid_nodes, FacetId f) {
    NodalFacet<D> facet;
    for (int i = 0; i < D; ++i) facet.nodes[i] = points[mesh.linear.facets.vertices[f][i].index()];
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e)
        facet.nodes[D + e] = mid_nodes[mesh.edges.of_facets[f][e].index()].point;
    return facet;
}

/// Facet f of the mesh.
template <int D>
[[nodiscard]] inline NodalFacet<D> nodal_facet(const QuadraticMesh<D>& mesh, FacetId f) {
    return nodal_facet<D>(mesh, mesh.linear.points.view(), mesh.mid_nodes.view(), f);
}

/// A box that holds the whole facet, rounding included: of its Bézier points, which err by less than
/// 4 u of the largest coordinate; empty where a node is not finite.
template <int D>
[[nodiscard]] inline Box<D> box_of(const NodalFacet<D>& facet) {
    Box<D> box;
    double largest = 0;
    const auto include = [&](const Vec<D>& p) {
        box.include(p);
        for (const double x : p.c) largest = std::max(largest, std::abs(x));
    };
    for (int i = 0; i < D; ++i) include(facet.nodes[i]);
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        include(control_point(facet.nodes[i], {facet.nodes[D + e]}, facet.nodes[j]).point);
    }
    const double blur = 0x1p-49 * largest;
    for (int c = 0; c < D; ++c) {
        box.low[c] -= blur;
        box.high[c] += blur;
    }
    return box;
}

/// Do two facets cross?
enum class Crossing : std::uint8_t {
    disjoint,  ///< proved: they have nothing in common but what they share
    crossing,  ///< proved: they pass through each other
    touching,  ///< proved: they have more in common than they share, and do not pass through each other: contact
    undecided  ///< nearer to each other than the work or rounding allow to tell
};

/// "disjoint", "crossing", "touching", "undecided".
[[nodiscard]] constexpr std::string_view word(Crossing crossing) {
    switch (crossing) {
        case Crossing::disjoint: return "disjoint";
        case Crossing::crossing: return "crossing";
        case Crossing::touching: return "touching";
        case Crossing::undecided: break;
    }
    return "undecided";
}

/// Pairs of pieces that are looked at before two facets are left undecided.
inline constexpr int default_effort = 4000;

/// Whether two P2 facets have points in common other than what they share by right: vertices at the same place, and
/// edges of which all three nodes are. Facets of which all nodes are at the same places are one (the two sides of a
/// slit), and disjoint. Proofs hold for the nodes as they are stored, rounding included; facets whose mid nodes are
/// `midpoint` of their edges' ends are straight, and two of them are always decided (those without area are not), in
/// integers if need be. Facets in one plane do not pass through each other: they are disjoint or touch. Nodes that are
/// not finite: undecided.
template <int D>
[[nodiscard]] Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second,
                                   int effort = default_effort);

/// Whether a facet has a point twice. A curve in the plane has none unless it turns back on itself, where it is not
/// regular: disjoint.
template <int D>
[[nodiscard]] Crossing crossing_of_itself(const NodalFacet<D>& facet, int effort = default_effort);

}  // namespace camber

namespace camber {

/// A verdict, and what it took.
struct Judgement {
    Crossing verdict = Crossing::undecided;
    int steps = 0;           ///< pairs of pieces that were looked at
    bool cut_short = false;  ///< undecided for want of effort: more of it may tell
};

/// `crossing_of` and `crossing_of_itself`, with what they took.
template <int D>
[[nodiscard]] Judgement judge_pair(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort);
template <int D>
[[nodiscard]] Judgement judge_itself(const NodalFacet<D>& facet, int effort);

}  // namespace camber

export namespace camber {

/// Boxes of facets that come and go: which of them meet a box? A grid for each size of facets, its cells twice as large
/// from one to the next; a facet is in the cell of its lowest corner on the grid whose cells are just larger than its
/// box. A value; the answers depend on what is in it alone, not on the order in which it came.
template <int D>
class FacetGrid {
  public:
    /// A facet that is there already gets the new box. Coordinates must be finite.
    void insert(FacetId facet, const Box<D>& box);
    /// Nothing happens where it is not there.
    void remove(FacetId facet);

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool contains(FacetId facet) const {
        return facet.index() < entries_.size() && entries_[facet.index()].grid != nowhere;
    }
    [[nodiscard]] const Box<D>& box(FacetId facet) const { return entries_[facet.index()].box; }

    /// The facets whose boxes meet the box (touching is meeting), in rising order, in place of what `found` held.
    void meeting(const Box<D>& box, std::vector<FacetId>& found) const;

  private:
    static constexpr std::uint32_t nowhere = 0xffffffffU;
    using Cell = std::array<std::int64_t, D>;
    struct CellHash {
        std::size_t operator()(const Cell& cell) const {
            std::uint64_t h = 0;
            for (const std::int64_t x : cell) {
                h = (h ^ static_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15ULL;
                h ^= h >> 29U;
            }
            return h;
        }
    };
    /// The facets of one cell are a list through the entries.
    struct Entry {
        Box<D> box;
        std::uint32_t grid = nowhere;
        std::uint32_t before = nowhere, after = nowhere;
        std::uint32_t place = 0;  ///< in the grid's `members`
    };
    struct Grid {
        int exponent = 0;  ///< cells are 2^exponent wide
        std::unordered_map<Cell, std::uint32_t, CellHash> first;
        std::vector<std::uint32_t> members;
    };

    [[nodiscard]] static Cell cell_of(const Vec<D>& p, int exponent);
    [[nodiscard]] std::uint32_t grid_for(const Box<D>& box);
    void look_into(const Grid& grid, const Box<D>& box, std::vector<FacetId>& found) const;

    std::vector<Entry> entries_;  ///< by facet
    std::vector<Grid> grids_;
    std::size_t size_ = 0;
};

/// Two facets that are not disjoint; one that is not of itself.
struct FacetCrossing {
    FacetId first, second;  ///< the lower one first; the same twice: of itself
    Crossing verdict = Crossing::undecided;
    friend bool operator==(const FacetCrossing&, const FacetCrossing&) = default;
};

/// Pairs of pieces that a mesh's open pairs of facets may take in all.
[[nodiscard]] constexpr std::size_t max_steps(std::size_t facets) { return 100'000 + 16 * facets; }

/// What became of all pairs of a mesh's facets.
struct Crossings {
    std::size_t pairs = 0;  ///< whose boxes meet, and that were looked at; the others are disjoint by their boxes
    std::size_t crossing = 0, touching = 0, undecided = 0;
    std::size_t cut_short = 0;              ///< of the undecided: for want of work; more of it might have told
    std::size_t steps = 0;                  ///< the work: pairs of pieces that were looked at
    std::vector<FacetCrossing> found = {};  ///< those that are not disjoint, by rising facets

    [[nodiscard]] bool all_disjoint() const { return found.empty(); }
    friend bool operator==(const Crossings&, const Crossings&) = default;
};

/// Whether the mesh's facets (boundary and interfaces) cross each other or themselves. Elements may all be valid and
/// walls yet pass through each other: det J > 0 speaks of each element alone. Every pair has a first look; what that
/// leaves open shares `max_steps`. Time: n log n and what pairs of near facets take. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, const Execution& execution);

/// The same with other places of vertices and mid nodes: those of a proposal.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                                std::span<const LagrangeNode<D>> mid_nodes, const Execution& execution);

/// The same of a straight mesh.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const LinearMesh<D>& mesh, const Execution& execution);

}  // namespace camber

namespace camber {

/// A vector, and the sum of its components' absolute values: not below its length.
template <int D>
struct Side {
    Vec<D> along;
    double size = 0;
};
template <int D>
[[nodiscard]] inline Side<D> side_between(const Vec<D>& from, const Vec<D>& to) {
    Side<D> side{to - from};
    for (const double x : side.along.c) side.size += std::abs(x);
    return side;
}

/// Error of a product of two or three vectors, as a share of the product of their sizes: each component of a difference
/// of nodes is exact to a rounding, and fewer than 40 roundings follow.
inline constexpr double product_error = 0x1p-46;

/// Sign of a product where rounding leaves no doubt, else 0.
[[nodiscard]] inline int certain_sign(double product, double sizes) {
    const double error = product_error * sizes;
    return product > error ? 1 : product < -error ? -1 : 0;
}
[[nodiscard]] inline int sign_of(const Side<2>& a, const Side<2>& b) {
    return certain_sign(a.along[0] * b.along[1] - a.along[1] * b.along[0], a.size * b.size);
}

/// A triangle's normal, and the product of the sizes of its sides.
struct Normal {
    Vec<3> direction;
    double size = 0;
};
[[nodiscard]] inline Normal normal_of(const Side<3>& a, const Side<3>& b) {
    return {cross(a.along, b.along), a.size * b.size};
}
/// The side of the triangle's plane on which a point lies, seen from a corner of the triangle.
[[nodiscard]] inline int sign_of(const Normal& n, const Side<3>& to) {
    return certain_sign(dot(n.direction, to.along), n.size * to.size);
}
[[nodiscard]] inline bool are_equal_signs(int a, int b) { return a != 0 && a == b; }

/// The vertices of a straight facet, those first that both have.
template <int D>
struct SharedFirst {
    std::array<Vec<D>, D> first, second;
    int shared = 0;
};
template <int D>
[[nodiscard]] inline SharedFirst<D> shared_first(const NodalFacet<D>& f, const NodalFacet<D>& g) {
    SharedFirst<D> both;
    std::array<bool, D> is_shared{};
    int rest = D;
    for (int i = 0; i < D; ++i) {
        bool found = false;
        for (int j = 0; j < D && !found; ++j)
            if (!is_shared[j] && f.nodes[i] == g.nodes[j]) found = is_shared[j] = true;
        if (found) {
            both.first[both.shared] = both.second[both.shared] = f.nodes[i];
            ++both.shared;
        } else {
            both.first[--rest] = f.nodes[i];
        }
    }
    for (int j = 0, next = both.shared; j < D; ++j)
        if (!is_shared[j]) both.second[next++] = g.nodes[j];
    return both;
}

/// Two triangles with a common corner, by their sides there: true if a line through it, seen along the normal of the
/// first, has them on different sides.
[[nodiscard]] inline bool are_apart_along(const Normal& n, const Side<3>& a, const Side<3>& b, const Side<3>& c,
                                          const Side<3>& d) {
    const auto turn = [&](const Side<3>& x, const Side<3>& y) {
        return certain_sign(dot(n.direction, cross(x.along, y.along)), n.size * x.size * y.size);
    };
    const int ac = turn(a, c), ad = turn(a, d), bc = turn(b, c), bd = turn(b, d);
    if ((ac < 0 && ad < 0) || (bc > 0 && bd > 0)) return true;  // b is on the left of a
    const int cd = turn(c, d);
    return (are_equal_signs(cd, ac) && are_equal_signs(cd, bc)) ||
           (are_equal_signs(cd, -ad) && are_equal_signs(cd, -bd));
}

[[nodiscard]] inline bool are_apart(const SharedFirst<2>& of) {
    const auto& [f, g, shared] = of;
    if (shared == 2) return true;
    const Side<2> own = side_between(f[0], f[1]), other = side_between(g[0], g[1]);
    if (shared == 1)
        return sign_of(own, other) != 0 || certain_sign(dot(own.along, other.along), own.size * other.size) < 0;
    const auto is_beside = [](const Side<2>& line, const Vec<2>& from, const std::array<Vec<2>, 2>& ends) {
        return are_equal_signs(sign_of(line, side_between(from, ends[0])), sign_of(line, side_between(from, ends[1])));
    };
    return is_beside(own, f[0], g) || is_beside(other, g[0], f);
}

[[nodiscard]] inline bool are_apart(const SharedFirst<3>& of) {
    const auto& [f, g, shared] = of;
    if (shared == 3) return true;
    const Side<3> a = side_between(f[0], f[1]), b = side_between(f[0], f[2]);
    const Normal n = normal_of(a, b);
    if (shared == 2) {
        const Side<3> other = side_between(f[0], g[2]);
        if (sign_of(n, other) != 0) return true;
        const Normal m = normal_of(a, other);
        return certain_sign(dot(n.direction, m.direction), n.size * m.size) < 0;
    }
    const Side<3> c = side_between(g[0], g[1]), d = side_between(g[0], g[2]);
    const Normal m = normal_of(c, d);
    if (shared == 1)
        return are_equal_signs(sign_of(n, c), sign_of(n, d)) || are_equal_signs(sign_of(m, a), sign_of(m, b)) ||
               are_apart_along(n, a, b, c, d) || are_apart_along(m, c, d, a, b);
    const auto is_beside = [](const Normal& of_plane, const Vec<3>& from, const std::array<Vec<3>, 3>& corners) {
        const int sign = sign_of(of_plane, side_between(from, corners[0]));
        return are_equal_signs(sign, sign_of(of_plane, side_between(from, corners[1]))) &&
               are_equal_signs(sign, sign_of(of_plane, side_between(from, corners[2])));
    };
    return is_beside(n, f[0], g) || is_beside(m, g[0], f);
}

}  // namespace camber

export namespace camber {

/// A quick test of straight facets, of which only the vertices are read: true if they are proved to have nothing in
/// common but vertices and edges at the same places. It takes about 10 ns; false leaves the pair to `crossing_of`.
template <int D>
[[nodiscard]] inline bool are_surely_disjoint(const NodalFacet<D>& first, const NodalFacet<D>& second) {
    return are_apart(shared_first(first, second));
}

/// Two elements with interior points in common.
template <int D>
struct ElementOverlap {
    ElementId first, second;  ///< the lower one first; equal if one of them alone certainly contains the point
    Vec<D> point;             ///< a point inside both, where they are straight (model units)
    friend bool operator==(const ElementOverlap&, const ElementOverlap&) = default;
};

/// The places where elements of a mesh overlap.
template <int D>
struct Overlaps {
    bool looked_at = false;       ///< false: no elements, or a boundary that is not closed
    std::size_t walls = 0;        ///< connected parts of the boundary along which nothing else touches it
    std::size_t undecided = 0;    ///< parts for which no certified answer was found
    std::size_t overlapping = 0;  ///< pairs of facets that touch, and parts of the boundary, inside other elements
    /// One pair of elements for each of the `overlapping`, without repetitions, by rising elements.
    std::vector<ElementOverlap<D>> found = {};

    friend bool operator==(const Overlaps&, const Overlaps&) = default;
};

/// Finds elements that overlap although no walls cross: bodies with sides in common planes, one body inside the
/// elements of another, a mesh that covers a region twice. Every answer is certified, rounding included. Method and
/// completeness: docs/algorithms/crossing.md.
///
/// `mesh` lists all boundary faces, its elements are numbered with positive orientation, and no element or facet occurs
/// twice; `crossings` is the result of `find_crossings` for the same mesh. Time: linear in elements, n log n in
/// boundary facets. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Crossings& crossings,
                                                 const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const LinearMesh<D>& mesh, const Crossings& crossings,
                                                 const Execution& execution);

/// The same with the search for crossings.
template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Execution& execution);

}  // namespace camber
