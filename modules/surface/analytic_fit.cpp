module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

/// To three digits.
std::string text(double number) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::general, 3);
    return {digits.data(), end.ptr};
}

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

/// "1, 2, 5", the first few of them.
std::string listed(const std::vector<Reference>& references) {
    constexpr std::size_t most = 12;
    std::string list;
    for (std::size_t i = 0; i < std::min(most, references.size()); ++i)
        list += (i > 0 ? ", " : "") + std::to_string(references[i]);
    return list + (references.size() > most ? ", …" : "");
}

/// Every reference has one surface, and facets of the mesh.
template <int D>
std::optional<Error> check_references(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry) {
    std::vector<Reference> given;
    given.reserve(geometry.surfaces.size());
    for (const auto& [reference, surface] : geometry.surfaces) given.push_back(reference);
    std::sort(given.begin(), given.end());
    if (const auto twice = std::adjacent_find(given.begin(), given.end()); twice != given.end())
        return Error{ErrorKind::usage, named(*twice) + " is given to two surfaces", {}, {}, "name each reference once"};
    const auto of_facets = sorted_once({mesh.facets.references.begin(), mesh.facets.references.end()});
    for (const Reference reference : given)
        if (!std::binary_search(of_facets.begin(), of_facets.end(), reference))
            return Error{ErrorKind::usage,
                         std::string("no boundary ") + simplex_name<D - 1> + " of the mesh has " + named(reference),
                         {},
                         {},
                         of_facets.empty() ? "it has none at all" : "it has " + listed(of_facets)};
    return {};
}

/// No surface is so large beside the mesh that its curvature drowns in rounding.
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
                     named(reference) + ": the radius of its " + name_of<D>(surface) + ", " + text(radius) +
                         ", is no radius for a boundary of size " + text(size),
                     {},
                     {},
                     "at most 1e8 times that size is taken; what is flatter is a plane"};
    }
    return {};
}

template <int D>
double longest_edge(const LinearMesh<D>& mesh, FacetId f) {
    double longest = 0;
    for (const auto& [i, j] : local_edges<D - 1>) {
        const auto& facet = mesh.facets.vertices[f];
        longest = std::fmax(longest, distance(mesh.points[facet[static_cast<std::size_t>(i)]],
                                              mesh.points[facet[static_cast<std::size_t>(j)]]));
    }
    return longest;
}

/// The vertex of a facet that is farthest from the facet's surface, of those that are too far.
template <int D>
Misfit misfit_of(const LinearMesh<D>& mesh, const AnalyticSurface<D>& surface, FacetId f) {
    const double allowed = fit_tolerance * longest_edge(mesh, f);
    Misfit worst;
    for (const VertexId v : mesh.facets.vertices[f]) {
        const double off = distance(mesh.points[v], closest_point<D>(surface, mesh.points[v]).point);
        if (off <= allowed) continue;
        const double far = std::isnan(off) ? std::numeric_limits<double>::infinity() : off;
        worst = worse(worst, {far, allowed, v, mesh.facets.references[f]});
    }
    return worst;
}

template <int D>
Error misfit_error(const AnalyticGeometry<D>& geometry, const Misfit& misfit) {
    const std::string surface = name_of<D>(*surface_of(geometry, misfit.reference));
    return Error{ErrorKind::usage,
                 "is " + text(misfit.distance) + " away from the " + surface + " of " + named(misfit.reference) +
                     ", where 10 % of the length of the edges there, " + text(misfit.allowed) +
                     ", is the most, but for few vertices",
                 {},
                 Entity{"vertex", misfit.vertex.index() + 1},
                 "no other is farther; give the " + surface + " that the mesh was made on, in its units"};
}

}  // namespace

template <int D>
Outcome<Done> check_fit(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry, const Execution& execution) {
    if (auto error = check_references(mesh, geometry)) return fail(std::move(*error));
    if (auto error = check_radii(mesh, geometry)) return fail(std::move(*error));
    using Fits = std::vector<BoundaryFit>;  // of each surface
    const auto accumulate = [&](Fits& fits, std::size_t f) {
        const Reference reference = mesh.facets.references[f];
        if (const auto* surface = surface_of(geometry, reference)) {
            const auto at = std::ranges::find(geometry.surfaces, reference, [](const auto& s) { return s.first; });
            fits[at - geometry.surfaces.begin()].add(misfit_of<D>(mesh, *surface, FacetId(f)));
        }
    };
    const auto join = [](Fits a, const Fits& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i].add(b[i]);
        return a;
    };
    const auto fits = reduce_each(execution, mesh.facets.size(), Fits(geometry.surfaces.size()), accumulate, join);
    if (!fits) return fail(fits.error());
    Misfit worst;
    for (const BoundaryFit& fit : *fits)
        if (const auto refused = fit.refused()) worst = worse(worst, *refused);
    if (worst.distance > 0) return fail(misfit_error(geometry, worst));
    return Done{};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Done> check_fit(const LinearMesh<D>&, const AnalyticGeometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
