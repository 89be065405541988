module;
#include <span>
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

template <int D>
FeatureOptions<D> by_angle(const config::Features& options) {
    return {.ridge_angle_degrees = options.ridge_angle};
}
/// A mesh that was remeshed lists all its breaks; its new facets may turn where the surface does not break.
template <int D>
constexpr FeatureOptions<D> listed_breaks{.ridge_angle_degrees = 180, .corner_angle_degrees = 180};

/// Features and geometry of the boundary.
template <int D>
struct Described {
    Boundary<D> boundary;
    BoundaryReport report;
};
template <int D>
Outcome<Described<D>> described(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                std::span<const LagrangeNode<D>> curves, const Runner<D>& run,
                                const Execution& execution) {
    const config::Features& options = run.config.features;
    const Inherited<D>* const inherited = run.state.inherited ? &*run.state.inherited : nullptr;
    auto features =
        find_features(mesh, edges, inherited ? listed_breaks<D> : by_angle<D>(options), part_of(execution, 0, 0.3));
    if (!features) return fail(features.error());
    auto made = inherited ? MadeGeometry<D>{inherited->geometry}
                          : make_geometry(run.config.geometry, run.cad, mesh, edges, *features, curves,
                                          part_of(execution, 0.3, 1));
    if (!made) return fail(made.error());
    const BoundaryReport report{features->surface_edges,
                                features->ridge_edges,
                                features->corners,
                                features->patch_count,
                                {},
                                {},
                                {},
                                made->cad};
    return Described<D>{{std::move(*features), options.required_boundary, std::move(made->geometry)}, report};
}

}  // namespace

template <int D>
Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                       std::span<const LagrangeNode<D>> curves) {
    auto made = run.step("surface", [&](const Execution& e) { return described(mesh, edges, curves, run, e); });
    if (!made) return fail(made.error());
    run.tell(made->report);
    return std::move(made->boundary);
}

template Outcome<Boundary<2>> describe_boundary<2>(Runner<2>&, const LinearMesh<2>&, const EdgeSet<2>&,
                                                   std::span<const LagrangeNode<2>>);
template Outcome<Boundary<3>> describe_boundary<3>(Runner<3>&, const LinearMesh<3>&, const EdgeSet<3>&,
                                                   std::span<const LagrangeNode<3>>);

}  // namespace camber::run
