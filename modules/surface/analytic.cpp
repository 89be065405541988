// Analytic surfaces: closest points, parameters, geometry model, fit check.
module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
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

namespace {

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

/// Parameters of a point. Plane: lengths along two perpendicular directions (2D: one). Circle: angle. Sphere:
/// longitude, latitude. Cylinder: angle, length along the axis. Torus: angles about the axis and the tube.
template <int D>
GeometryParameters parameters_of(const AnalyticSurface<D>& surface, const Vec<D>& p) {
    return std::visit([&](const auto& s) { return coordinates(s, p); }, surface);
}

template <int D>
EntityPoint<D> point_of_parameters(const AnalyticSurface<D>& surface, const GeometryParameters& parameters) {
    return std::visit([&](const auto& s) { return at(s, parameters.u[0], parameters.u[1]); }, surface);
}

template <int D>
class AnalyticModel final : public GeometryModel<D> {
  public:
    explicit AnalyticModel(AnalyticGeometry<D> geometry) : geometry_(std::move(geometry)) {}

    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override {
        const std::int64_t row = row_of(hint);
        if (row < 0) return {.point = p, .normal = {}};
        const auto& [reference, surface] = geometry_.surfaces[static_cast<std::size_t>(row)];
        const auto foot = closest_point<D>(surface, p);
        return {.point = foot.point,
                .normal = foot.normal,
                .distance = camber::distance(foot.point, p),
                .entity = GeometryEntity::surface(row),
                .reference = hint.reference ? hint.reference : reference,
                .parameters = parameters_of<D>(surface, foot.point)};
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override {
        const std::int64_t row = row_of({.facet = {}, .reference = facet.reference, .entity = {}});
        return row < 0 ? GeometryEntity{} : GeometryEntity::surface(row);
    }

    [[nodiscard]] bool is_one_surface(Reference) const override { return true; }

    [[nodiscard]] std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        const std::int64_t row = row_of({.facet = {}, .reference = {}, .entity = entity});
        if (row < 0) return std::nullopt;
        return point_of_parameters<D>(geometry_.surfaces[static_cast<std::size_t>(row)].second, parameters);
    }

    [[nodiscard]] std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const override {
        const auto* surface = surface_of(geometry_, facet.reference);
        if (!surface) return plane_through(facet.corners);
        const auto* plane = std::get_if<Plane<D>>(surface);
        return plane ? std::optional(*plane) : std::nullopt;
    }

    [[nodiscard]] bool prescribes(Reference reference) const override {
        return surface_of(geometry_, reference) != nullptr;
    }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    [[nodiscard]] std::int64_t row_of(const SurfaceHint& hint) const {
        const auto& surfaces = geometry_.surfaces;
        if (hint.entity.kind == GeometryKind::surface)
            return hint.entity.id < static_cast<std::int64_t>(surfaces.size()) ? hint.entity.id : -1;
        const auto* surface = hint.reference ? surface_of(geometry_, *hint.reference) : nullptr;
        if (!surface) return -1;
        const auto first =
            std::find_if(surfaces.begin(), surfaces.end(), [&](const auto& row) { return row.second == *surface; });
        // No surface is equal if one of its coordinates is NaN; the index is then −1.
        return first == surfaces.end() ? -1 : first - surfaces.begin();
    }

    AnalyticGeometry<D> geometry_;
};

}  // namespace

template <int D>
std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D> analytic) {
    return std::make_shared<const AnalyticModel<D>>(std::move(analytic));
}

namespace {

template <int D>
const char* name_of(const Plane<D>&) {
    return "plane";
}
template <int D>
const char* name_of(const Sphere<D>&) {
    return "sphere";
}
const char* name_of(const Cylinder&) { return "cylinder"; }
const char* name_of(const Torus&) { return "torus"; }

template <int D>
double radius_of(const Plane<D>&) {
    return 0;
}
template <int D>
double radius_of(const Sphere<D>& sphere) {
    return sphere.radius;
}
double radius_of(const Cylinder& cylinder) { return cylinder.radius; }
double radius_of(const Torus& torus) { return std::fmax(torus.major_radius, torus.minor_radius); }

template <int D>
std::string name_of(const AnalyticSurface<D>& surface) {
    return std::visit([](const auto& s) { return std::string(name_of(s)); }, surface);
}

std::string named(Reference reference) { return "reference " + std::to_string(reference); }

std::vector<Reference> sorted_once(std::vector<Reference> references) {
    std::sort(references.begin(), references.end());
    references.erase(std::unique(references.begin(), references.end()), references.end());
    return references;
}

std::string listed(const std::vector<Reference>& references) {
    constexpr std::size_t most = 12;
    std::string list;
    for (std::size_t i = 0; i < std::min(most, references.size()); ++i)
        list += (i > 0 ? ", " : "") + std::to_string(references[i]);
    return list + (references.size() > most ? ", …" : "");
}

template <int D>
std::optional<Error> check_references(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry) {
    std::vector<Reference> specified;
    specified.reserve(geometry.surfaces.size());
    for (const auto& [reference, surface] : geometry.surfaces) specified.push_back(reference);
    std::sort(specified.begin(), specified.end());
    if (const auto twice = std::adjacent_find(specified.begin(), specified.end()); twice != specified.end())
        return Error{
            ErrorKind::usage, named(*twice) + " is assigned to two surfaces", {}, {}, "list each reference once"};
    const auto of_facets = sorted_once({mesh.facets.references.begin(), mesh.facets.references.end()});
    for (const Reference reference : specified)
        if (!std::binary_search(of_facets.begin(), of_facets.end(), reference))
            return Error{ErrorKind::usage,
                         std::string("no boundary ") + simplex_name<D - 1> + " of the mesh has " + named(reference),
                         {},
                         {},
                         of_facets.empty() ? "it has none at all" : "it has " + listed(of_facets)};
    return {};
}

/// Rejects radii so large that rounding hides the curvature.
template <int D>
std::optional<Error> check_radii(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry) {
    constexpr double most = 1e8;
    Box<D> box;
    for (const auto& facet : mesh.facets.vertices)
        for (const VertexId v : facet) box.include(mesh.points[v]);
    const double size = box.diagonal();
    for (const auto& [reference, surface] : geometry.surfaces) {
        const double radius = std::visit([](const auto& s) { return radius_of(s); }, surface);
        if (radius >= 0 && radius <= most * size) continue;
        return Error{ErrorKind::usage,
                     named(reference) + ": the radius of its " + name_of<D>(surface) + ", " + three_digits(radius) +
                         ", is out of range for a boundary of size " + three_digits(size),
                     {},
                     {},
                     "give a radius of at most 1e8 times that size, or a plane"};
    }
    return {};
}

template <int D>
std::vector<std::size_t> rows_at(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry,
                                 std::span<const FacetId> facets) {
    std::vector<std::size_t> rows;
    for (const FacetId f : facets) {
        const auto at =
            std::ranges::find(geometry.surfaces, mesh.facets.references[f], [](const auto& s) { return s.first; });
        if (at != geometry.surfaces.end()) rows.push_back(static_cast<std::size_t>(at - geometry.surfaces.begin()));
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    return rows;
}

template <int D>
Error report_fit_error(const std::pair<Reference, AnalyticSurface<D>>& row, const VertexFit& fit) {
    const std::string surface = name_of<D>(row.second);
    return Error{ErrorKind::input,
                 fit.text("the " + surface + " of " + named(row.first)),
                 {},
                 Entity{"vertex", fit.farthest.index() + 1},
                 "this vertex is the farthest; give the " + surface +
                     " on which the mesh was generated, in the mesh's "
                     "units"};
}

}  // namespace

template <int D>
Outcome<Done> check_fit(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry, const Execution& execution) {
    if (auto error = check_references(mesh, geometry)) return fail(std::move(*error));
    if (auto error = check_radii(mesh, geometry)) return fail(std::move(*error));
    const auto around = facet_balls(mesh, without_progress(execution));
    if (!around) return fail(around.error());
    using Fits = std::vector<VertexFit>;  // one per surface
    const auto accumulate = [&](Fits& fits, std::size_t v) {
        const Vec<D>& p = mesh.points[VertexId(v)];
        for (const std::size_t row : rows_at(mesh, geometry, (*around)[v])) {
            const Vec<D> foot = closest_point<D>(geometry.surfaces[row].second, p).point;
            fits[row].add(VertexId(v), distance(p, foot), edge_lengths_at(mesh, (*around)[v], VertexId(v)));
        }
    };
    const auto join = [](Fits a, const Fits& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i].add(b[i]);
        return a;
    };
    const auto fits = reduce_each(execution, mesh.points.size(), Fits(geometry.surfaces.size()), accumulate, join);
    if (!fits) return fail(fits.error());
    const VertexFit* worst = nullptr;
    for (const VertexFit& fit : *fits)
        if ((fit.is_refused(D) || fit.lost > 0) && (!worst || fit.largest > worst->largest)) worst = &fit;
    if (worst == nullptr) return Done{};
    return fail(report_fit_error<D>(geometry.surfaces[static_cast<std::size_t>(worst - fits->data())], *worst));
}

#define CAMBER_INSTANTIATE(D)                                                             \
    template const AnalyticSurface<D>* surface_of(const AnalyticGeometry<D>&, Reference); \
    template SurfaceFoot<D> closest_point<D>(const AnalyticSurface<D>&, const Vec<D>&);   \
    template std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D>);       \
    template Outcome<Done> check_fit(const LinearMesh<D>&, const AnalyticGeometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
