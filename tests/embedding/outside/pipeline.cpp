// A whole pipeline in memory by one call: a shell between two spheres is curved with its natural metric and surrogate,
// repaired and committed.
#include <cstdio>
#include <utility>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.shapes;
import camber.recipes;

using namespace camber;

static Outcome<bool> pipeline(const StepWrapper& around) {
    const auto mesh = generate(ShellOptions<3>{.outer_radius = 2, .inner_size = 0.5, .outer_size = 0.6});
    if (!mesh) return fail(mesh.error());
    const auto curved = curve_mesh<3>(as_mesh(*mesh), {}, {.repair = {.min_scaled_jacobian = 0.2}}, around);
    if (!curved) return fail(curved.error());
    const run::ValidityReport &before = *curved->report.validity_before, &after = *curved->report.validity;
    std::printf("%zu tetrahedra, %zu edges: %zu elements below 0.2 when curved, %zu now; the smallest has %.3f\n",
                count_elements(curved->mesh), curved->mesh.entities.edges.size(), before.below_bound, after.below_bound,
                after.smallest);
    return curved->report.meets_requirements();
}

int main() {
    const auto right = pipeline(without_wrapper(Execution{}));
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
