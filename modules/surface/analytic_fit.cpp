module;
#include <algorithm>
#include <cmath>
#include <cstddef>
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
                     named(reference) + ": the radius of its " + name_of<D>(surface) + ", " + three_digits(radius) +
                         ", is no radius for a boundary of size " + three_digits(size),
                     {},
                     {},
                     "at most 1e8 times that size is taken; what is flatter is a plane"};
    }
    return {};
}

/// The rows of the table whose surfaces the facets at a vertex have, each once.
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
Error misfit_error(const std::pair<Reference, AnalyticSurface<D>>& row, const VertexFit& fit) {
    const std::string surface = name_of<D>(row.second);
    return Error{ErrorKind::input,
                 fit.text("the " + surface + " of " + named(row.first)),
                 {},
                 Entity{"vertex", fit.farthest.index() + 1},
                 "no other vertex is farther; give the " + surface + " that the mesh was made on, in its units"};
}

}  // namespace

template <int D>
Outcome<Done> check_fit(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry, const Execution& execution) {
    if (auto error = check_references(mesh, geometry)) return fail(std::move(*error));
    if (auto error = check_radii(mesh, geometry)) return fail(std::move(*error));
    const auto around = facet_balls(mesh, without_progress(execution));
    if (!around) return fail(around.error());
    using Fits = std::vector<VertexFit>;  // of each surface
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
    return fail(misfit_error<D>(geometry.surfaces[static_cast<std::size_t>(worst - fits->data())], *worst));
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Done> check_fit(const LinearMesh<D>&, const AnalyticGeometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
