module;
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.repair;
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
    Proposal<D> proposal = own_proposal(mesh, features->edge_kinds, options.required_boundary);
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
