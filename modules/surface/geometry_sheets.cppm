module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.surface:geometry_sheets;
import camber.core;
import :geometry;
import :geometry_places;
import :meeting;
import :plane;

namespace camber {

/// One of the surfaces around an edge: a model's, or the plane of a facet that has none.
template <int D>
struct Sheet {
    const GeometryModel<D>* of = nullptr;
    SurfaceHint hint;
    GeometryEntity entity;
    std::optional<Plane<D>> plane;

    [[nodiscard]] SurfaceFoot<D> foot(const Vec<D>& p) const {
        if (plane) return camber::foot(*plane, p);
        const SurfacePoint<D> found = of->project(hint, p);
        return {found.point, found.normal};
    }
    [[nodiscard]] Vec<D> held(const Vec<D>& p) const { return plane ? snapped(*plane, p) : p; }
    [[nodiscard]] bool is_same(const Sheet& other) const {
        if (plane && other.plane) return *plane == *other.plane;
        return of == other.of && entity == other.entity && plane.has_value() == other.plane.has_value();
    }
};

/// What is known of the surfaces around an edge, on one side of which at least there is one.
template <int D>
struct Sheets {
    std::vector<Sheet<D>> distinct;  ///< of facets with a surface, and planes of those without
    bool all = true;                 ///< whether each facet has one or a plane

    void add(Sheet<D> sheet) {
        const auto same = [&](const Sheet<D>& other) { return sheet.is_same(other); };
        if (std::any_of(distinct.begin(), distinct.end(), same)) return;
        // Curved ones first: among three or more the first two decide.
        distinct.insert(sheet.plane ? distinct.end() : distinct.begin(), std::move(sheet));
    }
};

/// The surfaces of `first` on the facets that it `owns`; else what `rest` prescribes, or the planes that it has there.
template <int D, class Owns>
[[nodiscard]] Sheets<D> sheets_around(const GeometryModel<D>& first, Owns&& owns, const GeometryModel<D>& rest,
                                      const EdgeSite<D>& edge) {
    Sheets<D> around;
    for (const FacetSite<D>& facet : edge.facets) {
        if (owns(facet) || rest.prescribes(facet.reference)) {
            const GeometryModel<D>& of = owns(facet) ? first : rest;
            const GeometryEntity surface = of.surface_at(facet);
            const SurfaceHint hint{.facet = {}, .reference = facet.reference, .entity = surface};
            around.add({&of, hint, surface, of.plane_at(facet)});
        } else if (auto plane = rest.plane_at(facet)) {
            around.add({&rest, {}, {}, std::move(plane)});
        } else {
            around.all = false;
        }
    }
    return around;
}

/// The point near p of the one surface around an edge, or of the curve where the first two meet; a normal only of the
/// one surface. There is a surface among them. `touching()`: where two that touch rather than cross have their curve,
/// if that is known; else it is wherever the edge is, on the first of them.
template <class Touching>
[[nodiscard]] SurfaceFoot<3> foot_where_they_meet(const std::vector<Sheet<3>>& sheets, const Vec<3>& p,
                                                  Touching&& touching) {
    const Sheet<3>& a = sheets[0];
    if (sheets.size() == 1) return a.foot(p);
    const Sheet<3>& b = sheets[1];
    if (a.plane && b.plane) return {p, {}};
    const auto met = nearest_where_they_meet([&](const Vec<3>& x) { return a.foot(x); },
                                             [&](const Vec<3>& x) { return b.foot(x); }, p);
    if (met) return {b.held(a.held(*met)), {}};
    const std::optional<Vec<3>> known = touching();
    return {known ? *known : a.foot(p).point, {}};
}

/// The same in 2D, where an edge is a facet and lies on its surface.
template <class Touching>
[[nodiscard]] SurfaceFoot<2> foot_where_they_meet(const std::vector<Sheet<2>>& sheets, const Vec<2>& p, Touching&&) {
    return sheets[0].foot(p);
}

/// The point near p of an edge some facets of which `first` owns. `rest_at()`: what `rest` takes for that point, which
/// beside a curved surface knows the ridge along the edge, and `first` where it is across. `touching()`: as above.
template <int D, class Owns, class RestAt, class Touching>
[[nodiscard]] SurfaceFoot<D> foot_on_edge(const GeometryModel<D>& first, Owns&& owns, const GeometryModel<D>& rest,
                                          const EdgeSite<D>& edge, const Vec<D>& p, RestAt&& rest_at,
                                          Touching&& touching) {
    const Sheets<D> around = sheets_around(first, owns, rest, edge);
    return foot_where_they_meet(around.distinct, around.all ? p : rest_at(), touching);
}

/// What stands at an edge, by its foot there: on a surface with the place in that.
template <int D>
[[nodiscard]] SurfacePoint<D> point_on_edge(const GeometryModel<D>& model, const EdgeSite<D>& edge,
                                            const SurfaceFoot<D>& foot, const Vec<D>& p) {
    SurfacePoint<D> out{.point = foot.point,
                        .normal = foot.normal,
                        .distance = camber::distance(foot.point, p),
                        .entity = model.entity_at_edge(edge)};
    if (out.entity.kind != GeometryKind::surface) return out;
    const auto in_surface = model.project({.facet = {}, .reference = {}, .entity = out.entity}, foot.point);
    out.reference = edge.facets.front().reference;
    out.parameters = in_surface.parameters;
    return out;
}

}  // namespace camber
