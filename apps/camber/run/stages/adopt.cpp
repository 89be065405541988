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
import :runner;
import :state;
import :steps;

namespace camber::run {

namespace {

/// The nodes of a mesh that was read with its curves as a plan: its boundary's features tell what is given.
template <int D>
struct Adopted {
    OwnNodes<D> own;
    Proposal<D> proposal;
    BoundaryReport report;
};
template <int D>
Outcome<Adopted<D>> own_nodes(const QuadraticMesh<D>& mesh, const config::Features& options,
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

}  // namespace

template <int D>
Outcome<Done> adopt_own_nodes(Runner<D>& run) {
    if (run.quadratic().planned()) return Done{};
    auto made = run.step("features",
                         [&](const Execution& e) { return own_nodes(run.quadratic().mesh, run.config.features, e); });
    if (!made) return fail(made.error());
    run.tell(made->report);
    run.quadratic().plan = Plan<D>{std::move(made->own), std::move(made->proposal)};
    return Done{};
}

template Outcome<Done> adopt_own_nodes<2>(Runner<2>&);
template Outcome<Done> adopt_own_nodes<3>(Runner<3>&);

}  // namespace camber::run
