module;
#include <optional>
#include <span>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
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

/// The same where surfaces are prescribed: the boundary's nodes are brought onto them.
template <int D>
Outcome<Plan<D>> own_nodes_on_geometry(Runner<D>& run) {
    const QuadraticMesh<D>& mesh = run.quadratic().mesh;
    const std::span<const LagrangeNode<D>> curves(mesh.mid_nodes.data(), mesh.mid_nodes.size());
    auto boundary = describe_boundary(run, mesh.linear, mesh.edges, curves);
    if (!boundary) return fail(boundary.error());
    return run.step("nodes", [&](const Execution& e) -> Outcome<Plan<D>> {
        const Column<EdgeKind>& kinds = boundary->features.edge_kinds;
        auto nodes = own_nodes_on(boundary->geometry, kinds, mesh, boundary->required, e);
        if (!nodes) return fail(nodes.error());
        Proposal<D> proposal = own_proposal(mesh, kinds, boundary->required);
        proposal.mid_nodes = std::move(*nodes);
        return Plan<D>{OwnNodes<D>{boundary->features, *boundary}, std::move(proposal)};
    });
}

bool prescribes(const config::Geometry& geometry) {
    return std::holds_alternative<config::Cad>(geometry) || std::holds_alternative<config::Analytic>(geometry) ||
           std::holds_alternative<config::FilePath>(geometry);
}

}  // namespace

template <int D>
Outcome<Done> adopt_own_nodes(Runner<D>& run) {
    if (run.quadratic().planned()) return Done{};
    if (prescribes(run.config.geometry)) {
        auto plan = own_nodes_on_geometry(run);
        if (!plan) return fail(plan.error());
        run.quadratic().plan = std::move(*plan);
        return Done{};
    }
    auto made = run.step("features",
                         [&](const Execution& e) { return own_nodes(run.quadratic().mesh, run.config.features, e); });
    if (!made) return fail(made.error());
    run.report(made->report);
    run.quadratic().plan = Plan<D>{std::move(made->own), std::move(made->proposal)};
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> adopt_own_nodes<D>(Runner<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
