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

/// A P2 facet (3D: triangle, 2D: edge) given by its Lagrange nodes: vertices, then mid nodes in the order of
/// `local_edges`.
template <int D>
struct NodalFacet {
    static constexpr int nodes_of_facet = quadratic_nodes<D - 1>;
    std::array<Vec<D>, nodes_of_facet> nodes{};
    friend bool operator==(const NodalFacet&, const NodalFacet&) = default;
};

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

template <int D>
[[nodiscard]] inline NodalFacet<D> nodal_facet(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                               std::span<const LagrangeNode<D>> mid_nodes, FacetId f) {
    NodalFacet<D> facet;
    for (int i = 0; i < D; ++i) facet.nodes[i] = points[mesh.linear.facets.vertices[f][i].index()];
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e)
        facet.nodes[D + e] = mid_nodes[mesh.edges.of_facets[f][e].index()].point;
    return facet;
}

template <int D>
[[nodiscard]] inline NodalFacet<D> nodal_facet(const QuadraticMesh<D>& mesh, FacetId f) {
    return nodal_facet<D>(mesh, mesh.linear.points.view(), mesh.mid_nodes.view(), f);
}

/// Box of the Bézier points, enlarged by their rounding error (below 4 u of the largest coordinate, u = 2⁻⁵³). The box
/// is empty if a node is not finite.
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

enum class Crossing : std::uint8_t {
    disjoint,  ///< proved: the facets have only shared vertices and edges in common
    crossing,  ///< proved: the facets pass through each other
    touching,  ///< proved: the facets have other common points, but do not cross
    undecided  ///< no proof: the facets are too close for the effort or for rounding
};

[[nodiscard]] constexpr std::string_view word(Crossing crossing) {
    switch (crossing) {
        case Crossing::disjoint: return "disjoint";
        case Crossing::crossing: return "crossing";
        case Crossing::touching: return "touching";
        case Crossing::undecided: break;
    }
    return "undecided";
}

/// Maximum number of pairs of pieces tested for a pair of facets.
inline constexpr int default_effort = 4000;

/// Tests two P2 facets for common points other than shared ones. Shared are vertices at the same position, and edges
/// whose three nodes are at the same positions. If all nodes are shared, the facets are the sides of a slit, and
/// disjoint. Proofs hold for the stored nodes, rounding included. Facets are straight if their mid nodes equal
/// `midpoint`; two straight facets with nonzero area are always decided, if necessary in integers. Coplanar facets are
/// disjoint or touching. Nodes that are not finite: undecided.
template <int D>
[[nodiscard]] Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second,
                                   int effort = default_effort);

/// Tests a facet for self-intersection. The result is `disjoint` if it has none, as any regular plane curve.
template <int D>
[[nodiscard]] Crossing crossing_of_itself(const NodalFacet<D>& facet, int effort = default_effort);

}  // namespace camber

namespace camber {

struct CrossingResult {
    Crossing verdict = Crossing::undecided;
    int steps = 0;           ///< pairs of pieces tested
    bool cut_short = false;  ///< undecided because of limited effort
};

template <int D>
[[nodiscard]] CrossingResult test_pair(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort);
template <int D>
[[nodiscard]] CrossingResult test_self_crossing(const NodalFacet<D>& facet, int effort);

}  // namespace camber

export namespace camber {

/// Dynamic set of facet boxes. There is a grid for each cell size, a power of two. A facet belongs to the grid with
/// cells just larger than its box, and to the cell of the box's lower corner. Results do not depend on the insertion
/// order.
template <int D>
class FacetGrid {
  public:
    /// Inserts a facet, or replaces its box. Coordinates must be finite.
    void insert(FacetId facet, const Box<D>& box);
    void remove(FacetId facet);

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool contains(FacetId facet) const {
        return facet.index() < entries_.size() && entries_[facet.index()].grid != no_entry;
    }
    [[nodiscard]] const Box<D>& box(FacetId facet) const { return entries_[facet.index()].box; }

    /// Sets `found` to the facets, in ascending order, whose boxes have a point in common with the closed `box`.
    void meeting(const Box<D>& box, std::vector<FacetId>& found) const;

  private:
    static constexpr std::uint32_t no_entry = 0xffffffffU;
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
    struct Entry {
        Box<D> box;
        std::uint32_t grid = no_entry;
        std::uint32_t before = no_entry, after = no_entry;
        std::uint32_t place = 0;
    };
    struct Grid {
        int exponent = 0;
        std::unordered_map<Cell, std::uint32_t, CellHash> first;
        std::vector<std::uint32_t> members;
    };

    [[nodiscard]] static Cell cell_of(const Vec<D>& p, int exponent);
    [[nodiscard]] std::uint32_t grid_for(const Box<D>& box);
    void look_into(const Grid& grid, const Box<D>& box, std::vector<FacetId>& found) const;

    std::vector<Entry> entries_;
    std::vector<Grid> grids_;
    std::size_t size_ = 0;
};

/// A pair of facets, or a facet with itself, that is not disjoint.
struct FacetCrossing {
    FacetId first, second;
    Crossing verdict = Crossing::undecided;
    friend bool operator==(const FacetCrossing&, const FacetCrossing&) = default;
};

/// Maximum number of pairs of pieces tested for all facet pairs that the first tests leave undecided.
[[nodiscard]] constexpr std::size_t max_steps(std::size_t facets) { return 100'000 + 16 * facets; }

struct Crossings {
    std::size_t pairs = 0;  ///< facet pairs with overlapping boxes; other pairs are disjoint
    std::size_t crossing = 0, touching = 0, undecided = 0;
    std::size_t cut_short = 0;              ///< pairs undecided because of limited effort
    std::size_t steps = 0;                  ///< pairs of pieces tested
    std::vector<FacetCrossing> found = {};  ///< pairs that are not disjoint, sorted

    [[nodiscard]] bool all_disjoint() const { return found.empty(); }
    friend bool operator==(const Crossings&, const Crossings&) = default;
};

/// Tests boundary and interface facets for crossings and self-intersections, which valid elements (det J > 0) do not
/// exclude. All pairs are tested first with small effort. The pairs that are then undecided share `max_steps`. Time: n
/// log n plus the tests of close pairs. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                                std::span<const LagrangeNode<D>> mid_nodes, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const LinearMesh<D>& mesh, const Execution& execution);

}  // namespace camber

namespace camber {

/// A vector and its 1-norm, which is an upper bound of its length.
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

/// Bound of the error of a product of two or three vectors, relative to the product of their sizes. Node differences
/// have one rounding for each component; fewer than 40 roundings follow.
inline constexpr double product_error = 0x1p-46;

/// Sign of a product of vectors, or 0 if rounding makes it uncertain.
[[nodiscard]] inline int certain_sign(double product, double sizes) {
    const double error = product_error * sizes;
    return product > error ? 1 : product < -error ? -1 : 0;
}
[[nodiscard]] inline int sign_of(const Side<2>& a, const Side<2>& b) {
    return certain_sign(a.along[0] * b.along[1] - a.along[1] * b.along[0], a.size * b.size);
}

/// Normal of a triangle, and the product of the sizes of two sides.
struct Normal {
    Vec<3> direction;
    double size = 0;
};
[[nodiscard]] inline Normal normal_of(const Side<3>& a, const Side<3>& b) {
    return {cross(a.along, b.along), a.size * b.size};
}
/// Side of the triangle's plane on which a point lies; `to` goes from a corner to the point.
[[nodiscard]] inline int sign_of(const Normal& n, const Side<3>& to) {
    return certain_sign(dot(n.direction, to.along), n.size * to.size);
}
[[nodiscard]] inline bool are_equal_signs(int a, int b) { return a != 0 && a == b; }

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

/// Two triangles have a common corner, at which the first has the sides a and b, the second c and d. Returns true if a
/// line through the corner separates their projections along the first triangle's normal.
[[nodiscard]] inline bool are_apart_along(const Normal& n, const Side<3>& a, const Side<3>& b, const Side<3>& c,
                                          const Side<3>& d) {
    const auto turn = [&](const Side<3>& x, const Side<3>& y) {
        return certain_sign(dot(n.direction, cross(x.along, y.along)), n.size * x.size * y.size);
    };
    const int ac = turn(a, c), ad = turn(a, d), bc = turn(b, c), bd = turn(b, d);
    if ((ac < 0 && ad < 0) || (bc > 0 && bd > 0)) return true;  // in the projection, b is to the left of a
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

/// Fast test (about 10 ns) of straight facets by their vertices. True: they are proved disjoint except for shared
/// vertices and edges.
template <int D>
[[nodiscard]] inline bool are_surely_disjoint(const NodalFacet<D>& first, const NodalFacet<D>& second) {
    return are_apart(shared_first(first, second));
}

template <int D>
struct ElementOverlap {
    ElementId first, second;  ///< first < second; equal if only one element certainly contains the point
    Vec<D> point;             ///< inside both elements if they are straight (model units)
    friend bool operator==(const ElementOverlap&, const ElementOverlap&) = default;
};

template <int D>
struct Overlaps {
    bool looked_at = false;       ///< false: the mesh has no elements, or an open boundary
    std::size_t walls = 0;        ///< boundary parts (walls) that were tested
    std::size_t undecided = 0;    ///< walls without a certified result
    std::size_t overlapping = 0;  ///< number of touching facet pairs and of walls inside other elements
    /// Unique, sorted pairs of elements: one pair for each of the `overlapping` items.
    std::vector<ElementOverlap<D>> found = {};

    friend bool operator==(const Overlaps&, const Overlaps&) = default;
};

/// Finds overlapping elements even if no facets cross: bodies with coplanar sides, a body inside another, a region
/// meshed twice. Results are certified, rounding included. Method and completeness: docs/algorithms/crossing.md.
///
/// `mesh`: all boundary faces are listed, elements are positive, and there are no duplicate elements or facets.
/// `crossings`: from `find_crossings`. Time: linear in elements, n log n in boundary facets. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Crossings& crossings,
                                                 const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const LinearMesh<D>& mesh, const Crossings& crossings,
                                                 const Execution& execution);

/// Also computes the crossings.
template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Execution& execution);

}  // namespace camber
