module;
#include <array>
#include <cstddef>
#include <utility>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.soundness;
import camber.optimisation;
import camber.surface;

namespace camber {

template <int D>
Proposal<D> own_proposal(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& boundary_kinds,
                         RequiredBoundary required) {
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const bool straight = mesh.mid_nodes[e].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
        const bool volume = boundary_kinds[e] == EdgeKind::volume;
        changes[e] = straight ? EdgeChange::straight : volume ? EdgeChange::optimised : EdgeChange::projected;
    }
    return {mesh.linear.points, mesh.mid_nodes, held_kinds(mesh, boundary_kinds, required), std::move(changes)};
}

template <int D>
Outcome<RepairedMesh<D>> repair_mesh(QuadraticMesh<D> mesh, const MeshRepairOptions& options,
                                     const Execution& execution) {
    auto prepared = prepare(std::move(mesh), execution);
    if (!prepared) return fail(prepared.error());
    const QuadraticMesh<D>& sound = prepared->mesh;
    const auto features = find_features(
        sound.linear, sound.edges, FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle_degrees}, execution);
    if (!features) return fail(features.error());
    const auto judged = validate(sound, own_proposal(sound, features->edge_kinds, options.required_boundary),
                                 options.repair.min_scaled_jacobian, execution);
    if (!judged) return fail(judged.error());
    RepairGuide<D> guide;
    if (needs_models(options.repair.method)) {
        const auto around = shells(sound.edges, execution);
        if (!around) return fail(around.error());
        auto made = own_guide(*judged, *around, execution);
        if (!made) return fail(made.error());
        guide = std::move(*made);
    }
    auto repaired = repair_within(*judged, guide, options.repair, execution);
    if (!repaired) return fail(repaired.error());
    const JudgedProposal<D>& after = repaired->judged;
    return RepairedMesh<D>{commit_uncertified(after).mesh,
                           judged->validation(),
                           after.validation(),
                           repaired->statistics,
                           boundary_shift(sound, after.proposal()),
                           remaining(*repaired),
                           std::move(prepared->notices)};
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Proposal<D> own_proposal<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&, RequiredBoundary); \
    template Outcome<RepairedMesh<D>> repair_mesh<D>(QuadraticMesh<D>, const MeshRepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
