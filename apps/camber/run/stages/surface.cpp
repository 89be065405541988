module;
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.surface;
import :report;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<Described<D>> surface_stage(const QuadraticMesh<D>& mesh, const config::Features& options,
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

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<Described<D>> surface_stage<D>(const QuadraticMesh<D>&, const config::Features&, \
                                                    const config::Geometry&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
