module;
#include <optional>
#include <utility>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.repair;
import camber.soundness;
import camber.surface;
import camber.validity;
import :boundary;
import :curve_input;
import :curve_mesh;
import :goal;
import :guide;
import :propose;

namespace camber {

namespace {

/// A proposal, judged and repaired.
template <int D>
struct JudgedAndRepaired {
    Validation<D> before;
    Repaired<D> repaired;
};
template <int D>
Outcome<JudgedAndRepaired<D>> repair_proposal(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                              const ProposedCurves<D>& proposed, const CurveMeshOptions& options,
                                              const Around& around) {
    const auto judged = run_step(around, "validate", [&](const Execution& e) {
        return validate(mesh, proposed.curved.proposal, options.repair.min_scaled_jacobian, e);
    });
    if (!judged) return fail(judged.error());
    auto repaired = run_step(around, "relax", [&](const Execution& e) -> Outcome<Repaired<D>> {
        const WantedNodes<D> wanted{proposed.curved, proposed.input.shells, proposed.input.extended,
                                    edge_options(options.curve).aim, proposed.field ? &*proposed.field : nullptr};
        const auto guide = make_guide<D>(*judged, wanted, &boundary, options.repair.method, part_of(e, 0, 0.05));
        if (!guide) return fail(guide.error());
        auto repaired = repair_or_straighten(*judged, *guide, options.repair, part_of(e, 0.05, 1));
        if (!repaired) return repaired;
        auto uncrossed = uncross_walls(repaired->judged, *guide, options.repair, without_progress(e));
        if (!uncrossed) return fail(uncrossed.error());
        if (uncrossed->moved.nodes == 0) return repaired;
        repaired->judged = std::move(uncrossed->judged);
        return with_all_changes(*judged, std::move(*repaired));
    });
    if (!repaired) return fail(repaired.error());
    return JudgedAndRepaired<D>{judged->validation(), std::move(*repaired)};
}

}  // namespace

template <int D>
Outcome<CurvedMesh<D>> curve_mesh(LinearMesh<D> given, const MeshGoal<D>& goal, const CurveMeshOptions& options,
                                  const Around& around) {
    auto sound = run_step(around, "prepare", [&](const Execution& e) { return prepare(std::move(given), e); });
    if (!sound) return fail(sound.error());
    const auto mesh = run_step(around, "elevate", [&](const Execution& e) { return elevate(sound->mesh, e); });
    if (!mesh) return fail(mesh.error());
    const auto boundary = run_step(around, "surface", [&](const Execution& e) {
        return find_boundary(mesh->linear, mesh->edges, goal.geometry, goal.boundary, e);
    });
    if (!boundary) return fail(boundary.error());
    const auto proposed =
        propose_curves<D>({*mesh, NodesOf::elevation, *boundary}, goal.metric, goal.solution, options.curve, around);
    if (!proposed) return fail(proposed.error());
    auto made = repair_proposal(*mesh, *boundary, *proposed, options, around);
    if (!made) return fail(made.error());
    const JudgedProposal<D>& after = made->repaired.judged;
    return CurvedMesh<D>{
        commit_uncertified(after).mesh, std::move(made->before),   after.validation(),
        proposed->curved.statistics,    made->repaired.statistics, remaining_but_for_shape(made->repaired),
        std::move(sound->notices)};
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<CurvedMesh<D>> curve_mesh<D>(LinearMesh<D>, const MeshGoal<D>&, const CurveMeshOptions&, \
                                                  const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
