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

/// Search over pairs of pieces of two facets. Pieces for which no proof is found are divided.
namespace camber {

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

    /// Assigns ids to the corners and edges of a facet, which its pieces inherit.
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

/// Projection along an axis: disjoint projections prove that facets are disjoint. This is for almost coplanar facets
/// whose edges are arcs with a gap smaller than their sag. Tests in 3D would divide such facets into very small pieces.
namespace camber {

struct PlanarProjection {
    std::array<Net<2>, 3> edges{};  ///< in the order of `local_edges`, with the ids of their ends
    std::array<Vec<2>, 6> control{};
};

[[nodiscard]] inline PlanarProjection projection_of(const Net<3>& net, int axis) {
    PlanarProjection shadow;
    const auto projected = [&](const Vec<3>& p) { return Vec<2>{{p[(axis + 1) % 3], p[(axis + 2) % 3]}}; };
    std::transform(net.control.begin(), net.control.end(), shadow.control.begin(), projected);
    for (int e = 0; e < 3; ++e) {
        const auto [i, j] = local_edges<2>[e];
        shadow.edges[e].control = {shadow.control[i], shadow.control[j], shadow.control[3 + e]};
        shadow.edges[e].corner = {net.corner[i], net.corner[j]};
    }
    return shadow;
}

/// Sign of the projection's Jacobian if all its Bézier coefficients have the same sign, else 0. If it is not 0, the
/// projected edges bound the covered region.
[[nodiscard]] inline int orientation_of(const Net<3>& net, int axis) {
    const auto slope = [&](int i, int to) {
        const Vec<3> d = net.at(i, to) - net.at(i, 0);
        return Vec<2>{{d[(axis + 1) % 3], d[(axis + 2) % 3]}};
    };
    int positive = 0, negative = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
            const double c = (cross(slope(i, 1), slope(j, 2)) + cross(slope(j, 1), slope(i, 2))) / 2;
            positive += c > 2 * area_error ? 1 : 0;
            negative += c < -2 * area_error ? 1 : 0;
        }
    return positive == 6 ? 1 : negative == 6 ? -1 : 0;
}
[[nodiscard]] inline bool preserves_orientation(const Net<3>& net, int axis) { return orientation_of(net, axis) != 0; }

[[nodiscard]] inline bool is_beside(const Box<2>& box, const Vec<2>& p) {
    for (int c = 0; c < 2; ++c)
        if (p[c] < box.low[c] - 8 * coordinate_error || p[c] > box.high[c] + 8 * coordinate_error) return true;
    return false;
}

/// Winding number of the projected boundary around p: the sum over the triangle of corners and the regions between
/// edges and their chords. None if p is too close to the boundary.
[[nodiscard]] inline std::optional<int> winding_number(const PlanarProjection& shadow, const Vec<2>& p) {
    const auto sign = [](double area) { return area > 2 * area_error ? 1 : area < -2 * area_error ? -1 : 0; };
    // Winding number of a triangle around p, from the signed areas of p with its sides. 2: uncertain.
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

[[nodiscard]] inline int best_axis(const Net<3>& first, const Net<3>& second) {
    const auto normal = [](const Net<3>& net) {
        return normalised(cross(net.control[1] - net.control[0], net.control[2] - net.control[0]));
    };
    const Vec<3> n = normal(first), m = normal(second);
    const auto projected = [&](int c) { return std::min(std::abs(n[c]), std::abs(m[c])); };
    int best = 0;
    for (int c = 1; c < 3; ++c)
        if (projected(c) > projected(best)) best = c;
    return best;
}

/// True if the projection is injective: its orientation is constant, and its edges do not cross.
[[nodiscard]] inline bool is_simple_in_plane(Net<3> net) {
    const int axis = best_axis(net, net);
    if (!preserves_orientation(net, axis)) return false;
    for (int i = 0; i < 3; ++i) net.corner[i] = static_cast<SharedPoint>(i) + 1;
    const PlanarProjection shadow = projection_of(net, axis);
    for (int e = 0; e < 3; ++e)
        if (Search<2>(1).pair(shadow.edges[e], shadow.edges[(e + 1) % 3]) != Crossing::disjoint) return false;
    return true;
}

class PlanarTest {
  public:
    PlanarTest(const Net<3>& first, const Net<3>& second, int effort)
        : first_(first), second_(second), axis_(best_axis(first, second)), left_(effort + edge_pairs) {
        projections_ = {projection_of(first, axis_), projection_of(second, axis_)};
    }

    /// Disjoint if the projections are disjoint. Touching if the facets are coplanar and certainly have unshared points
    /// in common. Otherwise none.
    template <class InOnePlane>
    [[nodiscard]] std::optional<Crossing> verdict(InOnePlane&& in_one_plane) {
        const Crossing of_edges = compare_edges();
        if (of_edges == Crossing::disjoint && preserves_orientation(first_, axis_) &&
            preserves_orientation(second_, axis_) && is_outside(0) && is_outside(1))
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

    [[nodiscard]] Crossing compare_edges() {
        Crossing worst = Crossing::disjoint;
        for (int e = 0; e < 3; ++e)
            for (int f = 0; f < 3; ++f) {
                if (first_.part[e].same_as(second_.part[f])) continue;
                Search<2> search(std::max(left_, 1));
                const Crossing found = search.pair(projections_[0].edges[e], projections_[1].edges[f]);
                steps_ += search.steps();
                left_ -= search.cut_short() ? left_ + 1 : search.steps();
                if (found == Crossing::crossing || left_ < 0) return found;
                if (found != Crossing::disjoint) worst = found;
            }
        return worst;
    }

    /// True if the midpoints of this facet's unshared edges are outside the other facet. The whole edges are then
    /// outside, because edges meet only at shared points.
    [[nodiscard]] bool is_outside(int side) const {
        for (int e = 0; e < 3; ++e)
            if (!is_shared(side, e) &&
                winding_number(projections_[1 - side], middle_of(projections_[side].edges[e])) != 0)
                return false;
        return true;
    }

    [[nodiscard]] bool has_inside(int side) const {
        const auto& c = projections_[side].control;
        const auto inside = [&](const Vec<2>& p) { return winding_number(projections_[1 - side], p).value_or(0) != 0; };
        const Vec<2> centre = ((c[0] + c[1] + c[2]) + 2.0 * (c[3] + c[4] + c[5])) / 9.0;
        return inside(centre) || std::any_of(projections_[side].edges.begin(), projections_[side].edges.end(),
                                             [&](const Net<2>& edge) { return inside(middle_of(edge)); });
    }

    const Net<3>& first_;
    const Net<3>& second_;
    int axis_, left_, steps_ = 0;
    std::array<PlanarProjection, 2> projections_;
};

}  // namespace camber

/// Exact tests of straight facets. Their intersection is an interval or region with rational corners.
namespace camber {

template <int D>
[[nodiscard]] inline bool is_straight(const NodalFacet<D>& facet) {
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        if (!(facet.nodes[D + e] == midpoint(facet.nodes[i], facet.nodes[j]))) return false;
    }
    return true;
}

/// Exact verdict on the straight facets with the same vertices. None for zero area (2D: length), or vertices that are
/// not finite.
[[nodiscard]] std::optional<Crossing> crossing_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second);
[[nodiscard]] std::optional<Crossing> crossing_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second);

/// Contact of two touching facets. The body of each facet lies opposite to its normal. In 2D, the normal points to the
/// right.
enum class Contact : std::uint8_t {
    rims,      ///< a facet touches the other only at a boundary, or outside the other's body
    opposite,  ///< common area (2D: length), with bodies on opposite sides
    inside     ///< overlapping bodies: a facet lies on the other's interior with its body on the same side, or enters
               ///< the other's body
};

/// Exact contact of straight facets that are touching (`crossing_of_straight`). None as for `crossing_of_straight`.
[[nodiscard]] std::optional<Contact> contact_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second);
[[nodiscard]] std::optional<Contact> contact_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second);

[[nodiscard]] bool are_in_one_plane(const NodalFacet<3>& first, const NodalFacet<3>& second);

}  // namespace camber

/// Certified, signed intersections of facets with a ray along an axis. Their sum is the winding number of a closed
/// boundary around the ray's start.
namespace camber {

template <int D>
struct Ray {
    Vec<D> start;
    int axis = 0;
    int sign = 1;  ///< direction along the axis: 1 or −1
};

/// Intersections of a ray with facets whose distances are beyond a range (model units).
struct RayHits {
    int count = 0;  ///< number of hits from the inner side minus hits from the outer side
    int pieces = 0;
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
    double before = 0;  ///< upper bound of the distances of hits that are below the range
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

/// Signed number of times that the projected piece covers the origin; positive if its normal has a positive component
/// along the axis. None if the origin is too close to the projected boundary.
[[nodiscard]] inline std::optional<int> covers_origin(const Net<2>& net, int axis) {
    const int other = 1 - axis;
    std::array<int, 2> side{};
    for (int i = 0; i < 2; ++i) {
        const double x = net.control[i][other];
        if (std::abs(x) <= 8 * coordinate_error) return {};
        side[i] = x > 0 ? 1 : -1;
    }
    return (axis == 0 ? 1 : -1) * (side[1] - side[0]) / 2;
}
[[nodiscard]] inline std::optional<int> covers_origin(const Net<3>& net, int axis) {
    return winding_number(projection_of(net, axis), Vec<2>{});
}

/// Outward normal. Its length is the facet's length (2D) or twice its area (3D).
[[nodiscard]] inline Vec<2> straight_normal(const Net<2>& net) {
    const Vec<2> along = net.control[1] - net.control[0];
    return {{along[1], -along[0]}};
}
[[nodiscard]] inline Vec<3> straight_normal(const Net<3>& net) {
    return cross(net.control[1] - net.control[0], net.control[2] - net.control[0]);
}

/// Range of distances from a ray's start (model units).
struct RayRange {
    double low = 0, high = 0;
};

template <int D>
class RayCaster {
  public:
    explicit RayCaster(const Ray<D>& ray) : ray_(ray) {}

    /// Returns the hits of the ray on a facet beyond `range`. Curved facets are divided until each piece misses the
    /// ray, is below the range, or is beyond it and smaller than `resolution`.
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
            const Piece projected = look_at(piece, *unit, range);
            if (projected.is_divided || (projected.hits.pieces > 0 && can_divide && projected.extent > resolution)) {
                if (!can_divide) return uncertain();
                const auto parts = pieces(piece);
                open.insert(open.end(), parts.begin(), parts.end());
            } else {
                sum = sum + projected.hits;
            }
        }
        return sum;
    }

  private:
    static constexpr double blur = 8 * coordinate_error;
    static constexpr std::size_t max_pieces = 600;

    struct Piece {
        RayHits hits = {};
        double extent = 0;
        bool is_divided = false;
    };

    [[nodiscard]] static RayHits uncertain() {
        RayHits hits;
        hits.certain = false;
        return hits;
    }

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

    /// The ray (direction d) meets the plane (normal n) at distance (n · a)/(n · d), where a goes from its start to the
    /// plane.
    [[nodiscard]] RayHits hits_straight(const Net<D>& net, double unit, const RayRange& range) const {
        const Piece whole = look_at(net, unit, range);
        if (!whole.is_divided && whole.hits.pieces == 0) return whole.hits;
        const auto covered = covers_origin(net, ray_.axis);
        if (!covered) return uncertain();
        if (*covered == 0) return {};
        const Vec<D> n = straight_normal(net);
        // Bound of the error of products and sums of coordinates, which are all below 1.
        constexpr double error = 4 * coordinate_error;
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
