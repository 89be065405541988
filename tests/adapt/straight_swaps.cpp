// Swaps inside straight tetrahedra: the predicted quality equals that of ConeShapes.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

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

constexpr double close = 1e-12;

/// The minimum shape of the elements around an edge, joined to the best vertex around it; 0 if there is none.
double best_by_cones(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const Cavity<3>& cavity, VertexId a,
                     VertexId b) {
    ConeShapes<3> cones(r, goal);
    for (const ElementId e : cavity.elements)
        for (const VertexId v : {a, b}) cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
    double best = 0;
    for (const auto& corner : cones.vertices())
        if (corner.vertex != a && corner.vertex != b)
            best = std::max(best, cones.worst_at(cone_point(r, corner.vertex), best, corner.vertex));
    return best;
}

void expect_same_around_edge(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e, int k,
                             const std::vector<double>& shapes) {
    Cavity<3> cavity;
    cavity_of_edge(r.mesh, e, k, cavity);
    const bool is_worst = std::ranges::none_of(
        cavity.elements, [&](ElementId other) { return shapes[other.index()] < shapes[e.index()]; });
    EdgeRing ring;
    const EdgeRing::Walk walk = ring.walk(r.mesh, shapes, e, k);
    if (walk == EdgeRing::Walk::worse) RC_ASSERT(!is_worst);
    if (walk != EdgeRing::Walk::closed) return;
    RC_ASSERT(is_worst && cavity.facets.empty());
    std::vector<ElementId> walked(ring.elements().begin(), ring.elements().end());
    std::ranges::sort(walked);
    std::ranges::sort(cavity.elements);
    RC_ASSERT(walked == cavity.elements);
    const auto& [a, b] = r.mesh.edges[r.mesh.edges_of[e][k]];
    const double expected = best_by_cones(r, goal, cavity, a, b);
    const EdgeRing::Best best = ring.best(r, 0);
    RC_ASSERT(std::abs(best.worst - expected) < close);
    RC_ASSERT(!ring.best(r, best.worst + close).point.valid());
}

void expect_same_at_face(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e, int face) {
    const FaceNeighbour across = r.mesh.face_neighbours[e][face];
    if (!across.is_element()) return;
    const ElementId other = across.element();
    ConeShapes<3> cones(r, goal);
    for (int i = 0; i < 4; ++i)
        if (local_vertex(r.mesh.elements.vertices[e], r.mesh.elements.vertices[other][i]) >= 0) cones.add(other, i);
    const double expected = cones.worst_at(cone_point(r, r.mesh.elements.vertices[e][face]), 0);
    const double worst = worst_without_face(r, e, face, other, 0);
    RC_ASSERT((worst > 0) == (expected > 0));
    if (worst > 0) RC_ASSERT(std::abs(worst - expected) < close);
}

void check_swaps(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<3> mesh = random_domain<3>(seed);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.7, dice);
    const Adaptation<3> r = start_adaptation(mesh, goal);
    std::vector<double> shapes;
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) shapes.push_back(shape_of(r, ElementId(e)));
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) {
        for (int k = 0; k < edges_per_simplex<3>; ++k) expect_same_around_edge(r, goal, ElementId(e), k, shapes);
        for (int face = 0; face < 4; ++face) expect_same_at_face(r, goal, ElementId(e), face);
    }
}

}  // namespace

TEST_CASE("the predicted quality of a swap equals that of its straight tetrahedra") {
    property("3D", [](std::uint64_t seed) { check_swaps(seed); }, {.count = 10});
}
