module;
#include <array>
#include <cmath>
export module camber.surface:plane;
import camber.core;

export namespace camber {

/// A plane (2D: a line). The normal need not be a unit vector.
template <int D>
struct Plane {
    Vec<D> point, normal;
    friend bool operator==(const Plane&, const Plane&) = default;
};

/// The closest point of a surface and the unit normal there (outwards where the surface is closed). On a plane whose
/// normal is along an axis that coordinate of the point is the plane's to the last bit. Where the closest point is not
/// unique (a centre, an axis) one is chosen.
template <int D>
struct SurfaceFoot {
    Vec<D> point, normal;
};

}  // namespace camber

namespace camber {

/// v / |v|, or `otherwise` for the zero vector.
template <int D>
[[nodiscard]] Vec<D> unit_or(const Vec<D>& v, const Vec<D>& otherwise) {
    const double length = norm(v);
    return length > 0 ? v / length : otherwise;
}

template <int D>
[[nodiscard]] Vec<D> some_direction() {
    Vec<D> d;
    d[0] = 1;
    return d;
}

[[nodiscard]] inline Vec<3> some_perpendicular(const Vec<3>& axis) {
    const Vec<3> x{{1, 0, 0}}, y{{0, 1, 0}};
    return normalised(cross(axis, std::fabs(axis[0]) < 0.7 * norm(axis) ? x : y));
}

/// The axis that a unit normal lies along exactly, or −1.
template <int D>
[[nodiscard]] int axis_of(const Vec<D>& normal) {
    for (int i = 0; i < D; ++i)
        if (std::fabs(normal[i]) == 1) return i;
    return -1;
}

/// The closest point of a plane.
template <int D>
[[nodiscard]] SurfaceFoot<D> foot(const Plane<D>& plane, const Vec<D>& p) {
    const Vec<D> n = unit_or(plane.normal, some_direction<D>());
    Vec<D> point = p - dot(p - plane.point, n) * n;
    if (const int k = axis_of(n); k >= 0) {
        point = p;
        point[k] = plane.point[k];
    }
    return {point, n};
}

/// x with the coordinate that a plane along an axis holds exactly; x itself for other planes.
template <int D>
[[nodiscard]] Vec<D> snapped(const Plane<D>& plane, Vec<D> x) {
    if (const int k = axis_of(normalised(plane.normal)); k >= 0) x[k] = plane.point[k];
    return x;
}

/// The plane through a facet's vertices.
[[nodiscard]] inline Plane<2> plane_through(const std::array<Vec<2>, 2>& p) {
    return {p[0], {{p[1][1] - p[0][1], p[0][0] - p[1][0]}}};
}
[[nodiscard]] inline Plane<3> plane_through(const std::array<Vec<3>, 3>& p) {
    return {p[0], cross(p[1] - p[0], p[2] - p[0])};
}

}  // namespace camber
