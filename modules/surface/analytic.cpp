module;
#include <cmath>
#include <variant>
module camber.surface;
import camber.core;

namespace camber {

namespace {

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

#define CAMBER_INSTANTIATE(D)                                                             \
    template const AnalyticSurface<D>* surface_of(const AnalyticGeometry<D>&, Reference); \
    template SurfaceFoot<D> closest_point<D>(const AnalyticSurface<D>&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
