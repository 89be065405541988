module;
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.surface;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// Features and geometry of the boundary.
template <int D>
struct Described {
    Boundary<D> boundary;
    BoundaryReport report;
};
template <int D>
Outcome<Described<D>> described(const QuadraticMesh<D>& mesh, const config::Features& options,
                                const config::Geometry& geometry, const Execution& execution) {
    auto features = find_features(mesh.linear, mesh.edges,
                                  FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle}, execution);
    if (!features) return fail(features.error());
    auto made = make_geometry(geometry, mesh, *features, execution);
    if (!made) return fail(made.error());
    const BoundaryReport report{
        features->surface_edges, features->ridge_edges, features->corners, features->patch_count, {}, {}};
    return Described<D>{{std::move(*features), options.required_boundary, std::move(*made)}, report};
}

}  // namespace

template <int D>
Outcome<Boundary<D>> describe_boundary(Runner<D>& run) {
    auto made = run.step("surface", [&](const Execution& e) {
        return described(run.quadratic().mesh, run.config.features, run.config.geometry, e);
    });
    if (!made) return fail(made.error());
    run.tell(made->report);
    return std::move(made->boundary);
}

template Outcome<Boundary<2>> describe_boundary<2>(Runner<2>&);
template Outcome<Boundary<3>> describe_boundary<3>(Runner<3>&);

}  // namespace camber::run
