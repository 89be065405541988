module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
module camber.crossing:planar;
import camber.core;
import camber.bezier;
import :net;
import :pair;
import :parabola;
import :search;

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
