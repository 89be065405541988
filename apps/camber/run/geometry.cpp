module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.config;
import camber.surface;
import camber.cad;
import :report;
import :stages;

namespace camber::run {

namespace {

template <int D>
Outcome<Vec<D>> vec(const std::vector<double>& numbers, const char* what) {
    if (numbers.size() != D)
        return fail(ErrorKind::usage, std::string(what) + " has " + std::to_string(numbers.size()) +
                                          " coordinates, the mesh " + std::to_string(D));
    Vec<D> v;
    for (int i = 0; i < D; ++i) v[i] = numbers[static_cast<std::size_t>(i)];
    return v;
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Plane& plane) {
    auto point = vec<D>(plane.point, "the plane's point");
    if (!point) return fail(point.error());
    auto normal = vec<D>(plane.normal, "the plane's normal");
    if (!normal) return fail(normal.error());
    return Plane<D>{*point, *normal};
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Sphere& sphere) {
    // Without a centre: the origin, in either dimension.
    auto centre = vec<D>(sphere.centre.empty() ? std::vector<double>(D, 0.0) : sphere.centre, "the sphere's centre");
    if (!centre) return fail(centre.error());
    return Sphere<D>{*centre, sphere.radius};
}

template <int D, class Solid, class Make>
Outcome<AnalyticSurface<D>> make_solid(const std::vector<double>& point, const std::vector<double>& axis,
                                       const char* name, Make make) {
    if constexpr (D == 2) {
        return fail(ErrorKind::usage, std::string("a ") + name + " is a surface in 3D, the mesh is in 2D", {}, {},
                    "a circle is a \"sphere\" in 2D");
    } else {
        auto p = vec<3>(point, "the point or centre");
        if (!p) return fail(p.error());
        auto a = vec<3>(axis, "the axis");
        if (!a) return fail(a.error());
        return make(*p, *a);
    }
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Cylinder& cylinder) {
    return make_solid<D, Cylinder>(cylinder.point, cylinder.axis, "cylinder",
                                   [&](const Vec<3>& p, const Vec<3>& a) { return Cylinder{p, a, cylinder.radius}; });
}

template <int D>
Outcome<AnalyticSurface<D>> make_surface(const config::Torus& torus) {
    return make_solid<D, Torus>(torus.centre, torus.axis, "torus", [&](const Vec<3>& p, const Vec<3>& a) {
        return Torus{p, a, torus.major_radius, torus.minor_radius};
    });
}

template <int D>
Outcome<AnalyticGeometry<D>> make_entry(const config::AnalyticSurface& entry) {
    const auto surface = std::visit([](const auto& s) { return make_surface<D>(s); }, entry.surface);
    if (!surface) return fail(surface.error());
    AnalyticGeometry<D> geometry;
    for (const Reference reference : entry.references) geometry.surfaces.emplace_back(reference, *surface);
    return geometry;
}

template <int D>
AnalyticGeometry<D> joined(std::span<const AnalyticGeometry<D>> entries) {
    AnalyticGeometry<D> all;
    for (const AnalyticGeometry<D>& entry : entries)
        all.surfaces.insert(all.surfaces.end(), entry.surfaces.begin(), entry.surfaces.end());
    return all;
}

/// The entry that makes a geometry unfit: the one that is refused so alone, else the one with which the first ones are.
template <int D>
std::size_t unfit_entry(const LinearMesh<D>& mesh, std::span<const AnalyticGeometry<D>> entries, const Error& error,
                        const Execution& execution) {
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (const auto fits = check_fit(mesh, entries[i], execution); !fits && fits.error().what == error.what)
            return i;
    std::size_t i = 0;
    while (i + 1 < entries.size() && check_fit(mesh, joined(entries.first(i + 1)), execution)) ++i;
    return i;
}

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

}  // namespace

template <int D>
OffSurfacesReport off_surfaces(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry) {
    constexpr double rounding = 1e-5;  // of the facet's size; files of four-byte reals have 1e-7
    std::vector<std::uint8_t> is_off(mesh.points.size(), 0);
    OffSurfacesReport report;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const AnalyticSurface<D>* const surface = surface_of(geometry, mesh.facets.references[f]);
        if (surface == nullptr) continue;
        Box<D> box;
        for (const VertexId v : mesh.facets.vertices[f]) box.include(mesh.points[v]);
        for (const VertexId v : mesh.facets.vertices[f]) {
            const double off = distance(mesh.points[v], closest_point<D>(*surface, mesh.points[v]).point);
            if (!(off > rounding * box.diagonal())) continue;
            report.vertices += is_off[v.index()] == 0 ? 1 : 0;
            is_off[v.index()] = 1;
            report.largest = std::max(report.largest, off);
        }
    }
    return report;
}

template <int D>
Outcome<AnalyticGeometry<D>> make_analytic(const std::vector<config::AnalyticSurface>& surfaces,
                                           const std::string& where, const LinearMesh<D>& mesh,
                                           const Execution& execution) {
    const auto path_of = [&](std::size_t entry) { return where + "/" + std::to_string(entry); };
    std::vector<AnalyticGeometry<D>> entries;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        auto made = make_entry<D>(surfaces[i]);
        if (!made) {
            Error error = made.error();
            error.where = path_of(i);
            return fail(std::move(error));
        }
        entries.push_back(std::move(*made));
    }
    const std::span<const AnalyticGeometry<D>> all(entries);
    if (const auto fits = check_fit(mesh, joined(all), execution); !fits) {
        Error error = fits.error();
        if (error.kind == ErrorKind::usage || error.kind == ErrorKind::input)
            error.where = path_of(unfit_entry(mesh, all, error, execution));
        return fail(std::move(error));
    }
    return joined(all);
}

template <int D>
Outcome<MadeGeometry<D>> make_geometry(const config::Geometry& geometry, const GeometrySource& source,
                                       const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                       const FeatureOptions<D>& features_by, std::span<const LagrangeNode<D>> curves,
                                       const Execution& execution) {
    std::optional<CurvedPatchesReport> patches;
    const auto make_surrogate = [&](const GeometryModel<D>& prescribed) -> Outcome<Surrogate<D>> {
        auto straight = build_surrogate(mesh, edges, features, prescribed, SurrogateOptions{},
                                        part_of(execution, 0, curves.empty() ? 1 : 0.3));
        if (!straight || curves.empty()) return straight;
        auto curved = with_curves<D>(std::move(*straight), mesh, edges, features, curves, prescribed,
                                     SurrogateOptions{}, part_of(execution, 0.3, 1));
        if (!curved) return fail(curved.error());
        if (const CurvedPatches& of = curved->patches; of.smooth + of.as_read > 0)
            patches = {of.smooth, of.as_read, degrees(of.mean_angle), degrees(of.largest_angle)};
        return std::move(curved->surrogate);
    };
    const auto made = [&](Geometry<D> g) {
        MadeGeometry<D> out{std::move(g)};
        out.curved_patches = patches;
        return out;
    };
    if (std::holds_alternative<config::Straight>(geometry)) return made(Geometry<D>(StraightGeometry<D>{}));
    if (const auto* of_model = std::get_if<config::Cad>(&geometry)) {
        if (!source.cad) return fail(ErrorKind::internal, "the CAD model was not read");
        auto mixture = make_cad_mixture<D>(*of_model, *source.cad, mesh, edges, make_surrogate, execution);
        if (mixture) mixture->curved_patches = patches;
        return mixture;
    }
    if (const auto* file = std::get_if<config::FilePath>(&geometry)) {
        if (!source.mesh) return fail(ErrorKind::internal, "the geometry's mesh was not read");
        const auto misfits = file->is_of_cycle ? MisfitPolicy::accepted : MisfitPolicy::refused;
        return geometry_of_mesh<D>(*source.mesh, features_by, mesh, misfits, execution).map(made);
    }
    if (const auto* analytic = std::get_if<config::Analytic>(&geometry)) {
        auto surfaces = make_analytic<D>(analytic->surfaces, "/geometry/analytic", mesh, without_progress(execution));
        if (!surfaces) return fail(surfaces.error());
        const OffSurfacesReport off = off_surfaces<D>(mesh, *surfaces);
        return with_surrogate<D>(std::move(*surfaces), mesh, make_surrogate).map(made).map([&](MadeGeometry<D> all) {
            all.off_surfaces = off;
            return all;
        });
    }
    auto surrogate = make_surrogate(StraightGeometry<D>{});
    if (!surrogate) return fail(surrogate.error());
    return made(Geometry<D>(std::move(*surrogate)));
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template OffSurfacesReport off_surfaces<D>(const LinearMesh<D>&, const AnalyticGeometry<D>&);                    \
    template Outcome<AnalyticGeometry<D>> make_analytic<D>(                                                          \
        const std::vector<config::AnalyticSurface>&, const std::string&, const LinearMesh<D>&, const Execution&);    \
    template Outcome<MadeGeometry<D>> make_geometry<D>(                                                              \
        const config::Geometry&, const GeometrySource&, const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, \
        const FeatureOptions<D>&, std::span<const LagrangeNode<D>>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
