module;
#include <utility>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.surface;
import camber.validity;
import camber.repair;
import :report;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<State<D>> adopt_stage(State<D> state, const config::Features& options, Report& report,
                              const Execution& execution) {
    const QuadraticMesh<D>& mesh = *state.quadratic();
    auto features = find_features(mesh.linear, mesh.edges,
                                  FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle}, execution);
    if (!features) return fail(features.error());
    report.boundary = BoundaryReport{
        features->surface_edges, features->ridge_edges, features->corners, features->patch_count, {}, {}};
    state.required = options.required_boundary;
    state.propose(own_proposal(mesh, features->edge_kinds, state.required));
    state.features = std::move(*features);
    state.adopted = true;
    return state;
}

template Outcome<State<2>> adopt_stage<2>(State<2>, const config::Features&, Report&, const Execution&);
template Outcome<State<3>> adopt_stage<3>(State<3>, const config::Features&, Report&, const Execution&);

}  // namespace camber::run
