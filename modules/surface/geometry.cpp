module;
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <variant>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
SurfacePoint<D> project_onto(const StraightGeometry&, const SurfaceHint&, const Vec<D>& p) {
    return {.point = p, .normal = {}};
}

template <int D>
SurfacePoint<D> project_onto(const AnalyticGeometry<D>& geometry, const SurfaceHint& hint, const Vec<D>& p) {
    const auto* surface = hint.reference ? surface_of(geometry, *hint.reference) : nullptr;
    if (!surface) return {.point = p, .normal = {}};
    const auto foot = closest_point<D>(*surface, p);
    return {foot.point, foot.normal, distance(foot.point, p), {}};
}

template <int D>
SurfacePoint<D> project_onto(const Surrogate<D>& surrogate, const SurfaceHint& hint, const Vec<D>& p) {
    const auto admitted = [&](FacetId f) { return !hint.reference || surrogate.references[f] == *hint.reference; };
    const auto foot = hint.facet.index() < surrogate.facets.size() ? closest_near(surrogate, hint.facet, p)
                                                                   : closest_among(surrogate, p, admitted);
    if (!foot.facet.valid()) return {.point = p, .normal = {}};
    return {foot.point, normal_at<D>(surrogate.facets[foot.facet], foot.xi), std::sqrt(foot.distance_squared),
            foot.facet};
}

}  // namespace

template <int D>
SurfacePoint<D> project(const Geometry<D>& geometry, const SurfaceHint& hint, const Vec<D>& p) {
    return std::visit([&](const auto& g) { return project_onto<D>(g, hint, p); }, geometry);
}

template SurfacePoint<2> project<2>(const Geometry<2>&, const SurfaceHint&, const Vec<2>&);
template SurfacePoint<3> project<3>(const Geometry<3>&, const SurfaceHint&, const Vec<3>&);

}  // namespace camber
