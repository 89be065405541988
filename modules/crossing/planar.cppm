module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
module camber.crossing:planar;
import camber.core;
import camber.bezier;
import :crossings;
import :net;

/// The search through the pieces of two facets for a proof: what no proof fits is divided.
namespace camber {

/// The local edge between two corners of a triangle.
[[nodiscard]] constexpr int edge_between(int i, int j) { return i + j == 1 ? 0 : i + j == 3 ? 1 : 2; }

[[nodiscard]] inline bool share_edge(const Net<3>& first, const Net<3>& second, const Common<3>& common) {
    return common.count == 2 && first.part[edge_between(common.first[0], common.first[1])].same_as(
                                    second.part[edge_between(common.second[0], common.second[1])]);
}
[[nodiscard]] inline bool share_edge(const Net<2>&, const Net<2>&, const Common<2>&) { return false; }

[[nodiscard]] inline bool unfold(const Net<3>& first, const Net<3>& second, const Common<3>& common) {
    const auto sheet = [](const Net<3>& net, int from, int to, double side) {
        return Sheet{&net, from, to, 3 - from - to, side};
    };
    const std::array<Sheet, 2> sheets{sheet(first, common.first[0], common.first[1], 1),
                                      sheet(second, common.second[0], common.second[1], -1)};
    return is_graph(sheets);
}
[[nodiscard]] inline bool unfold(const Net<2>&, const Net<2>&, const Common<2>&) { return false; }

template <int D>
[[nodiscard]] inline double extent(const Net<D>& net) {
    return box_of(net).diagonal();
}

/// The search through pairs of pieces, deepest first.
template <int D>
class Search {
  public:
    explicit Search(int effort) : effort_(effort), left_(effort) {}

    [[nodiscard]] bool cut_short() const { return left_ < 0; }
    [[nodiscard]] int steps() const { return effort_ - std::max(left_, 0); }

    [[nodiscard]] Crossing pair(const Net<D>& first, const Net<D>& second) {
        if (--left_ < 0) return Crossing::undecided;
        const Common<D> common = common_corners(first, second);
        const bool edge = share_edge(first, second, common);
        if (are_apart(first, second, common, edge)) return Crossing::disjoint;
        if (pass_through(first, second)) return Crossing::crossing;
        const bool both = common.count >= 2;
        const bool first_only = !both && extent(first) >= extent(second);
        return divided(first, second, both || first_only, both || !first_only);
    }

    [[nodiscard]] Crossing itself(const Net<3>& net) {
        if (--left_ < 0) return Crossing::undecided;
        const std::array<Sheet, 1> sheet{sheet_of(net)};
        if (is_graph(sheet)) return Crossing::disjoint;
        if (net.divisions == max_divisions) return Crossing::undecided;
        const auto parts = pieces(named(net));
        Crossing worst = Crossing::disjoint;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j)
                if (join(worst, pair(parts[i], parts[j])) == Crossing::crossing) return worst;
        for (const Net<3>& part : parts)
            if (join(worst, itself(part)) == Crossing::crossing) return worst;
        return worst;
    }

  private:
    static bool are_apart(const Net<D>& first, const Net<D>& second, const Common<D>& common, bool edge) {
        if constexpr (D == 2)
            if (separated_by_parabola(first, second, common)) return true;
        if (common.count == 0) return separated(first, second);
        if (common.count == 1) return separated_at(first, common.first[0], second, common.second[0]);
        return edge && unfold(first, second, common);
    }

    static Crossing join(Crossing& worst, Crossing found) {
        if (found != Crossing::disjoint) worst = found == Crossing::crossing ? found : std::max(worst, found);
        return worst;
    }

    Crossing divided(const Net<D>& first, const Net<D>& second, bool divide_first, bool divide_second) {
        if ((divide_first && first.divisions == max_divisions) || (divide_second && second.divisions == max_divisions))
            return Crossing::undecided;
        Crossing worst = Crossing::disjoint;
        const auto against = [&](const Net<D>& piece) {
            if (!divide_second) return join(worst, pair(piece, second));
            for (const Net<D>& other : pieces(second))
                if (join(worst, pair(piece, other)) == Crossing::crossing || left_ < 0) break;
            return worst;
        };
        if (!divide_first) return against(first);
        for (const Net<D>& piece : pieces(first))
            if (against(piece) == Crossing::crossing || left_ < 0) break;
        return worst;
    }

    /// Its pieces know each other by corners and inner edges: names for all of them.
    static Net<3> named(Net<3> net) {
        for (int i = 0; i < 3; ++i) {
            net.corner[i] = static_cast<SharedPoint>(i) + 1;
            net.part[i] = {static_cast<std::uint32_t>(i) + 1, 1, false};
        }
        return net;
    }

    int effort_, left_;
};

}  // namespace camber

/// Facets seen along an axis: what does not meet there does not meet. For facets in one plane, or nearly, between arcs
/// that bow by more than they are apart, which in space are to be divided until the parts are flatter than that.
namespace camber {

/// A facet as it is seen: its three edges, and its Bézier points.
struct Shadow {
    std::array<Net<2>, 3> edges{};  ///< in the order of `local_edges`, with the names of their ends
    std::array<Vec<2>, 6> control{};
};

[[nodiscard]] inline Shadow shadow_of(const Net<3>& net, int axis) {
    Shadow shadow;
    const auto seen = [&](const Vec<3>& p) { return Vec<2>{{p[(axis + 1) % 3], p[(axis + 2) % 3]}}; };
    std::transform(net.control.begin(), net.control.end(), shadow.control.begin(), seen);
    for (int e = 0; e < 3; ++e) {
        const auto [i, j] = local_edges<2>[e];
        shadow.edges[e].control = {shadow.control[i], shadow.control[j], shadow.control[3 + e]};
        shadow.edges[e].corner = {net.corner[i], net.corner[j]};
    }
    return shadow;
}

/// The sign of det of the shadow's Jacobian, if its Bézier coefficients have it everywhere; else 0. If it has, the rim
/// of what is covered belongs to the edges.
[[nodiscard]] inline int orientation_of(const Net<3>& net, int axis) {
    const auto slope = [&](int i, int to) {
        const Vec<3> d = net.at(i, to) - net.at(i, 0);
        return Vec<2>{{d[(axis + 1) % 3], d[(axis + 2) % 3]}};
    };
    int positive = 0, negative = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
            const double c = (cross(slope(i, 1), slope(j, 2)) + cross(slope(j, 1), slope(i, 2))) / 2;
            positive += c > 2 * area_blur ? 1 : 0;
            negative += c < -2 * area_blur ? 1 : 0;
        }
    return positive == 6 ? 1 : negative == 6 ? -1 : 0;
}
[[nodiscard]] inline bool keeps_orientation(const Net<3>& net, int axis) { return orientation_of(net, axis) != 0; }

/// Outside the box, rounding included.
[[nodiscard]] inline bool is_beside(const Box<2>& box, const Vec<2>& p) {
    for (int c = 0; c < 2; ++c)
        if (p[c] < box.low[c] - 8 * coordinate_blur || p[c] > box.high[c] + 8 * coordinate_blur) return true;
    return false;
}

/// How often a closed curve of three goes round p: the triangle of its corners does, and what lies between each edge
/// and its chord. None where p is too near to one of these to tell.
[[nodiscard]] inline std::optional<int> turns_about(const Shadow& shadow, const Vec<2>& p) {
    const auto sign = [](double area) { return area > 2 * area_blur ? 1 : area < -2 * area_blur ? -1 : 0; };
    // Of a triangle by the areas of p with its sides: 2 if that cannot be told.
    const auto within = [&](double a, double b, double c) {
        const std::array<int, 3> s{sign(a), sign(b), sign(c)};
        const bool left = std::count(s.begin(), s.end(), 1) > 0, right = std::count(s.begin(), s.end(), -1) > 0;
        if (left && right) return 0;
        return s[0] != 0 && s[0] == s[1] && s[1] == s[2] ? s[0] : 2;
    };
    const auto side = [&](int i, int j) { return cross(shadow.control[i] - p, shadow.control[j] - p); };
    int turns = within(side(0, 1), side(1, 2), side(2, 0));
    if (turns == 2) return {};
    for (const Net<2>& edge : shadow.edges) {
        if (is_beside(box_of(edge), p)) continue;
        const Areas at = areas_at(edge, p);
        const int hull = within(at.first, at.middle, at.second);
        if (hull == 0) continue;
        const int beyond = polar(at, at).sign();
        if (hull == 2 || beyond == 0) return {};
        if (beyond < 0) turns += hull;
    }
    return turns;
}

[[nodiscard]] inline Vec<2> middle_of(const Net<2>& edge) {
    return 0.5 * midpoint(edge.control[0], edge.control[1]) + 0.5 * edge.control[2];
}

/// The axis along which the facets are seen best.
[[nodiscard]] inline int best_axis(const Net<3>& first, const Net<3>& second) {
    const auto normal = [](const Net<3>& net) {
        return normalised(cross(net.control[1] - net.control[0], net.control[2] - net.control[0]));
    };
    const Vec<3> n = normal(first), m = normal(second);
    const auto seen = [&](int c) { return std::min(std::abs(n[c]), std::abs(m[c])); };
    int best = 0;
    for (int c = 1; c < 3; ++c)
        if (seen(c) > seen(best)) best = c;
    return best;
}

/// A facet that is one to one as seen along an axis: its orientation is kept, and its edges do not cross.
[[nodiscard]] inline bool is_simple_in_plane(Net<3> net) {
    const int axis = best_axis(net, net);
    if (!keeps_orientation(net, axis)) return false;
    for (int i = 0; i < 3; ++i) net.corner[i] = static_cast<SharedPoint>(i) + 1;
    const Shadow shadow = shadow_of(net, axis);
    for (int e = 0; e < 3; ++e)
        if (Search<2>(1).pair(shadow.edges[e], shadow.edges[(e + 1) % 3]) != Crossing::disjoint) return false;
    return true;
}

/// Two facets, seen along an axis.
class PlanarTest {
  public:
    PlanarTest(const Net<3>& first, const Net<3>& second, int effort)
        : first_(first), second_(second), axis_(best_axis(first, second)), left_(effort + edge_pairs) {
        shadows_ = {shadow_of(first, axis_), shadow_of(second, axis_)};
    }

    /// Clear if their shadows are; if both are in one plane, touching where these certainly have more in common than
    /// they share. None if neither is certain.
    template <class InOnePlane>
    [[nodiscard]] std::optional<Crossing> verdict(InOnePlane&& in_one_plane) {
        const Crossing of_edges = compare_edges();
        if (of_edges == Crossing::disjoint && keeps_orientation(first_, axis_) && keeps_orientation(second_, axis_) &&
            is_outside(0) && is_outside(1))
            return Crossing::disjoint;
        if ((of_edges == Crossing::crossing || has_inside(0) || has_inside(1)) && in_one_plane())
            return Crossing::touching;
        return {};
    }

    [[nodiscard]] int steps() const { return steps_; }
    [[nodiscard]] bool cut_short() const { return left_ < 0; }

  private:
    static constexpr int edge_pairs = 9;

    [[nodiscard]] bool is_shared(int side, int e) const {
        const auto& own = side == 0 ? first_.part : second_.part;
        const auto& other = side == 0 ? second_.part : first_.part;
        return std::any_of(other.begin(), other.end(), [&](const SharedPart& part) { return own[e].same_as(part); });
    }

    /// Each edge of the one with each of the other that is not the same.
    [[nodiscard]] Crossing compare_edges() {
        Crossing worst = Crossing::disjoint;
        for (int e = 0; e < 3; ++e)
            for (int f = 0; f < 3; ++f) {
                if (first_.part[e].same_as(second_.part[f])) continue;
                Search<2> search(std::max(left_, 1));
                const Crossing found = search.pair(shadows_[0].edges[e], shadows_[1].edges[f]);
                steps_ += search.steps();
                left_ -= search.cut_short() ? left_ + 1 : search.steps();
                if (found == Crossing::crossing || left_ < 0) return found;
                if (found != Crossing::disjoint) worst = found;
            }
        return worst;
    }

    /// Edges that meet the other's nowhere but in shared points are outside it if a place of each is.
    [[nodiscard]] bool is_outside(int side) const {
        for (int e = 0; e < 3; ++e)
            if (!is_shared(side, e) && turns_about(shadows_[1 - side], middle_of(shadows_[side].edges[e])) != 0)
                return false;
        return true;
    }

    [[nodiscard]] bool has_inside(int side) const {
        const auto& c = shadows_[side].control;
        const auto inside = [&](const Vec<2>& p) { return turns_about(shadows_[1 - side], p).value_or(0) != 0; };
        const Vec<2> centre = ((c[0] + c[1] + c[2]) + 2.0 * (c[3] + c[4] + c[5])) / 9.0;
        return inside(centre) || std::any_of(shadows_[side].edges.begin(), shadows_[side].edges.end(),
                                             [&](const Net<2>& edge) { return inside(middle_of(edge)); });
    }

    const Net<3>& first_;
    const Net<3>& second_;
    int axis_, left_, steps_ = 0;
    std::array<Shadow, 2> shadows_;
};

}  // namespace camber

/// Straight facets, exactly: what they have in common is a stretch of a line, or of a plane, and its ends are ratios of
/// integers.
namespace camber {

/// Its mid nodes are the middles of the chords, as doubles have them.
template <int D>
[[nodiscard]] inline bool is_straight(const NodalFacet<D>& facet) {
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        if (!(facet.nodes[D + e] == midpoint(facet.nodes[i], facet.nodes[j]))) return false;
    }
    return true;
}

/// The verdict of the straight facets of the vertices, in integers. None if one has no area (no length), or a vertex
/// that is not finite.
[[nodiscard]] std::optional<Crossing> crossing_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second);
[[nodiscard]] std::optional<Crossing> crossing_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second);

/// How two touching facets meet, each with the inside of its body on the side against its normal. In 2D the normal of
/// an edge points to the right of it.
enum class Contact : std::uint8_t {
    rims,      ///< in points or lines that lie on the rim of one of them, or outside the other's body
    opposite,  ///< in an area (a length) of one plane (line), with the bodies on its two sides: contact of two bodies
    inside     ///< one of them lies on, or enters, the inner side of the other's interior: the bodies overlap there
};

/// The contact of the straight facets of the vertices, of which `crossing_of_straight` says that they touch. Decided
/// in integers. None if one has no area (no length), or a vertex that is not finite.
[[nodiscard]] std::optional<Contact> contact_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second);
[[nodiscard]] std::optional<Contact> contact_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second);

/// All nodes of both lie in one plane, exactly.
[[nodiscard]] bool are_in_one_plane(const NodalFacet<3>& first, const NodalFacet<3>& second);

}  // namespace camber

/// Signed intersections of a ray along an axis with facets, certified: how often a closed boundary winds around the
/// ray's start.
namespace camber {

/// A ray along an axis.
template <int D>
struct Ray {
    Vec<D> start;
    int axis = 0;
    int sign = 1;  ///< towards rising coordinates, or −1
};

/// Intersections of a ray with one facet or several, beyond a range of distances. Distances are of model units.
struct RayHits {
    int count = 0;   ///< hits from the inner side minus hits from the outer side
    int pieces = 0;  ///< parts of facets that were hit
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;  ///< bounds of their distances
    double before = 0;  ///< everything nearer than the range is nearer than this, too
    bool certain = true;

    friend RayHits operator+(const RayHits& a, const RayHits& b) {
        return {a.count + b.count,
                a.pieces + b.pieces,
                std::min(a.nearest, b.nearest),
                std::max(a.farthest, b.farthest),
                std::max(a.before, b.before),
                a.certain && b.certain};
    }
};

/// Signed number of times that the piece, seen along the axis, covers the origin; none where the origin is too near to
/// its rim to tell. Positive: the piece's normal has a positive component along the axis.
[[nodiscard]] inline std::optional<int> covers_origin(const Net<2>& net, int axis) {
    const int other = 1 - axis;
    std::array<int, 2> side{};
    for (int i = 0; i < 2; ++i) {
        const double x = net.control[i][other];
        if (std::abs(x) <= 8 * coordinate_blur) return {};
        side[i] = x > 0 ? 1 : -1;
    }
    return (axis == 0 ? 1 : -1) * (side[1] - side[0]) / 2;
}
[[nodiscard]] inline std::optional<int> covers_origin(const Net<3>& net, int axis) {
    return turns_about(shadow_of(net, axis), Vec<2>{});
}

/// The normal of the straight facet: outwards, times its length or twice its area.
[[nodiscard]] inline Vec<2> straight_normal(const Net<2>& net) {
    const Vec<2> along = net.control[1] - net.control[0];
    return {{along[1], -along[0]}};
}
[[nodiscard]] inline Vec<3> straight_normal(const Net<3>& net) {
    return cross(net.control[1] - net.control[0], net.control[2] - net.control[0]);
}

/// A range of distances from the start of a ray (model units).
struct RayRange {
    double low = 0, high = 0;
};

/// Certified intersections of a ray with facets.
template <int D>
class RayCaster {
  public:
    explicit RayCaster(const Ray<D>& ray) : ray_(ray) {}

    /// Hits beyond the range. Curved facets are divided until each piece is beside the ray, nearer than the range, or
    /// beyond it and smaller than `resolution`.
    [[nodiscard]] RayHits hits(const NodalFacet<D>& facet, const RayRange& range = {},
                               double resolution = std::numeric_limits<double>::infinity()) const {
        const auto unit = unit_for(facet, facet, ray_.start);
        if (!unit) return uncertain();
        const Net<D> net = net_of(facet, ray_.start, *unit);
        if (is_straight(facet)) return hits_straight(net, *unit, range);
        RayHits sum;
        std::vector<Net<D>> open{net};
        for (std::size_t looked = 0; !open.empty(); ++looked) {
            const Net<D> piece = open.back();
            open.pop_back();
            const bool can_divide = piece.divisions < max_divisions && looked < max_pieces;
            const Piece seen = look_at(piece, *unit, range);
            if (seen.is_divided || (seen.hits.pieces > 0 && can_divide && seen.extent > resolution)) {
                if (!can_divide) return uncertain();
                const auto parts = pieces(piece);
                open.insert(open.end(), parts.begin(), parts.end());
            } else {
                sum = sum + seen.hits;
            }
        }
        return sum;
    }

  private:
    static constexpr double blur = 8 * coordinate_blur;
    static constexpr std::size_t max_pieces = 600;

    /// The hits of a piece as a whole, if they can be told without dividing it.
    struct Piece {
        RayHits hits = {};
        double extent = 0;  ///< along the ray (model units)
        bool is_divided = false;
    };

    [[nodiscard]] static RayHits uncertain() {
        RayHits hits;
        hits.certain = false;
        return hits;
    }

    /// Hits of a piece between these distances that covers the ray so often.
    [[nodiscard]] RayHits hits_at(int covered, double low, double high) const {
        RayHits hits;
        hits.count = ray_.sign * covered;
        hits.pieces = 1;
        hits.nearest = low;
        hits.farthest = high;
        return hits;
    }
    [[nodiscard]] static RayHits hits_before(double high) {
        RayHits hits;
        hits.before = high;
        return hits;
    }

    [[nodiscard]] Piece look_at(const Net<D>& net, double unit, const RayRange& range) const {
        const Box<D> box = box_of(net);
        for (int c = 0; c < D; ++c)
            if (c != ray_.axis && (box.low[c] > blur || box.high[c] < -blur)) return {};
        const double first = box.low[ray_.axis], last = box.high[ray_.axis];
        const double low = ((ray_.sign > 0 ? first : -last) - blur) / unit;
        const double high = ((ray_.sign > 0 ? last : -first) + blur) / unit;
        if (high < range.low) return {hits_before(high)};
        if (!(low > range.high)) return {.is_divided = true};
        const auto covered = covers_origin(net, ray_.axis);
        if (!covered) return {.is_divided = true};
        if (*covered == 0) return {};
        return {hits_at(*covered, low, high), high - low};
    }

    /// The facet's plane meets the ray at one distance, (n · a)/(n · d).
    [[nodiscard]] RayHits hits_straight(const Net<D>& net, double unit, const RayRange& range) const {
        const Piece whole = look_at(net, unit, range);
        if (!whole.is_divided && whole.hits.pieces == 0) return whole.hits;
        const auto covered = covers_origin(net, ray_.axis);
        if (!covered) return uncertain();
        if (*covered == 0) return {};
        const Vec<D> n = straight_normal(net);
        // Coordinates are below 1 and err by a few of their last bits: products and sums of them by less than this.
        constexpr double error = 4 * coordinate_blur;
        const double slope = std::abs(n[ray_.axis]) - error;
        if (!(slope > 0)) return whole.is_divided ? uncertain() : whole.hits;
        const double at = dot(n, net.control[0]) / n[ray_.axis] * ray_.sign;
        const double off = (2 * error + std::abs(at) * error) / slope;
        const double low = (at - off) / unit, high = (at + off) / unit;
        if (high < range.low) return hits_before(high);
        return low > range.high ? hits_at(*covered, low, high) : uncertain();
    }

    Ray<D> ray_;
};

}  // namespace camber
