// What faces share is measured once: the same shapes as one by one.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "goals.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void same_shapes(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.7, dice);
    const Adaptation<D> r = begun(mesh, goal);
    const VertexId v(dice.below(mesh.points.size()));
    std::vector<ElementId> around;
    ball(r.mesh, v, around);
    ConeShapes<D> cones(r, goal);
    for (const ElementId e : around) cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
    for (int trial = 0; trial < 4; ++trial) {
        Vec<D> place = r.mesh.points[v];
        for (double& c : place.c) c += dice.uniform(-0.2, 0.2);
        const auto& metric = r.vertices.metrics[dice.below(r.vertices.metrics.size())];
        const VertexId without = trial < 2 ? VertexId{} : cones.vertices()[dice.below(cones.vertices().size())].vertex;
        double worst = std::numeric_limits<double>::infinity();
        for (const ElementId e : around)
            if (!without.valid() || local_vertex(r.mesh.elements.vertices[e], without) < 0)
                worst = std::min(worst,
                                 shape_with(r, e, local_vertex(r.mesh.elements.vertices[e], v), place, metric.measure));
        const double all = cones.worst_at({place, &metric}, -2, without);
        if (std::isfinite(worst))
            RC_ASSERT(std::abs(all - worst) < 1e-12);
        else
            RC_ASSERT(all == 0.0);  // none counts
        // With something that is asked for: the worst if it is above, otherwise something that is not.
        const double least = dice.uniform(0, 0.5);
        const double above = cones.worst_at({place, &metric}, least, without);
        RC_ASSERT((above > least) == (all > least));
        if (above > least) RC_ASSERT(above == all);
    }
}

}  // namespace

TEST_CASE("faces joined to a point have the shapes of their elements") {
    property("2D", [](std::uint64_t seed) { same_shapes<2>(seed); }, {.count = 100});
    property("3D", [](std::uint64_t seed) { same_shapes<3>(seed); }, {.count = 100});
}
