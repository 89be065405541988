// A whole pipeline in memory: a shell between two spheres, curved by its own metric and its own surface, repaired,
// committed.
#include <cstdio>
#include <cstdlib>
#include <utility>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.shapes;
import camber.surface;
import camber.optimisation;
import camber.curving;
import camber.repair;

using namespace camber;

template <class T>
static T must(Outcome<T> outcome) {
    if (outcome) return std::move(*outcome);
    std::fprintf(stderr, "%s\n", describe(outcome.error()).c_str());
    std::exit(1);
}

int main() {
    const Execution all;
    const auto mesh =
        must(elevate(must(generate(ShellOptions<3>{.outer_radius = 2, .inner_size = 0.5, .outer_size = 0.6})), all));
    const auto features = must(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, all));
    const Geometry<3> geometry = must(build_surrogate(mesh.linear, mesh.edges, features, SurrogateOptions{}, all));
    const Column<LagrangeNode<3>> boundary = must(boundary_nodes(mesh, features, geometry, all));
    const auto ball = must(balls(mesh.linear, all));
    const auto shell = must(shells(mesh.edges, all));
    const auto back =
        must(make_back_mesh<3>(mesh.linear, ball, must(natural_log_metrics(mesh.linear, ball, all)), all));
    const auto curved = must(curve<3>(mesh, features.edge_kinds, boundary, shell, back, CurveOptions{}, all));
    const auto wanted = must(validate(mesh, curved.proposal, 0.2, all));
    const Validation<3>& before = wanted.validation();
    const RepairGuide<3> guide{shell, [&](EdgeId e) { return curved.proposal.mid_nodes[e]; },
                               edge_models(CurvingAim::accuracy, mesh, curved.proposal.mid_nodes, shell, back)};
    const auto repaired = must(repair(wanted, guide, RepairOptions{.min_scaled_jacobian = 0.2}, all));
    const auto result = must(commit(repaired.judged)).mesh;
    const Validation<3>& after = repaired.judged.validation();
    std::printf("%zu tetrahedra, %zu edges: %zu of them below 0.2 when curved, %zu now; the smallest has %.3f\n",
                result.linear.elements.size(), result.edges.size(), before.invalid + before.undecided,
                after.invalid + after.undecided, after.smallest);
    return after.all_valid() ? 0 : 1;
}
