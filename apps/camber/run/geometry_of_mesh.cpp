module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.bezier;
import camber.soundness;
import camber.surface;
import :stages;

namespace camber::run {

namespace {

constexpr const char* where = "/geometry/mesh";

template <int D>
Outcome<Surrogate<D>> boundary_of(LinearMesh<D> mesh, const FeatureOptions<D>& features_by,
                                  const Execution& execution) {
    const auto sound = prepare(std::move(mesh), part_of(execution, 0, 0.2));
    if (!sound) return fail(sound.error());
    const auto edges = unique_edges(sound->mesh, part_of(execution, 0.2, 0.3));
    if (!edges) return fail(edges.error());
    const auto features = find_features(sound->mesh, *edges, features_by, part_of(execution, 0.3, 0.5));
    if (!features) return fail(features.error());
    return build_surrogate(sound->mesh, *edges, *features, SurrogateOptions{}, part_of(execution, 0.5, 1));
}

/// With the mesh's own curves, where it has them.
template <int D>
Outcome<Surrogate<D>> boundary_of(QuadraticMesh<D> mesh, const FeatureOptions<D>& features_by,
                                  const Execution& execution) {
    const auto sound = prepare(std::move(mesh), part_of(execution, 0, 0.3));
    if (!sound) return fail(sound.error());
    const auto& [linear, edges, nodes] = sound->mesh;
    const auto features = find_features(linear, edges, features_by, part_of(execution, 0.3, 0.5));
    if (!features) return fail(features.error());
    auto smooth = build_surrogate(linear, edges, *features, SurrogateOptions{}, part_of(execution, 0.5, 0.7));
    if (!smooth) return smooth;
    auto curved = with_curves<D>(std::move(*smooth), linear, edges, *features, nodes.view(), StraightGeometry<D>{},
                                 SurrogateOptions{}, part_of(execution, 0.7, 1));
    if (!curved) return fail(curved.error());
    return std::move(curved->surrogate);
}

template <int D>
Outcome<Done> check_references(const Surrogate<D>& surrogate, const LinearMesh<D>& mesh) {
    std::vector<Reference> known(surrogate.references.begin(), surrogate.references.end());
    std::ranges::sort(known);
    known.erase(std::ranges::unique(known).begin(), known.end());
    for (const Reference reference : mesh.facets.references)
        if (!std::ranges::binary_search(known, reference))
            return fail(ErrorKind::usage,
                        fmt::format("no boundary {} of that mesh has reference {}", simplex_name<D - 1>, reference),
                        where, {}, "give a mesh whose boundary has the references of this one");
    return Done{};
}

/// True if a point lies between a straight facet of the geometry's mesh and the surface over it, as vertices do that
/// went only a part of their way to the surface.
template <int D>
bool is_below_surface(const Surrogate<D>& surrogate, const SurfacePoint<D>& foot, const Vec<D>& point) {
    constexpr double slack = 1.1;  // the facet is not straight below the foot
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
        Misfit worst;
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
                fmt::format("is {:.3g} away from the boundary of the geometry's mesh, where 10 % of the length of the "
                            "edges there, {:.3g}, is the most, but for few vertices",
                            worst->distance, worst->allowed),
                where, Entity{"vertex", worst->vertex.index() + 1},
                "no other is farther; give a mesh of the same body, in the same place and units");
}

}  // namespace

template <int D>
Outcome<Geometry<D>> geometry_of_mesh(const AnyMesh& other, const FeatureOptions<D>& features_by,
                                      const LinearMesh<D>& mesh, MisfitPolicy misfits, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh& of) -> Outcome<Geometry<D>> {
            if constexpr (Mesh::dimension != D) {
                return fail(ErrorKind::usage,
                            fmt::format("is a mesh in {}D, the one to curve in {}D", Mesh::dimension, D), where, {},
                            "give one of the same dimension");
            } else {
                auto surrogate = boundary_of<D>(of, features_by, part_of(execution, 0, 0.8));
                if (!surrogate) return fail(surrogate.error());
                if (auto known = check_references(*surrogate, mesh); !known) return fail(known.error());
                Geometry<D> geometry(PrescribedSurrogate<D>{*surrogate});
                if (misfits == MisfitPolicy::accepted) return geometry;
                auto fits = check_fit(geometry, *surrogate, mesh, part_of(execution, 0.8, 1));
                if (!fits) return fail(fits.error());
                return geometry;
            }
        },
        other);
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<Geometry<D>> geometry_of_mesh<D>(const AnyMesh&, const FeatureOptions<D>&, const LinearMesh<D>&, \
                                                      MisfitPolicy, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
