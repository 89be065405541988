// Geometry models: default implementations, and the surface, plane or curve of an edge.
module;
#include <algorithm>
#include <array>
#include <cmath>
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

template <int D>
std::vector<std::int64_t> surfaces_of(const GeometryModel<D>& model, std::span<const FacetSite<D>> facets) {
    std::vector<std::int64_t> found;
    found.reserve(facets.size());
    for (const FacetSite<D>& facet : facets) found.push_back(model.surface_at(facet).id);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

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
GeometryEntity GeometryModel<D>::entity_at_edge(const EdgeSite<D>& edge) const {
    return entity_of(surfaces_of<D>(*this, edge.facets), GeometryKind::curve);
}

template <int D>
GeometryEntity GeometryModel<D>::entity_at_vertex(std::span<const FacetSite<D>> around) const {
    auto surfaces = surfaces_of(*this, around);
    if (D == 2 && surfaces.size() == 2)  // 2D: surfaces are curves and meet in a corner
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
    const SurfaceFoot<D> foot = foot_on_edge(
        sheets_around(*this, has_surface, *this, edge), p, [&] { return p; }, [] { return std::optional<Vec<D>>(); });
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
bool GeometryModel<D>::are_within(const FacetSite<D>& facet, std::span<const Vec<D>> points,
                                  std::span<const double> bounds) const {
    std::vector<double> found(points.size());
    return !distances(facet, {}, points, found) ||
           std::ranges::equal(found, bounds, [](double d, double bound) { return d <= bound; });
}

template <int D>
bool GeometryModel<D>::is_one_surface(Reference) const {
    return false;
}

template <int D>
bool GeometryModel<D>::surface_points(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
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
bool GeometryModel<D>::is_built_from(const FacetSite<D>&) const {
    return false;
}

template <int D>
double GeometryModel<D>::distance_at_facets(std::span<const FacetSite<D>> meet, const Vec<D>& p) const {
    double largest = 0;
    for (const FacetSite<D>& facet : meet) largest = std::max(largest, project(hint_at(facet), p).distance);
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
EntityName GeometryModel<D>::name_of_entity(const GeometryEntity& entity) const {
    const std::size_t number = entity.id < 0 ? 0 : static_cast<std::size_t>(entity.id) + 1;
    if (entity.kind == GeometryKind::surface) return {D == 2 ? "curve" : "surface", number};
    if (entity.kind == GeometryKind::curve) return {"curve", number};
    return {};
}

template <int D>
Outcome<GeometrySamples<D>> GeometryModel<D>::sample_all(std::size_t, const Execution&) const {
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

template <int D>
SurfacePoint<D> StraightGeometry<D>::project(const SurfaceHint&, const Vec<D>& p) const {
    return {.point = p, .normal = {}};
}

template <int D>
GeometryEntity StraightGeometry<D>::surface_at(const FacetSite<D>&) const {
    return {};
}

namespace {

/// Smallest cosine between normals of equal planes (rounding).
constexpr double same_plane = 1 - 1e-12;

constexpr double farthest_start = 1e-4;   // largest distance of a node from the sheet, relative to the chord
constexpr double min_tangent = 0.2;       // smallest sine of the angle between the edge and the normal
constexpr double farthest_foot = 0.5;     // largest distance of a moved point from the sheet, relative to the step;
                                          // larger steps exceed the radius of curvature
constexpr double largest_sideways = 0.1;  // largest tangential offset of a moved point from its closest point, relative
                                          // to the step; larger offsets occur at rims
constexpr double longest_move = 2;        // largest move of the closest point, relative to the step
constexpr double min_cosine = 0.5;        // smallest cosine between the normals, or tangents, before and after a step
constexpr double difference = 1e-4;       // step of difference quotients for curves without parameters, relative to the
                                          // chord

template <int D>
bool is_same(const GeometryEntity& a, const GeometryEntity& b) {
    return a.kind == b.kind && a.id == b.id && a.sides == b.sides;
}

Vec<2> across(const Vec<2>& v) { return {{-v[1], v[0]}}; }

}  // namespace

template <int D>
std::optional<Plane<D>> common_plane(const GeometryModel<D>& geometry, const EdgeSite<D>& edge) {
    std::optional<Plane<D>> common;
    for (const FacetSite<D>& facet : edge.facets) {
        auto plane = geometry.plane_at(facet);
        if (plane) plane->normal = unit_or(plane->normal, Vec<D>{});
        if (!plane || (common && std::abs(dot(plane->normal, common->normal)) < same_plane)) return std::nullopt;
        common = plane;
    }
    return common;
}

template <int D>
Vec<D> slid_within(const Plane<D>& plane, const Vec<D>& p, const Vec<D>& shift) {
    Vec<D> q = p + (shift - dot(plane.normal, shift) * plane.normal);
    for (int k = 0; k < D; ++k)
        if (std::abs(plane.normal[k]) == 1) q[k] = p[k];
    return q;
}

template <int D>
struct EdgeSheet<D>::Found {
    SurfacePoint<D> foot;
    bool is_on = false;
};

template <int D>
EdgeSheet<D>::EdgeSheet(const GeometryModel<D>& geometry, const EdgeSite<D>& edge)
    : geometry_(&geometry), edge_(&edge) {
    if (edge.facets.empty()) return;
    const auto is_plane = [&](const FacetSite<D>& f) { return geometry.plane_at(f).has_value(); };
    plane_ = common_plane(geometry, edge);
    if (plane_ && D == 3 && edge.kind == EdgeKind::surface) {
        kind_ = Kind::plane;
        return;
    }
    // The edge is on a line in these cases: any planar edge in 2D, an edge between planes, the rim of a plane.
    if (plane_ || (D == 3 && std::ranges::all_of(edge.facets, is_plane))) return;
    entity_ = geometry.entity_at_edge(edge);
    if (entity_.kind == GeometryKind::surface && (D == 2 || edge.kind == EdgeKind::surface)) kind_ = Kind::surface;
    if (entity_.kind == GeometryKind::curve && D == 3) kind_ = Kind::curve;
}

template <int D>
typename EdgeSheet<D>::Found EdgeSheet<D>::nearest(const FacetId& facet, const Vec<D>& p) const {
    const SurfacePoint<D> foot = kind_ == Kind::curve
                                     ? geometry_->on_edge(*edge_, p)
                                     : geometry_->project({facet, edge_->facets.front().reference, entity_}, p);
    return {foot, is_same<D>(foot.entity, entity_) && is_finite(foot.point)};
}

template <int D>
Vec<D> EdgeSheet<D>::direction_at(const Found& found) const {
    const Vec<D> chord = edge_->ends[1] - edge_->ends[0];
    if (found.foot.parameters)
        if (const auto at = geometry_->evaluate(found.foot.entity, *found.foot.parameters)) {
            const Vec<D> unit = normalised(at->tangents[0]);
            return dot(unit, chord) < 0 ? -unit : unit;
        }
    const Vec<D> step = difference * chord;
    return normalised(geometry_->on_edge(*edge_, found.foot.point + step).point -
                      geometry_->on_edge(*edge_, found.foot.point - step).point);
}

template <int D>
std::optional<SheetPosition<D>> EdgeSheet<D>::framed(
    const Found& found, const std::array<Vec<D>, static_cast<std::size_t>(D - 1)>& near) const {
    SheetPosition<D> place{found.foot.point, {}, {}, found.foot.facet};
    if (kind_ == Kind::curve) {
        place.tangents[0] = direction_at(found);
        if (!(dot(place.tangents[0], near[0]) >= min_cosine)) return std::nullopt;
        return place;
    }
    place.normal = normalised(plane_ ? plane_->normal : found.foot.normal);
    const Vec<D> first = near[0] - dot(near[0], place.normal) * place.normal;
    if (!(norm(first) >= min_tangent)) return std::nullopt;
    place.tangents[0] = normalised(first);
    if constexpr (D == 3) {
        const Vec<3> second = cross(place.normal, place.tangents[0]);
        place.tangents[1] = dot(second, near[1]) < 0 ? -second : second;
    } else {
        const Vec<2> along = across(place.normal);
        place.tangents[0] = dot(along, near[0]) < 0 ? -along : along;
    }
    return place;
}

template <int D>
std::optional<SheetPosition<D>> EdgeSheet<D>::place_of(const Vec<D>& node) const {
    if (kind_ == Kind::straight) return std::nullopt;
    const Vec<D> chord = edge_->ends[1] - edge_->ends[0];
    Found found{{.point = node, .normal = {}}, true};
    if (kind_ != Kind::plane) {
        found = nearest({}, node);
        if (!found.is_on || !(found.foot.distance <= farthest_start * norm(chord))) return std::nullopt;
        found.foot.point = node;
    }
    std::array<Vec<D>, static_cast<std::size_t>(D - 1)> near{};
    near[0] = normalised(chord);
    return framed(found, near);
}

template <int D>
std::optional<SheetPosition<D>> EdgeSheet<D>::moved(const SheetPosition<D>& from, const Vec<D>& step) const {
    if (kind_ == Kind::plane) {
        SheetPosition<D> place = from;
        place.point = slid_within(*plane_, from.point, step);
        return place;
    }
    const Vec<D> p = from.point + step;
    const double length = norm(step);
    const Found found = nearest(from.facet, p);
    if (!found.is_on || !(found.foot.distance <= farthest_foot * length) ||
        !(distance(found.foot.point, from.point) <= longest_move * length))
        return std::nullopt;
    const auto place = framed(found, from.tangents);
    if (!place) return std::nullopt;
    // Normals are compared without sign: facets of an interface may have either orientation.
    if (kind_ == Kind::surface && std::abs(dot(place->normal, from.normal)) < min_cosine) return std::nullopt;
    const Vec<D> off = p - place->point;
    for (int i = 0; i < unknowns(); ++i)
        if (std::abs(dot(place->tangents[static_cast<std::size_t>(i)], off)) > largest_sideways * length)
            return std::nullopt;
    return place;
}

template <int D>
SurfaceFoot<D> EdgeSheet<D>::foot(const SheetPosition<D>& near, const Vec<D>& p) const {
    if (plane_) return {slid_within(*plane_, near.point, p - near.point), plane_->normal};
    const Found found = nearest(near.facet, p);
    return {found.foot.point, found.foot.normal};
}

template <int D>
bool EdgeSheet<D>::has_left_facets(const SheetPosition<D>& from, const SheetPosition<D>& to) const {
    if (from.facet == to.facet) return false;
    // If the surrogate is of this mesh, the facets at the edge count as one facet.
    const auto is_at_edge = [&](FacetId facet) {
        return std::ranges::any_of(edge_->facets, [&](const FacetSite<D>& site) { return site.id == facet; });
    };
    return !is_at_edge(from.facet) || !is_at_edge(to.facet);
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template class GeometryModel<D>;                                                               \
    template class StraightGeometry<D>;                                                            \
    template class EdgeSheet<D>;                                                                   \
    template std::optional<Plane<D>> common_plane<D>(const GeometryModel<D>&, const EdgeSite<D>&); \
    template Vec<D> slid_within<D>(const Plane<D>&, const Vec<D>&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
