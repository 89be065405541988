// Verdicts on facet pairs: quadratic facets by division, straight ones in integers.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
#include <boost/multiprecision/cpp_int.hpp>
module camber.crossing;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
CrossingResult search_pair(const NetPair<D>& pair, int effort, int steps, bool cut_short) {
    Search<D> search(effort);
    const Crossing verdict = search.pair(pair.first, pair.second);
    return {verdict, steps + search.steps(), verdict == Crossing::undecided && (cut_short || search.cut_short())};
}

CrossingResult judge_bent(const NodalFacet<2>&, const NodalFacet<2>&, const NetPair<2>& pair, int effort) {
    return search_pair(pair, effort, 1, false);
}

CrossingResult judge_bent(const NodalFacet<3>& first, const NodalFacet<3>& second, const NetPair<3>& pair, int effort) {
    PlanarTest planar(pair.first, pair.second, effort);
    const auto planar_verdict = planar.verdict([&] { return are_in_one_plane(first, second); });
    if (planar_verdict) return {*planar_verdict, planar.steps() + 1, false};
    return search_pair(pair, effort, planar.steps() + 1, planar.cut_short());
}

}  // namespace

template <int D>
CrossingResult test_pair(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort) {
    if (first == second) return {Crossing::disjoint, 0, false};
    const auto pair = net_pair(first, second);
    if (pair) {
        if (pair->same) return {Crossing::disjoint, 0, false};
        const Crossing found = Search<D>(1).pair(pair->first, pair->second);
        if (found != Crossing::undecided) return {found, 1, false};
    }
    if (is_straight(first) && is_straight(second))
        if (const auto exact = crossing_of_straight(first, second)) return {*exact, 1, false};
    if (!pair) return {Crossing::undecided, 0, false};
    return judge_bent(first, second, *pair, effort);
}

template <>
CrossingResult test_self_crossing<2>(const NodalFacet<2>&, int) {
    return {Crossing::disjoint, 0, false};
}

template <>
CrossingResult test_self_crossing<3>(const NodalFacet<3>& facet, int effort) {
    const Vec<3> origin = facet.nodes[0];
    const auto unit = unit_for(facet, facet, origin);
    if (!unit) return {Crossing::undecided, 0, false};
    const Net<3> net = net_of(facet, origin, *unit);
    if (Search<3>(1).itself(net) == Crossing::disjoint || is_simple_in_plane(net))
        return {Crossing::disjoint, 1, false};
    Search<3> search(effort);
    const Crossing verdict = search.itself(net);
    return {verdict, 1 + search.steps(), verdict == Crossing::undecided && search.cut_short()};
}

template <int D>
Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort) {
    return test_pair(first, second, effort).verdict;
}

template <int D>
Crossing crossing_of_itself(const NodalFacet<D>& facet, int effort) {
    return test_self_crossing(facet, effort).verdict;
}

}  // namespace camber

// Coordinates as integers, which is possible because doubles are multiples of a power of two. Each axis has its own
// power, because scaling of an axis preserves intersections.
namespace camber {

namespace {

using Integer =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<512>, boost::multiprecision::et_off>;

template <int D>
using Point = std::array<Integer, D>;
template <int D>
using Simplex = std::array<Point<D>, D>;

/// x = mantissa · 2^exponent.
std::pair<std::int64_t, int> parts_of(double x) {
    const int exponent = std::ilogb(x) - 52;
    return {static_cast<std::int64_t>(std::scalbn(x, -exponent)), exponent};
}

template <int D>
std::vector<Point<D>> integers(const std::vector<Vec<D>>& points) {
    std::vector<Point<D>> out(points.size());
    for (int c = 0; c < D; ++c) {
        int lowest = 2000;
        for (const Vec<D>& p : points)
            if (p[c] != 0) lowest = std::min(lowest, parts_of(p[c]).second);
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (points[i][c] == 0) continue;
            const auto [mantissa, exponent] = parts_of(points[i][c]);
            out[i][c] = Integer(mantissa) << (exponent - lowest);
        }
    }
    return out;
}

template <int D>
std::optional<std::array<Simplex<D>, 2>> simplices(const NodalFacet<D>& first, const NodalFacet<D>& second) {
    std::vector<Vec<D>> vertices;
    for (const auto* facet : {&first, &second})
        for (int i = 0; i < D; ++i) {
            if (!is_finite(facet->nodes[i])) return {};
            vertices.push_back(facet->nodes[i]);
        }
    const auto points = integers<D>(vertices);
    std::array<Simplex<D>, 2> out;
    for (int i = 0; i < D; ++i) {
        out[0][i] = points[i];
        out[1][i] = points[D + i];
    }
    return out;
}

template <int D>
Integer area(const Point<D>& p, const Point<D>& q, const Point<D>& r, int x, int y) {
    return (q[x] - p[x]) * (r[y] - p[y]) - (q[y] - p[y]) * (r[x] - p[x]);
}

Point<3> normal_of(const Point<3>& p, const Point<3>& q, const Point<3>& r) {
    return {area<3>(p, q, r, 1, 2), area<3>(p, q, r, 2, 0), area<3>(p, q, r, 0, 1)};
}

template <int D>
int common_vertices(const Simplex<D>& a, const Simplex<D>& b) {
    int count = 0;
    for (const Point<D>& p : a) count += static_cast<int>(std::count(b.begin(), b.end(), p));
    return count;
}

/// The fraction above / below, with below > 0.
struct Ratio {
    Integer above, below = 1;
    friend bool operator<(const Ratio& a, const Ratio& b) { return a.above * b.below < b.above * a.below; }
};

struct LineInterval {
    std::optional<Ratio> low = {}, high = {};

    void include(const Ratio& x) {
        if (!low || x < *low) low = x;
        if (!high || *high < x) high = x;
    }
};

enum class Overlap : std::uint8_t { none, point, stretch };

Overlap overlap(const LineInterval& a, const LineInterval& b) {
    if (!a.low || !b.low) return Overlap::none;
    const Ratio& low = *a.low < *b.low ? *b.low : *a.low;
    const Ratio& high = *a.high < *b.high ? *a.high : *b.high;
    return low < high ? Overlap::stretch : high < low ? Overlap::none : Overlap::point;
}

/// Signed heights of vertices over a line or plane.
template <std::size_t N>
struct Sides {
    std::array<Integer, N> heights;

    [[nodiscard]] bool any_above() const {
        return std::any_of(heights.begin(), heights.end(), [](const Integer& h) { return h > 0; });
    }
    [[nodiscard]] bool any_below() const {
        return std::any_of(heights.begin(), heights.end(), [](const Integer& h) { return h < 0; });
    }
    [[nodiscard]] bool straddle() const { return any_above() && any_below(); }
    [[nodiscard]] bool all_on() const { return !any_above() && !any_below(); }
    [[nodiscard]] bool apart() const {
        return std::all_of(heights.begin(), heights.end(), [](const Integer& h) { return h > 0; }) ||
               std::all_of(heights.begin(), heights.end(), [](const Integer& h) { return h < 0; });
    }
};

template <int D>
LineInterval section(const Simplex<D>& t, const Sides<D>& sides, int axis) {
    LineInterval s;
    for (int i = 0; i < D; ++i) {
        const Integer& h = sides.heights[i];
        if (h == 0) s.include({t[i][axis]});
        const int j = (i + 1) % D;
        const Integer& k = sides.heights[j];
        if ((h > 0 && k < 0) || (h < 0 && k > 0)) {
            const Integer above = t[i][axis] * k - t[j][axis] * h, below = k - h;
            s.include(below > 0 ? Ratio{above, below} : Ratio{-above, -below});
        }
    }
    return s;
}

Crossing contact(Overlap overlap, int common) {
    const bool is_shared = overlap == Overlap::point ? common > 0 : common == 2;
    return overlap == Overlap::none || is_shared ? Crossing::disjoint : Crossing::touching;
}

template <int D>
int axis_of(const Point<D>& v) {
    int axis = 0;
    while (axis < D - 1 && v[axis] == 0) ++axis;
    return axis;
}

int axis_of_line(const Point<3>& n, const Point<3>& m) {
    return axis_of<3>({n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2], n[0] * m[1] - n[1] * m[0]});
}

struct EdgeInPlane {
    Point<3> p, q;
    bool is_left = false;
    Sides<3> other;  ///< heights of the other triangle's vertices over this edge, positive on its left
};
std::array<EdgeInPlane, 6> edges_in_plane(const Simplex<3>& a, const Simplex<3>& b, int x, int y) {
    std::array<EdgeInPlane, 6> edges;
    for (int i = 0; i < 6; ++i) {
        const Simplex<3>&t = i < 3 ? a : b, &other = i < 3 ? b : a;
        EdgeInPlane& edge = edges[i];
        edge.p = t[i % 3];
        edge.q = t[(i + 1) % 3];
        edge.is_left = area<3>(edge.p, edge.q, t[(i + 2) % 3], x, y) > 0;
        for (int k = 0; k < 3; ++k) edge.other.heights[k] = area<3>(edge.p, edge.q, other[k], x, y);
    }
    return edges;
}

/// Triangles are projected to the plane of axes x and y. They are convex, so they overlap unless the line of an edge
/// separates them; if they meet on this line, they touch.
Crossing in_plane(const Simplex<3>& a, const Simplex<3>& b, int x, int y, int common) {
    bool overlap_everywhere = true;
    Crossing found = Crossing::disjoint;
    const auto edges = edges_in_plane(a, b, x, y);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& [p, q, is_left, sides] = edges[i];
        if (is_left ? sides.any_above() : sides.any_below()) continue;
        if (sides.apart()) return Crossing::disjoint;
        overlap_everywhere = false;
        const int axis = p[x] != q[x] ? x : y;
        LineInterval edge;
        edge.include({p[axis]});
        edge.include({q[axis]});
        found = contact(overlap(edge, section<3>(i < 3 ? b : a, sides, axis)), common);
    }
    return overlap_everywhere ? Crossing::touching : found;
}

Sides<3> sides_of(const Simplex<3>& t, const Point<3>& normal, const Point<3>& at) {
    Sides<3> s;
    for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 3; ++c) s.heights[i] += normal[c] * (t[i][c] - at[c]);
    return s;
}
Sides<2> sides_of(const Simplex<2>& t, const Simplex<2>& line) {
    return {{area<2>(line[0], line[1], t[0], 0, 1), area<2>(line[0], line[1], t[1], 0, 1)}};
}

bool share_area(const Simplex<3>& a, const Simplex<3>& b, int x, int y) {
    return std::ranges::all_of(edges_in_plane(a, b, x, y), [](const EdgeInPlane& edge) {
        return edge.is_left ? edge.other.any_above() : edge.other.any_below();
    });
}

bool meets_inside(const LineInterval& first, const LineInterval& second) {
    return first.low && second.low && *first.low < *second.high && *second.low < *first.high;
}

}  // namespace

std::optional<Crossing> crossing_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second) {
    const auto both = simplices<2>(first, second);
    if (!both) return {};
    const auto& [a, b] = *both;
    if (a[0] == a[1] || b[0] == b[1]) return {};
    const int common = common_vertices<2>(a, b);
    const Sides<2> of_a = sides_of(a, b), of_b = sides_of(b, a);
    if (of_a.apart() || of_b.apart()) return Crossing::disjoint;
    if (of_a.straddle() && of_b.straddle()) return Crossing::crossing;
    if (!of_a.all_on()) return common > 0 ? Crossing::disjoint : Crossing::touching;
    const int axis = a[0][0] != a[1][0] ? 0 : 1;
    return contact(overlap(section<2>(a, of_a, axis), section<2>(b, of_b, axis)), common);
}

std::optional<Crossing> crossing_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second) {
    const auto both = simplices<3>(first, second);
    if (!both) return {};
    const auto& [a, b] = *both;
    const Point<3> n = normal_of(a[0], a[1], a[2]), m = normal_of(b[0], b[1], b[2]);
    if (n == Point<3>{} || m == Point<3>{}) return {};
    const Sides<3> of_a = sides_of(a, m, b[0]), of_b = sides_of(b, n, a[0]);
    if (of_a.apart() || of_b.apart()) return Crossing::disjoint;
    const int common = common_vertices<3>(a, b);
    if (of_a.all_on()) {
        const int axis = axis_of<3>(n);
        return in_plane(a, b, (axis + 1) % 3, (axis + 2) % 3, common);
    }
    const int axis = axis_of_line(n, m);
    const Overlap met = overlap(section<3>(a, of_a, axis), section<3>(b, of_b, axis));
    if (met == Overlap::stretch && of_a.straddle() && of_b.straddle()) return Crossing::crossing;
    return contact(met, common);
}

std::optional<Contact> contact_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second) {
    const auto both = simplices<2>(first, second);
    if (!both) return {};
    const auto& [a, b] = *both;
    if (a[0] == a[1] || b[0] == b[1]) return {};
    const Sides<2> of_a = sides_of(a, b), of_b = sides_of(b, a);
    if (of_a.all_on()) {
        const int axis = a[0][0] != a[1][0] ? 0 : 1;
        if (overlap(section<2>(a, of_a, axis), section<2>(b, of_b, axis)) != Overlap::stretch) return Contact::rims;
        return (a[1][axis] > a[0][axis]) == (b[1][axis] > b[0][axis]) ? Contact::inside : Contact::opposite;
    }
    // Each edge has its body on its left. An edge whose end is inside the other edge's body enters that body.
    const auto enters = [](const Sides<2>& of_wall, const Sides<2>& of_other) {
        return of_wall.straddle() && of_other.any_above() && !of_other.any_below();
    };
    return enters(of_a, of_b) || enters(of_b, of_a) ? Contact::inside : Contact::rims;
}

std::optional<Contact> contact_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second) {
    const auto both = simplices<3>(first, second);
    if (!both) return {};
    const auto& [a, b] = *both;
    const Point<3> n = normal_of(a[0], a[1], a[2]), m = normal_of(b[0], b[1], b[2]);
    if (n == Point<3>{} || m == Point<3>{}) return {};
    const Sides<3> of_a = sides_of(a, m, b[0]), of_b = sides_of(b, n, a[0]);
    if (of_a.all_on()) {
        const int axis = axis_of<3>(n);
        if (!share_area(a, b, (axis + 1) % 3, (axis + 2) % 3)) return Contact::rims;
        return (n[axis] > 0) == (m[axis] > 0) ? Contact::inside : Contact::opposite;
    }
    // Each facet has its body below it. A facet that meets the interior of another facet and is partly below that facet
    // enters its body.
    const int axis = axis_of_line(n, m);
    const LineInterval in_a = section<3>(a, of_a, axis), in_b = section<3>(b, of_b, axis);
    const bool enters_a = of_a.straddle() && of_b.any_below() && meets_inside(in_a, in_b);
    const bool enters_b = of_b.straddle() && of_a.any_below() && meets_inside(in_b, in_a);
    return enters_a || enters_b ? Contact::inside : Contact::rims;
}

bool are_in_one_plane(const NodalFacet<3>& first, const NodalFacet<3>& second) {
    std::vector<Vec<3>> nodes(first.nodes.begin(), first.nodes.end());
    nodes.insert(nodes.end(), second.nodes.begin(), second.nodes.end());
    if (!std::all_of(nodes.begin(), nodes.end(), [](const Vec<3>& p) { return is_finite(p); })) return false;
    for (int c = 0; c < 3; ++c)
        if (std::all_of(nodes.begin(), nodes.end(), [&](const Vec<3>& p) { return p[c] == nodes[0][c]; })) return true;
    const auto points = integers<3>(nodes);
    const Point<3> n = normal_of(points[0], points[1], points[2]);
    return n != Point<3>{} && std::all_of(points.begin(), points.end(), [&](const Point<3>& p) {
               Integer height;
               for (int c = 0; c < 3; ++c) height += n[c] * (p[c] - points[0][c]);
               return height == 0;
           });
}

#define CAMBER_INSTANTIATE(D)                                                              \
    template CrossingResult test_pair<D>(const NodalFacet<D>&, const NodalFacet<D>&, int); \
    template Crossing crossing_of<D>(const NodalFacet<D>&, const NodalFacet<D>&, int);     \
    template Crossing crossing_of_itself<D>(const NodalFacet<D>&, int);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
