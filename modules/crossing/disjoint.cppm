module;
#include <array>
#include <cmath>
#include <cstddef>
export module camber.crossing:disjoint;
import camber.core;
import :facet;

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

}  // namespace camber
