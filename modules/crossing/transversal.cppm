module;
#include <algorithm>
#include <array>
#include <cmath>
module camber.crossing:transversal;
import camber.core;
import :net;

/// Pieces that certainly pass through each other. Their straight simplices do, and so far from the rim of each that
/// bending them, by no more than the sags of both, never brings rim and piece together: what a motion without that
/// cannot undo is the number of crossings with sign, here ±1.
namespace camber {

/// Roundings of sums of products of differences of doubles, by the product of their lengths.
inline constexpr double product_blur = 0x1p-48;

/// Points p and q lie on two sides of the line through a and b, further from it than `reach`.
[[nodiscard]] inline bool apart_across(const Vec<2>& p, const Vec<2>& q, const Vec<2>& a, const Vec<2>& b,
                                       double reach) {
    const Vec<2> along = b - a;
    const double length = norm(along);
    const auto height = [&](const Vec<2>& x) { return cross(along, x - a); };
    const auto far = [&](const Vec<2>& x) {
        return std::abs(height(x)) > length * ((1 + 0x1p-40) * reach + product_blur * norm(x - a));
    };
    return (height(p) > 0) != (height(q) > 0) && far(p) && far(q);
}

[[nodiscard]] inline bool pass_through(const Net<2>& first, const Net<2>& second) {
    const auto& p = first.control;
    const auto& q = second.control;
    const double reach = sag(first) + sag(second);
    return apart_across(p[0], p[1], q[0], q[1], reach) && apart_across(q[0], q[1], p[0], p[1], reach);
}

/// The segment p–q goes through the triangle, its ends further from the plane than `reach`, its line further from the
/// lines of the triangle's edges.
[[nodiscard]] inline bool pierces(const Vec<3>& p, const Vec<3>& q, const std::array<Vec<3>, 3>& triangle,
                                  double reach) {
    reach *= 1 + 0x1p-40;
    const Vec<3> u = triangle[1] - triangle[0], v = triangle[2] - triangle[0];
    const Vec<3> normal = cross(u, v);
    const double size = norm(u) * norm(v);
    const auto height = [&](const Vec<3>& x) { return dot(normal, x - triangle[0]); };
    const auto far = [&](const Vec<3>& x) {
        return std::abs(height(x)) > norm(normal) * reach + product_blur * size * (reach + norm(x - triangle[0]));
    };
    if ((height(p) > 0) == (height(q) > 0) || !far(p) || !far(q)) return false;
    const Vec<3> along = q - p;
    int positive = 0;
    for (int i = 0; i < 3; ++i) {
        const Vec<3>& a = triangle[i];
        const Vec<3> edge = triangle[(i + 1) % 3] - a;
        const Vec<3> perpendicular = cross(along, edge);
        const double product = dot(perpendicular, a - p);
        const double scale = norm(along) * norm(edge);
        if (!(std::abs(product) > norm(perpendicular) * reach + product_blur * scale * (reach + norm(a - p))))
            return false;
        positive += product > 0 ? 1 : 0;
    }
    return positive == 0 || positive == 3;
}

[[nodiscard]] inline bool pass_through(const Net<3>& first, const Net<3>& second) {
    const double reach = sag(first) + sag(second);
    const auto corners = [](const Net<3>& net) {
        return std::array<Vec<3>, 3>{net.control[0], net.control[1], net.control[2]};
    };
    const auto one_way = [&](const std::array<Vec<3>, 3>& p, const std::array<Vec<3>, 3>& q) {
        return pierces(p[0], p[1], q, reach) || pierces(p[1], p[2], q, reach) || pierces(p[2], p[0], q, reach);
    };
    return one_way(corners(first), corners(second)) || one_way(corners(second), corners(first));
}

}  // namespace camber
