module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
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

template <int D>
SurfacePoint<D> project_onto(const MixedGeometry<D>& geometry, SurfaceHint hint, const Vec<D>& p) {
    const auto& [analytic, surrogate] = geometry;
    if (!hint.reference) {
        if (hint.facet.index() >= surrogate.facets.size())
            hint.facet = closest_among(surrogate, p, [](FacetId) { return true; }).facet;
        if (hint.facet.valid()) hint.reference = surrogate.references[hint.facet];
    }
    return hint.reference && surface_of(analytic, *hint.reference) ? project_onto(analytic, hint, p)
                                                                   : project_onto(surrogate, hint, p);
}

}  // namespace

template <int D>
Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D> analytic, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                    const Features<D>& features, const SurrogateOptions& options,
                                    const Execution& execution) {
    const auto& references = mesh.facets.references;
    const bool is_whole = std::all_of(references.begin(), references.end(),
                                      [&](Reference reference) { return surface_of(analytic, reference) != nullptr; });
    if (is_whole) return std::move(analytic);
    auto surrogate = build_surrogate(mesh, edges, features, options, execution);
    if (!surrogate) return fail(surrogate.error());
    return MixedGeometry<D>{std::move(analytic), std::move(*surrogate)};
}

template <int D>
const AnalyticGeometry<D>* analytic_part(const Geometry<D>& geometry) {
    if (const auto* mixed = std::get_if<MixedGeometry<D>>(&geometry)) return &mixed->analytic;
    return std::get_if<AnalyticGeometry<D>>(&geometry);
}

template <int D>
const Surrogate<D>* surrogate_part(const Geometry<D>& geometry) {
    if (const auto* mixed = std::get_if<MixedGeometry<D>>(&geometry)) return &mixed->surrogate;
    return std::get_if<Surrogate<D>>(&geometry);
}

template <int D>
SurfacePoint<D> project(const Geometry<D>& geometry, const SurfaceHint& hint, const Vec<D>& p) {
    return std::visit([&](const auto& g) { return project_onto<D>(g, hint, p); }, geometry);
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D>, const LinearMesh<D>&, const EdgeSet<D>&,   \
                                                 const Features<D>&, const SurrogateOptions&, const Execution&); \
    template const AnalyticGeometry<D>* analytic_part<D>(const Geometry<D>&);                                    \
    template const Surrogate<D>* surrogate_part<D>(const Geometry<D>&);                                          \
    template SurfacePoint<D> project<D>(const Geometry<D>&, const SurfaceHint&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
