module;
#include <array>
#include <numbers>
#include <utility>
#include <variant>
module camber.surface;
import camber.core;

namespace camber {

namespace {

constexpr double turn = 2 * std::numbers::pi;

/// Perpendicular unit vectors, the third along an axis.
struct Axes {
    Vec<3> x, y, z;

    explicit Axes(const Vec<3>& axis) : z(unit_or(axis, Vec<3>{{0, 0, 1}})) {
        x = some_perpendicular(z);
        y = cross(z, x);
    }
    [[nodiscard]] Vec<3> radial(double angle) const { return cos(angle) * x + sin(angle) * y; }
    [[nodiscard]] Vec<3> around(double angle) const { return cos(angle) * y - sin(angle) * x; }
    [[nodiscard]] double angle(const Vec<3>& d) const { return atan2(dot(d, y), dot(d, x)); }
};

Vec<2> along(const Plane<2>& line) {
    const Vec<2> n = unit_or(line.normal, some_direction<2>());
    return {{-n[1], n[0]}};
}
/// A zero normal is taken as foot takes it.
Axes axes(const Plane<3>& plane) { return Axes(unit_or(plane.normal, some_direction<3>())); }
Axes axes(const Sphere<3>&) { return Axes({{0, 0, 1}}); }
Axes axes(const Cylinder& cylinder) { return Axes(cylinder.axis); }
Axes axes(const Torus& torus) { return Axes(torus.axis); }

GeometryParameters coordinates(const Plane<2>& line, const Vec<2>& p) {
    return {{dot(p - line.point, along(line)), 0}};
}
GeometryParameters coordinates(const Sphere<2>& circle, const Vec<2>& p) {
    const Vec<2> d = p - circle.centre;
    return {{atan2(d[1], d[0]), 0}};
}
GeometryParameters coordinates(const Plane<3>& plane, const Vec<3>& p) {
    const Axes a = axes(plane);
    return {{dot(p - plane.point, a.x), dot(p - plane.point, a.y)}};
}
GeometryParameters coordinates(const Sphere<3>& sphere, const Vec<3>& p) {
    const Axes a = axes(sphere);
    const Vec<3> d = p - sphere.centre;
    return {{a.angle(d), atan2(dot(d, a.z), hypot(dot(d, a.x), dot(d, a.y)))}};
}
GeometryParameters coordinates(const Cylinder& cylinder, const Vec<3>& p) {
    const Axes a = axes(cylinder);
    return {{a.angle(p - cylinder.point), dot(p - cylinder.point, a.z)}};
}
GeometryParameters coordinates(const Torus& torus, const Vec<3>& p) {
    const Axes a = axes(torus);
    const Vec<3> d = p - torus.centre;
    const double angle = a.angle(d);
    return {{angle, atan2(dot(d, a.z), dot(d, a.radial(angle)) - torus.major_radius)}};
}

EntityPoint<2> at(const Plane<2>& line, double u, double) {
    const Vec<2> t = along(line);
    return {line.point + u * t, {t}, unit_or(line.normal, some_direction<2>())};
}
EntityPoint<2> at(const Sphere<2>& circle, double u, double) {
    const Vec<2> n{{cos(u), sin(u)}};
    return {circle.centre + circle.radius * n, {circle.radius * Vec<2>{{-n[1], n[0]}}}, n};
}
EntityPoint<3> at(const Plane<3>& plane, double u, double v) {
    const Axes a = axes(plane);
    return {plane.point + u * a.x + v * a.y, {a.x, a.y}, a.z};
}
EntityPoint<3> at(const Sphere<3>& sphere, double u, double v) {
    const Axes a = axes(sphere);
    const Vec<3> r = a.radial(u);
    const Vec<3> n = cos(v) * r + sin(v) * a.z;
    const Vec<3> up = cos(v) * a.z - sin(v) * r;
    return {sphere.centre + sphere.radius * n, {sphere.radius * cos(v) * a.around(u), sphere.radius * up}, n};
}
EntityPoint<3> at(const Cylinder& cylinder, double u, double v) {
    const Axes a = axes(cylinder);
    const Vec<3> n = a.radial(u);
    return {cylinder.point + v * a.z + cylinder.radius * n, {cylinder.radius * a.around(u), a.z}, n};
}
EntityPoint<3> at(const Torus& torus, double u, double v) {
    const Axes a = axes(torus);
    const Vec<3> r = a.radial(u);
    const Vec<3> n = cos(v) * r + sin(v) * a.z;
    const Vec<3> up = cos(v) * a.z - sin(v) * r;
    return {torus.centre + torus.major_radius * r + torus.minor_radius * n,
            {(torus.major_radius + torus.minor_radius * cos(v)) * a.around(u), torus.minor_radius * up},
            n};
}

std::array<double, 2> periods(const Plane<2>&) { return {0, 0}; }
std::array<double, 2> periods(const Sphere<2>&) { return {turn, 0}; }
std::array<double, 2> periods(const Plane<3>&) { return {0, 0}; }
std::array<double, 2> periods(const Sphere<3>&) { return {turn, 0}; }
std::array<double, 2> periods(const Cylinder&) { return {turn, 0}; }
std::array<double, 2> periods(const Torus&) { return {turn, turn}; }

}  // namespace

template <int D>
std::array<double, 2> periods_of(const AnalyticSurface<D>& surface) {
    return std::visit([](const auto& s) { return periods(s); }, surface);
}

template <int D>
GeometryParameters parameters_of(const AnalyticSurface<D>& surface, const Vec<D>& p) {
    return std::visit([&](const auto& s) { return coordinates(s, p); }, surface);
}

template <int D>
EntityPoint<D> point_of_parameters(const AnalyticSurface<D>& surface, const GeometryParameters& parameters) {
    return std::visit([&](const auto& s) { return at(s, parameters.u[0], parameters.u[1]); }, surface);
}

#define CAMBER_INSTANTIATE(D)                                                               \
    template std::array<double, 2> periods_of<D>(const AnalyticSurface<D>&);                \
    template GeometryParameters parameters_of<D>(const AnalyticSurface<D>&, const Vec<D>&); \
    template EntityPoint<D> point_of_parameters<D>(const AnalyticSurface<D>&, const GeometryParameters&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
