module;
#include <array>
#include <cstddef>
#include <utility>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.surface;
import camber.validity;
import :report;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<Adopted<D>> adopt_stage(const QuadraticMesh<D>& mesh, const config::Features& options,
                                const Execution& execution) {
    auto features = find_features(mesh.linear, mesh.edges,
                                  FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle}, execution);
    if (!features) return fail(features.error());
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const bool straight = mesh.mid_nodes[e].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
        const bool volume = features->edge_kinds[e] == EdgeKind::volume;
        changes[e] = straight ? EdgeChange::straight : volume ? EdgeChange::optimised : EdgeChange::projected;
    }
    Proposal<D> proposal{mesh.linear.points, mesh.mid_nodes,
                         held_kinds(mesh, features->edge_kinds, options.required_boundary), std::move(changes)};
    const BoundaryReport report{
        features->surface_edges, features->ridge_edges, features->corners, features->patch_count, {}, {}};
    return Adopted<D>{{std::move(*features)}, std::move(proposal), report};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Adopted<D>> adopt_stage<D>(const QuadraticMesh<D>&, const config::Features&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
