module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.soundness;
import camber.io;
import camber.surface;
import camber.cad;

namespace camber::run {

namespace {

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
    // An empty centre is the origin.
    auto centre = vec<D>(sphere.centre.empty() ? std::vector<double>(D, 0.0) : sphere.centre, "the sphere's centre");
    if (!centre) return fail(centre.error());
    return Sphere<D>{*centre, sphere.radius};
}

template <int D, class Solid, class Make>
Outcome<AnalyticSurface<D>> make_solid(const std::vector<double>& point, const std::vector<double>& axis,
                                       const char* name, Make make) {
    if constexpr (D == 2) {
        return fail(ErrorKind::usage, std::string("a ") + name + " is a surface in 3D, but the mesh is in 2D", {}, {},
                    "use a \"sphere\" for a circle in 2D");
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

/// Index of the entry that fails alone, else of the first that fails together with those before it.
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
    constexpr double rounding = 1e-5;  // relative to the facet; files with 4-byte reals have 1e-7
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
        auto result = make_entry<D>(surfaces[i]);
        if (!result) {
            Error error = result.error();
            error.where = path_of(i);
            return fail(std::move(error));
        }
        entries.push_back(std::move(*result));
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
Outcome<BuiltGeometry<D>> make_geometry(const config::Geometry& geometry, const GeometrySource& source,
                                        const BoundaryCurves<D>& boundary, const FeatureOptions<D>& features_by,
                                        const Execution& execution) {
    const auto& [mesh, edges, features, curves] = boundary;
    std::optional<CurvedPatchesReport> patches;
    const auto make_surrogate = [&](const GeometryModel<D>& prescribed) -> Outcome<Surrogate<D>> {
        auto straight = build_surrogate(mesh, edges, features, prescribed, SurrogateOptions{},
                                        part_of(execution, 0, curves.empty() ? 1 : 0.3));
        if (!straight || curves.empty()) return straight;
        auto curved = build_curved_surrogate<D>(std::move(*straight), boundary, prescribed, SurrogateOptions{},
                                                part_of(execution, 0.3, 1));
        if (!curved) return fail(curved.error());
        if (const CurvedPatches& of = curved->patches; of.smooth + of.as_read > 0)
            patches = {of.smooth, of.as_read, degrees(of.mean_angle), degrees(of.largest_angle)};
        return std::move(curved->surrogate);
    };
    const auto build = [&](Geometry<D> g) {
        BuiltGeometry<D> out{std::move(g)};
        out.curved_patches = patches;
        return out;
    };
    if (std::holds_alternative<config::Straight>(geometry)) return build(Geometry<D>(StraightGeometry<D>{}));
    if (const auto* of_model = std::get_if<config::Cad>(&geometry)) {
        if (!source.cad) return fail(ErrorKind::internal, "the CAD model was not read");
        auto mixture = make_cad_mixture<D>(*of_model, *source.cad, mesh, edges, make_surrogate, execution);
        if (mixture) mixture->curved_patches = patches;
        return mixture;
    }
    if (const auto* file = std::get_if<config::FilePath>(&geometry)) {
        if (!source.mesh) return fail(ErrorKind::internal, "the geometry's mesh was not read");
        const auto policy = file->is_of_cycle ? FitErrorPolicy::accepted : FitErrorPolicy::refused;
        return geometry_of_mesh<D>(*source.mesh, features_by, mesh, policy, execution).map(build);
    }
    if (const auto* analytic = std::get_if<config::Analytic>(&geometry)) {
        auto surfaces = make_analytic<D>(analytic->surfaces, "/geometry/analytic", mesh, without_progress(execution));
        if (!surfaces) return fail(surfaces.error());
        const OffSurfacesReport off = off_surfaces<D>(mesh, *surfaces);
        return with_surrogate<D>(std::move(*surfaces), mesh, make_surrogate).map(build).map([&](BuiltGeometry<D> all) {
            all.off_surfaces = off;
            return all;
        });
    }
    auto surrogate = make_surrogate(StraightGeometry<D>{});
    if (!surrogate) return fail(surrogate.error());
    return build(Geometry<D>(std::move(*surrogate)));
}

namespace {

constexpr const char* where = "/geometry/mesh";

template <int D>
Outcome<Surrogate<D>> boundary_of_straight(const LinearMesh<D>& mesh, const FeatureOptions<D>& features_by,
                                           const Execution& execution) {
    const auto edges = unique_edges(mesh, part_of(execution, 0, 0.1));
    if (!edges) return fail(edges.error());
    const auto features = find_features(mesh, *edges, features_by, part_of(execution, 0.1, 0.4));
    if (!features) return fail(features.error());
    return build_surrogate(mesh, *edges, *features, SurrogateOptions{}, part_of(execution, 0.4, 1));
}

template <int D>
Outcome<Surrogate<D>> boundary_of_curved(const QuadraticMesh<D>& mesh, const FeatureOptions<D>& features_by,
                                         const Execution& execution) {
    const auto& [linear, edges, nodes] = mesh;
    const auto features = find_features(linear, edges, features_by, part_of(execution, 0, 0.3));
    if (!features) return fail(features.error());
    auto smooth = build_surrogate(linear, edges, *features, SurrogateOptions{}, part_of(execution, 0.3, 0.6));
    if (!smooth) return smooth;
    auto curved = build_curved_surrogate<D>(std::move(*smooth), {linear, edges, *features, nodes.view()},
                                            StraightGeometry<D>{}, SurrogateOptions{}, part_of(execution, 0.6, 1));
    if (!curved) return fail(curved.error());
    return std::move(curved->surrogate);
}

template <int D>
Outcome<Surrogate<D>> boundary_of(Mesh<D> mesh, const FeatureOptions<D>& features_by, const Execution& execution) {
    auto sound = prepare(std::move(mesh), part_of(execution, 0, 0.25));
    if (!sound) return fail(sound.error());
    const Execution rest = part_of(execution, 0.25, 1);
    return on_simplices(std::move(sound->mesh), [&]<class Simplices>(const Simplices& of) {
        if constexpr (std::is_same_v<Simplices, LinearMesh<D>>)
            return boundary_of_straight(of, features_by, rest);
        else
            return boundary_of_curved(of, features_by, rest);
    });
}

template <int D>
Outcome<Done> check_references(const Surrogate<D>& surrogate, const LinearMesh<D>& mesh) {
    std::vector<Reference> known(surrogate.references.begin(), surrogate.references.end());
    std::ranges::sort(known);
    known.erase(std::ranges::unique(known).begin(), known.end());
    for (const Reference reference : mesh.facets.references)
        if (!std::ranges::binary_search(known, reference))
            return fail(
                ErrorKind::usage,
                fmt::format("no boundary {} of the geometry's mesh has reference {}", simplex_name<D - 1>, reference),
                where, {}, "give a mesh whose boundary has all references of the input mesh");
    return Done{};
}

/// True if a point lies between a straight facet of the geometry's mesh and the surface above it. Vertices that moved
/// only a part of the way to the surface lie there.
template <int D>
bool is_below_surface(const Surrogate<D>& surrogate, const SurfacePoint<D>& foot, const Vec<D>& point) {
    constexpr double slack = 1.1;  // the straight facet is not exactly below the closest point
    if (!foot.facet.valid() || !foot.parameters) return false;
    Barycentric<D - 1> xi{};
    xi[0] = 1;
    for (int i = 1; i < D; ++i) {
        xi[i] = foot.parameters->u[i - 1];
        xi[0] -= xi[i];
    }
    Vec<D> on_facet{};
    for (int i = 0; i < D; ++i) {
        Barycentric<D - 1> corner{};
        corner[i] = 1;
        on_facet += xi[i] * point_at(surrogate.facets[foot.facet], corner);
    }
    const Vec<D> down = on_facet - foot.point, off = point - foot.point;
    return dot(off, down) >= 0 && norm(off) <= slack * norm(down);
}

template <int D>
Outcome<Done> check_fit(const Geometry<D>& geometry, const Surrogate<D>& surrogate, const LinearMesh<D>& mesh,
                        const Execution& execution) {
    const auto accumulate = [&](BoundaryFit& fit, std::size_t f) {
        const auto site = facet_site(mesh, FacetId(f));
        const double most = fit_tolerance * distance(site.corners[0], site.corners[1]);
        FitError worst;
        for (std::size_t i = 0; i < D; ++i) {
            const auto foot =
                geometry->project({.facet = {}, .reference = site.reference, .entity = {}}, site.corners[i]);
            if (foot.distance > most && !is_below_surface(surrogate, foot, site.corners[i]))
                worst = worse(worst, {foot.distance, most, mesh.facets.vertices[FacetId(f)][i], site.reference});
        }
        fit.add(worst);
    };
    const auto join = [](BoundaryFit a, const BoundaryFit& b) {
        a.add(b);
        return a;
    };
    const auto fit = reduce_each(execution, mesh.facets.size(), BoundaryFit{}, accumulate, join);
    if (!fit) return fail(fit.error());
    const auto worst = fit->refused();
    if (!worst) return Done{};
    return fail(ErrorKind::input,
                fmt::format("is {:.3g} away from the boundary of the geometry's mesh. The limit is 10 % of the length "
                            "of the edges there, {:.3g}, except for a few vertices",
                            worst->distance, worst->allowed),
                where, Entity{"vertex", worst->vertex.index() + 1},
                "no other vertex is farther; give a mesh of the same body with the same position and units");
}

}  // namespace

template <int D>
Outcome<Geometry<D>> geometry_of_mesh(const AnyMesh& other, const FeatureOptions<D>& features_by,
                                      const LinearMesh<D>& mesh, FitErrorPolicy policy, const Execution& execution) {
    return std::visit(
        [&]<int Other>(const Mesh<Other>& of) -> Outcome<Geometry<D>> {
            if constexpr (Other != D) {
                return fail(ErrorKind::usage,
                            fmt::format("is a mesh in {}D, but the mesh to curve is in {}D", Other, D), where, {},
                            "give a mesh of the same dimension");
            } else {
                auto surrogate = boundary_of<D>(of, features_by, part_of(execution, 0, 0.8));
                if (!surrogate) return fail(surrogate.error());
                if (auto known = check_references(*surrogate, mesh); !known) return fail(known.error());
                Geometry<D> geometry(PrescribedSurrogate<D>{*surrogate});
                if (policy == FitErrorPolicy::accepted) return geometry;
                auto fits = check_fit(geometry, *surrogate, mesh, part_of(execution, 0.8, 1));
                if (!fits) return fail(fits.error());
                return geometry;
            }
        },
        other);
}

namespace {

constexpr int degree = 6;

template <int D>
constexpr auto lattice = [] {
    std::array<Barycentric<D - 1>, node_count<degree, D - 1>> all{};
    for (std::size_t n = 0; n < all.size(); ++n)
        for (std::size_t i = 0; i < D; ++i)
            all[n][i] = static_cast<double>(multi_indices<degree, D - 1>[n][i]) / degree;
    return all;
}();

/// Lattice point at α plus 1 in the listed components.
template <int K>
std::uint32_t point_at(MultiIndex<K> alpha, std::initializer_list<std::size_t> more) {
    for (const std::size_t i : more) ++alpha[i];
    return static_cast<std::uint32_t>(position<degree, K>(alpha));
}

/// Small facets of the lattice, oriented like the large facet.
std::vector<std::array<std::uint32_t, 2>> small_facets_2d() {
    std::vector<std::array<std::uint32_t, 2>> all;
    all.reserve(degree);
    for (const auto& alpha : multi_indices<degree - 1, 1>)
        all.push_back({point_at<1>(alpha, {0}), point_at<1>(alpha, {1})});
    return all;
}
std::vector<std::array<std::uint32_t, 3>> small_facets_3d() {
    std::vector<std::array<std::uint32_t, 3>> all;
    all.reserve(degree * degree);
    for (const auto& alpha : multi_indices<degree - 1, 2>)
        all.push_back({point_at<2>(alpha, {0}), point_at<2>(alpha, {1}), point_at<2>(alpha, {2})});
    for (const auto& alpha : multi_indices<degree - 2, 2>)
        all.push_back({point_at<2>(alpha, {0, 1}), point_at<2>(alpha, {1, 2}), point_at<2>(alpha, {2, 0})});
    return all;
}
template <int D>
auto small_facets() {
    if constexpr (D == 2)
        return small_facets_2d();
    else
        return small_facets_3d();
}

Vec<2> normal_of(const std::array<Vec<2>, 2>& c) { return normalised(Vec<2>{{c[1][1] - c[0][1], c[0][0] - c[1][0]}}); }
Vec<3> normal_of(const std::array<Vec<3>, 3>& c) { return normalised(cross(c[1] - c[0], c[2] - c[0])); }

template <int D>
void sample(const Geometry<D>& geometry, const FacetSite<D>& site, std::span<Vec<D>> points,
            std::span<Vec<D>> normals) {
    const bool has_surface = geometry->surface_points(site, lattice<D>, points);
    const Vec<D> own = normal_of(site.corners);
    const SurfaceHint hint = geometry->hint_at(site, geometry->surface_at(site));
    for (std::size_t n = 0; n < points.size(); ++n) {
        if (!has_surface) {
            points[n] = {};
            for (std::size_t i = 0; i < D; ++i) points[n] += lattice<D>[n][i] * site.corners[i];
        }
        normals[n] = has_surface ? geometry->project(hint, points[n]).normal : own;
        // Normals are oriented like that of the facet.
        if (dot(normals[n], own) < 0) normals[n] = -normals[n];
    }
}

template <int D>
MeshField vectors(const Column<Vec<D>>& values) {
    Buffer<double> column(values.size() * D);
    for (std::size_t n = 0; n < values.size(); ++n)
        std::copy(values[n].c.begin(), values[n].c.end(), column.begin() + static_cast<std::ptrdiff_t>(n * D));
    return {"normal", Centring::node, FieldKind::vector, Column<double>(std::move(column))};
}

}  // namespace

template <int D>
Outcome<SurfaceMesh> surface_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                  const Geometry<D>& geometry, const Execution& execution) {
    constexpr std::size_t n = lattice<D>.size();
    const auto small = small_facets<D>();
    const std::size_t facets = mesh.linear.facets.size(), m = small.size();
    Buffer<Vec<D>> points(facets * n), normals(facets * n);
    Buffer<SimplexVertices<D - 1>> vertices(facets * m);
    Buffer<Reference> references(facets * m), of_points(facets * n);
    Buffer<std::int32_t> numbers(facets * m), patches(facets * m);
    std::fill(of_points.begin(), of_points.end(), 0);
    auto done = each(
        execution, facets,
        [&](std::size_t f) {
            sample(geometry, facet_site(mesh.linear, FacetId(f)), std::span(points).subspan(f * n, n),
                   std::span(normals).subspan(f * n, n));
            for (std::size_t k = 0; k < m; ++k) {
                for (std::size_t i = 0; i < D; ++i) vertices[f * m + k][i] = VertexId(f * n + small[k][i]);
                references[f * m + k] = mesh.linear.facets.references[f];
                numbers[f * m + k] = static_cast<std::int32_t>(f + 1);
                patches[f * m + k] = static_cast<std::int32_t>(features.patches[f]);
            }
        },
        64);
    if (!done) return fail(done.error());
    LinearMesh<D> out;
    out.points = std::move(points);
    out.point_references = std::move(of_points);
    out.facets.vertices = std::move(vertices);
    out.facets.references = std::move(references);
    const auto of_cells = [](const char* name, Buffer<std::int32_t> values) {
        return MeshField{name, Centring::cell, FieldKind::scalar, Column<std::int32_t>(std::move(values))};
    };
    return SurfaceMesh{as_mesh(std::move(out)),
                       MeshFields({vectors<D>(Column<Vec<D>>(std::move(normals))),
                                   of_cells("facet", std::move(numbers)), of_cells("patch", std::move(patches))})};
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template OffSurfacesReport off_surfaces<D>(const LinearMesh<D>&, const AnalyticGeometry<D>&);                     \
    template Outcome<AnalyticGeometry<D>> make_analytic<D>(                                                           \
        const std::vector<config::AnalyticSurface>&, const std::string&, const LinearMesh<D>&, const Execution&);     \
    template Outcome<BuiltGeometry<D>> make_geometry<D>(const config::Geometry&, const GeometrySource&,               \
                                                        const BoundaryCurves<D>&, const FeatureOptions<D>&,           \
                                                        const Execution&);                                            \
    template Outcome<Geometry<D>> geometry_of_mesh<D>(const AnyMesh&, const FeatureOptions<D>&, const LinearMesh<D>&, \
                                                      FitErrorPolicy, const Execution&);                              \
    template Outcome<SurfaceMesh> surface_mesh<D>(const QuadraticMesh<D>&, const Features<D>&, const Geometry<D>&,    \
                                                  const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
