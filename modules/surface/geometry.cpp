module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// The surfaces of facets, each once, by rising number; `unnumbered` for facets without one.
template <int D>
std::vector<std::int64_t> surfaces_of(const GeometryModel<D>& model, std::span<const FacetSite<D>> facets) {
    std::vector<std::int64_t> found;
    found.reserve(facets.size());
    for (const FacetSite<D>& facet : facets) found.push_back(model.surface_at(facet).id);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

/// What stands where these surfaces are, of which two make a curve, and more make what is said.
GeometryEntity entity_of(const std::vector<std::int64_t>& surfaces, GeometryKind of_more) {
    if (surfaces.empty() || surfaces.back() == GeometryEntity::unnumbered) return {};
    if (surfaces.size() == 1) return GeometryEntity::surface(surfaces[0]);
    if (surfaces.size() == 2 || of_more == GeometryKind::curve)
        return {GeometryKind::curve, GeometryEntity::unnumbered, {surfaces[0], surfaces[1]}};
    return {of_more, GeometryEntity::unnumbered, {GeometryEntity::unnumbered, GeometryEntity::unnumbered}};
}

}  // namespace

template <int D>
std::optional<EntityPoint<D>> GeometryModel<D>::evaluate(const GeometryEntity&, const GeometryParameters&) const {
    return std::nullopt;
}

template <int D>
std::array<double, 2> GeometryModel<D>::periods(const GeometryEntity&) const {
    return {0, 0};
}

template <int D>
GeometryEntity GeometryModel<D>::entity_at_edge(const EdgeSite<D>& edge) const {
    return entity_of(surfaces_of<D>(*this, edge.facets), GeometryKind::curve);
}

template <int D>
GeometryEntity GeometryModel<D>::entity_at_vertex(std::span<const FacetSite<D>> around) const {
    auto surfaces = surfaces_of(*this, around);
    if (D == 2 && surfaces.size() == 2)  // surfaces are curves in 2D, and meet in a corner
        return surfaces.back() == GeometryEntity::unnumbered
                   ? GeometryEntity{}
                   : GeometryEntity{GeometryKind::corner, GeometryEntity::unnumbered, {surfaces[0], surfaces[1]}};
    return entity_of(surfaces, GeometryKind::corner);
}

template <int D>
std::optional<Plane<D>> GeometryModel<D>::plane_at(const FacetSite<D>& facet) const {
    if (has_surface_at(facet)) return std::nullopt;
    return plane_through(facet.corners);
}

template <int D>
SurfacePoint<D> GeometryModel<D>::on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const {
    const auto has_surface = [&](const FacetSite<D>& f) { return has_surface_at(f); };
    if (std::none_of(edge.facets.begin(), edge.facets.end(), has_surface)) return {.point = p, .normal = {}};
    const SurfaceFoot<D> foot =
        foot_on_edge(*this, has_surface, *this, edge, p, [&] { return p; }, [] { return std::optional<Vec<D>>(); });
    return point_on_edge(*this, edge, foot, p);
}

template <int D>
Vec<D> GeometryModel<D>::middle_of(const EdgeSite<D>& edge) const {
    return on_edge(edge, edge.middle()).point;
}

template <int D>
bool GeometryModel<D>::distances(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>>,
                                 std::span<const Vec<D>> points, std::span<double> out) const {
    const GeometryEntity surface = surface_at(facet);
    if (surface.kind == GeometryKind::none) return false;
    const SurfaceHint hint{.facet = {}, .reference = facet.reference, .entity = surface};
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = project(hint, points[i]).distance;
    return true;
}

template <int D>
std::optional<LargestDistance> GeometryModel<D>::largest_distance(const FacetSite<D>& facet,
                                                                  std::span<const Barycentric<D - 1>> at,
                                                                  std::span<const Vec<D>> points, double bound) const {
    std::vector<double> found(points.size());
    if (!distances(facet, at, points, found)) return std::nullopt;
    for (const double d : found) bound = std::max(bound, d);
    return LargestDistance{bound, points.size()};
}

template <int D>
bool GeometryModel<D>::points_over(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                   std::span<Vec<D>> out) const {
    const GeometryEntity surface = surface_at(facet);
    if (surface.kind == GeometryKind::none) return false;
    const SurfaceHint hint{.facet = {}, .reference = facet.reference, .entity = surface};
    for (std::size_t n = 0; n < at.size(); ++n) {
        Vec<D> straight;
        for (std::size_t i = 0; i < D; ++i) straight += at[n][i] * facet.corners[i];
        out[n] = project(hint, straight).point;
    }
    return true;
}

template <int D>
double GeometryModel<D>::distance_where(std::span<const FacetSite<D>> meet, const Vec<D>& p) const {
    double largest = 0;
    for (const FacetSite<D>& facet : meet)
        largest = std::max(largest, project({.facet = facet.id, .reference = facet.reference}, p).distance);
    return largest;
}

template <int D>
std::optional<std::array<Vec<D>, D>> GeometryModel<D>::normals_at(const FacetSite<D>& facet) const {
    const GeometryEntity surface = surface_at(facet);
    if (surface.kind == GeometryKind::none) return std::nullopt;
    std::array<Vec<D>, D> normals;
    for (std::size_t i = 0; i < D; ++i)
        normals[i] = project({.facet = {}, .reference = facet.reference, .entity = surface}, facet.corners[i]).normal;
    return normals;
}

template <int D>
EntityName GeometryModel<D>::called(const GeometryEntity& entity) const {
    const std::size_t number = entity.id < 0 ? 0 : static_cast<std::size_t>(entity.id) + 1;
    if (entity.kind == GeometryKind::surface) return {D == 2 ? "curve" : "surface", number};
    if (entity.kind == GeometryKind::curve) return {"curve", number};
    return {};
}

template <int D>
Outcome<GeometrySamples<D>> GeometryModel<D>::own_samples(std::size_t, const Execution&) const {
    return GeometrySamples<D>{};
}

template <int D>
bool GeometryModel<D>::prescribes(Reference) const {
    return false;
}

template <int D>
bool GeometryModel<D>::prescribes_any() const {
    return false;
}

#define CAMBER_INSTANTIATE(D) template class GeometryModel<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
