module;
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

/// v / |v|, or `otherwise` for the zero vector.
template <int D>
Vec<D> unit_or(const Vec<D>& v, const Vec<D>& otherwise) {
    const double length = norm(v);
    return length > 0 ? v / length : otherwise;
}

Vec<3> some_perpendicular(const Vec<3>& axis) {
    const Vec<3> x{{1, 0, 0}}, y{{0, 1, 0}};
    return normalised(cross(axis, std::fabs(axis[0]) < 0.7 * norm(axis) ? x : y));
}

template <int D>
Vec<D> some_direction() {
    Vec<D> d;
    d[0] = 1;
    return d;
}

/// The axis that a unit normal lies along exactly, or −1.
template <int D>
int axis_of(const Vec<D>& normal) {
    for (int i = 0; i < D; ++i)
        if (std::fabs(normal[i]) == 1) return i;
    return -1;
}

template <int D>
SurfaceFoot<D> foot(const Plane<D>& plane, const Vec<D>& p) {
    const Vec<D> n = unit_or(plane.normal, some_direction<D>());
    Vec<D> point = p - dot(p - plane.point, n) * n;
    if (const int k = axis_of(n); k >= 0) {
        point = p;
        point[k] = plane.point[k];
    }
    return {point, n};
}

template <int D>
SurfaceFoot<D> foot(const Sphere<D>& sphere, const Vec<D>& p) {
    const Vec<D> n = unit_or(p - sphere.centre, some_direction<D>());
    return {sphere.centre + sphere.radius * n, n};
}

SurfaceFoot<3> foot(const Cylinder& cylinder, const Vec<3>& p) {
    const Vec<3> axis = unit_or(cylinder.axis, Vec<3>{{0, 0, 1}});
    const Vec<3> d = p - cylinder.point;
    const Vec<3> along = dot(d, axis) * axis;
    const Vec<3> n = unit_or(d - along, some_perpendicular(axis));
    return {cylinder.point + along + cylinder.radius * n, n};
}

SurfaceFoot<3> foot(const Torus& torus, const Vec<3>& p) {
    const Vec<3> axis = unit_or(torus.axis, Vec<3>{{0, 0, 1}});
    const Vec<3> d = p - torus.centre;
    const Vec<3> radial = unit_or(d - dot(d, axis) * axis, some_perpendicular(axis));
    const Vec<3> ring = torus.centre + torus.major_radius * radial;
    const Vec<3> n = unit_or(p - ring, radial);
    return {ring + torus.minor_radius * n, n};
}

struct Tangents {
    SurfaceFoot<3> a, b;
};

Tangents tangents_at(const AnalyticSurface<3>& a, const AnalyticSurface<3>& b, const Vec<3>& x) {
    return {closest_point(a, x), closest_point(b, x)};
}

/// The point of both tangent planes that is nearest to p: p + α n_a + β n_b. Nothing where the planes are nearly
/// parallel.
std::optional<Vec<3>> nearest_on_both(const Tangents& t, const Vec<3>& p) {
    constexpr double least_sine_squared = 0.003;
    const double c = dot(t.a.normal, t.b.normal);
    const double determinant = 1 - c * c;
    if (determinant < least_sine_squared) return std::nullopt;
    const double to_a = dot(t.a.point - p, t.a.normal), to_b = dot(t.b.point - p, t.b.normal);
    const double alpha = (to_a - c * to_b) / determinant, beta = (to_b - c * to_a) / determinant;
    return p + alpha * t.a.normal + beta * t.b.normal;
}

/// Planes along an axis hold their coordinate exactly.
Vec<3> snapped(const AnalyticSurface<3>& surface, Vec<3> x) {
    if (const auto* plane = std::get_if<Plane<3>>(&surface))
        if (const int k = axis_of(normalised(plane->normal)); k >= 0) x[k] = plane->point[k];
    return x;
}

}  // namespace

template <int D>
const AnalyticSurface<D>* surface_of(const AnalyticGeometry<D>& geometry, Reference reference) {
    for (const auto& [of, surface] : geometry.surfaces)
        if (of == reference) return &surface;
    return nullptr;
}

template <int D>
SurfaceFoot<D> closest_point(const AnalyticSurface<D>& surface, const Vec<D>& p) {
    return std::visit([&](const auto& s) { return foot(s, p); }, surface);
}

std::optional<Vec<3>> closest_on_intersection(const AnalyticSurface<3>& a, const AnalyticSurface<3>& b,
                                              const Vec<3>& p) {
    constexpr int most_steps = 60;
    constexpr int restoring_steps = 3;
    Vec<3> x = p;
    double first_step = 0;
    for (int step = 0; step < most_steps; ++step) {
        const auto next = nearest_on_both(tangents_at(a, b, x), p);
        if (!next || !is_finite(*next)) return std::nullopt;
        const double moved_by = distance(*next, x);
        if (step == 0) first_step = moved_by;
        x = *next;
        if (moved_by <= 1e-15 * (first_step + norm(x))) break;
    }
    for (int step = 0; step < restoring_steps; ++step) {
        const auto next = nearest_on_both(tangents_at(a, b, x), x);
        if (!next) return std::nullopt;
        x = *next;
    }
    const auto [on_a, on_b] = tangents_at(a, b, x);
    const double off = distance(on_a.point, x) + distance(on_b.point, x);
    if (!(off <= 1e-9 * (first_step + norm(x)))) return std::nullopt;
    return snapped(b, snapped(a, x));
}

template const AnalyticSurface<2>* surface_of(const AnalyticGeometry<2>&, Reference);
template const AnalyticSurface<3>* surface_of(const AnalyticGeometry<3>&, Reference);
template SurfaceFoot<2> closest_point<2>(const AnalyticSurface<2>&, const Vec<2>&);
template SurfaceFoot<3> closest_point<3>(const AnalyticSurface<3>&, const Vec<3>&);

}  // namespace camber
