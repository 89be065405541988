module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// With the centroid and the middles of edges.
constexpr int facet_degree = 6, edge_samples = 10;

/// Things by what they lie on, those on nothing that is asked for left out.
template <int D, class Wanted>
auto sorted_by_entity(const Buffer<GeometryEntity>& entities, Wanted&& wanted) {
    using Key = decltype(place_in_list(GeometryEntity{}));
    std::map<Key, typename OnEntities<D>::Entity> sorted;
    for (std::size_t i = 0; i < entities.size(); ++i) {
        if (!wanted(entities[i])) continue;
        auto& entry = sorted[place_in_list(entities[i])];
        entry.entity = entities[i];
        entry.pieces.push_back(static_cast<std::uint32_t>(i));
    }
    std::vector<typename OnEntities<D>::Entity> list;
    list.reserve(sorted.size());
    for (auto& [key, entry] : sorted) list.push_back(std::move(entry));
    return list;
}

/// The points of a prescribed surface next to those of a curved facet. The straight facet has others: beside a ridge it
/// may lie where the domain ends, and the surface goes on there.
template <int D>
void project_curved(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry, const GeometryEntity& entity,
                    const FacetSite<D>& site, std::span<Vec<D>> out) {
    constexpr const auto& lattice = facet_lattice<facet_degree, D>;
    const auto shape = bezier_form<D - 1, D>(mesh.linear.points, mesh.mid_nodes.view(),
                                             mesh.linear.facets.vertices[site.id], mesh.edges.of_facets[site.id]);
    for (std::size_t k = 0; k < lattice.size(); ++k)
        out[k] = geometry->project({.reference = site.reference, .entity = entity}, shape.point(lattice[k])).point;
}

}  // namespace

template <int D>
Outcome<OnEntities<D>> find_on_entities(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                        const Geometry<D>& geometry, const Execution& execution) {
    if (features.patches.size() != mesh.linear.facets.size() || features.edge_kinds.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features are not of this mesh");
    auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    OnEntities<D> found{{}, {}, std::move(*shells)};
    auto of_facets = map_each(part_of(execution, 0, 0.5), mesh.linear.facets.size(),
                              [&](std::size_t f) { return geometry->surface_at(facet_site(mesh.linear, FacetId(f))); });
    if (!of_facets) return fail(of_facets.error());
    found.surfaces = sorted_by_entity<D>(*of_facets, [](const GeometryEntity&) { return true; });
    if constexpr (D == 3) {
        auto of_edges = map_each(part_of(execution, 0.5, 1), mesh.edges.size(), [&](std::size_t e) {
            return found.shells[e].empty() ? GeometryEntity{} : geometry->entity_at_edge(found.site(mesh, features, e));
        });
        if (!of_edges) return fail(of_edges.error());
        found.curves = sorted_by_entity<D>(
            *of_edges, [](const GeometryEntity& entity) { return entity.kind == GeometryKind::curve; });
    }
    return found;
}

template <int D>
Outcome<GeometrySamples<D>> samples_over(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                         const Geometry<D>& geometry, const Execution& execution) {
    constexpr const auto& lattice = facet_lattice<facet_degree, D>;
    constexpr std::size_t n = lattice.size();
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        const auto on = find_on_entities(mesh, features, geometry, part_of(execution, 0, 0.3));
        if (!on) return fail(on.error());
        GeometrySamples<D> samples;
        const auto take = [&](const auto& entity, std::size_t per_piece, const Execution& part, auto&& sample) {
            samples.begin(entity.entity);
            const std::size_t begin = samples.points.size(), all = begin + entity.pieces.size() * per_piece;
            samples.points.resize(all);
            samples.weights.resize(all);
            samples.near.resize(all);
            samples.entities.back().end = all;
            return each(part, entity.pieces.size(),
                        [&](std::size_t i) { sample(entity.pieces[i], begin + i * per_piece); });
        };
        for (const auto& entity : on->surfaces) {
            if (entity.entity.kind == GeometryKind::none) continue;
            auto done = take(entity, n, without_progress(execution), [&](std::size_t f, std::size_t at) {
                const FacetSite<D> site = facet_site(mesh.linear, FacetId(f));
                const double weight = straight_measure(site) / n;
                const auto points = std::span(samples.points).subspan(at, n);
                if (geometry->prescribes(site.reference))
                    project_curved(mesh, geometry, entity.entity, site, points);
                else
                    (void)geometry->points_over(site, lattice, points);
                for (std::size_t k = at; k < at + n; ++k) {
                    samples.weights[k] = weight;
                    samples.near[k] = FacetId(f);
                }
            });
            if (!done) return fail(done.error());
        }
        for (const auto& entity : on->curves) {
            auto done = take(entity, edge_samples, without_progress(execution), [&](std::size_t e, std::size_t at) {
                const EdgeSite<D> site = on->site(mesh, features, e);
                const double length = distance(site.ends[0], site.ends[1]);
                for (std::size_t k = 0; k < edge_samples; ++k) {
                    const double t = (static_cast<double>(k) + 0.5) / edge_samples;
                    samples.points[at + k] = geometry->on_edge(site, (1 - t) * site.ends[0] + t * site.ends[1]).point;
                    samples.weights[at + k] = length / edge_samples;
                    samples.near[at + k] = site.facets.front().id;
                }
            });
            if (!done) return fail(done.error());
        }
        return samples;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<OnEntities<D>> find_on_entities<D>(const QuadraticMesh<D>&, const Features<D>&,  \
                                                        const Geometry<D>&, const Execution&);        \
    template Outcome<GeometrySamples<D>> samples_over<D>(const QuadraticMesh<D>&, const Features<D>&, \
                                                         const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
