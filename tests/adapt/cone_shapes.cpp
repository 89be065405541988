// ConeShapes measures shared faces once. Its shapes equal those of the elements computed one by one.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "goals.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_cone_shapes(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.7, dice);
    const Adaptation<D> r = start_adaptation(mesh, goal);
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
            RC_ASSERT(all == 0.0);  // no element is counted
        // With a lower limit: the minimum if it is above the limit, otherwise a value that is not above it.
        const double least = dice.uniform(0, 0.5);
        const double above = cones.worst_at({place, &metric}, least, without);
        RC_ASSERT((above > least) == (all > least));
        if (above > least) RC_ASSERT(above == all);
    }
}

/// In a constant metric edges of degree 2 stay straight. Shapes of existing and candidate elements and lengths are
/// those of degree 1.
template <int D>
void check_constant_metric(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    Vec<D> sizes;
    for (double& h : sizes.c) h = dice.uniform(0.3, 1);
    Buffer<LogMetric<D>> logs(mesh.points.size(), log_metric_of_sizes<D>(sizes, dice.rotation<D>()));
    const AdaptationGoal<D> goal{
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<D>>(std::move(logs)), one_thread)),
        {}};
    const Adaptation<D> straight = start_adaptation(mesh, goal);
    const Adaptation<D> curved = must(begin_adaptation(must(elevate(mesh, one_thread)), {}, goal, one_thread));
    const VertexId v(dice.below(mesh.points.size())), p(dice.below(mesh.points.size()));
    std::vector<ElementId> around;
    ball(straight.mesh, v, around);
    ConeShapes<D> one(straight, goal), two(curved, goal);
    for (const ElementId e : around) {
        const int opposite = local_vertex(mesh.elements.vertices[e], v);
        one.add(e, opposite);
        two.add(e, opposite);
        RC_ASSERT(std::abs(bent_shape_of(curved, e) - straight_shape_of(straight, e)) < 1e-9);
    }
    const double shape = one.worst_at(cone_point(straight, p), -2, p),
                 other = two.worst_at(cone_point(curved, p), -2, p);
    RC_ASSERT(std::abs(std::max(shape, 0.0) - std::max(other, 0.0)) < 1e-9);
    for (std::size_t i = 0; i < one.vertices().size(); ++i)
        RC_ASSERT(std::abs(one.length_to(i) - two.length_to(i)) < 1e-9 * (1 + one.length_to(i)));
}

}  // namespace

TEST_CASE("cone shapes equal the shapes of the elements computed one by one") {
    property("2D", [](std::uint64_t seed) { check_cone_shapes<2>(seed); }, {.count = 100});
    property("3D", [](std::uint64_t seed) { check_cone_shapes<3>(seed); }, {.count = 100});
}

TEST_CASE("shapes and lengths in a constant metric are the same in degrees 1 and 2") {
    property("2D", [](std::uint64_t seed) { check_constant_metric<2>(seed); }, {.count = 100});
    property("3D", [](std::uint64_t seed) { check_constant_metric<3>(seed); }, {.count = 100});
}
