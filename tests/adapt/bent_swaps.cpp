// Swaps inside curved tetrahedra: the predicted quality equals that of the elements computed one by one. New edges are
// bent by the closed form for accuracy.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <doctest/doctest.h>

#include "bowed.hpp"
#include "dice.hpp"
#include "domains.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.cavity;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr double close = 1e-9;

/// The offset of the node of an edge from the middle of its chord: stored, or computed for a new edge.
Vec<3> offset_between(const Adaptation<3>& r, const AdaptationGoal<3>& goal, VertexId a, VertexId b) {
    for (std::size_t e = 0; e < r.mesh.edges.size(); ++e)
        if (r.mesh.edges[e] == std::array{std::min(a, b), std::max(a, b)}) return offset_of(r.mesh, EdgeId(e));
    const std::array<Vec<3>, 1> chord{r.mesh.points[b] - r.mesh.points[a]};
    const std::array<EdgeEnds<3>, 1> ends{EdgeEnds<3>{{r.vertices.metrics[a].log_metric, r.vertices.gradients[a]},
                                                      {r.vertices.metrics[b].log_metric, r.vertices.gradients[b]}}};
    std::array<Vec<3>, 1> offset;
    accurate_offsets<3>(chord, ends, goal.accuracy, offset);
    return offset[0];
}

double shape_of_vertices(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const std::array<VertexId, 4>& v) {
    std::array<std::array<Vec<3>, 4>, 4> tangents;
    double squares = 0, density = 1;
    for (const auto& [i, j] : local_edges<3>) {
        const Vec<3> chord = r.mesh.points[v[j]] - r.mesh.points[v[i]];
        const Vec<3> offset = offset_between(r, goal, v[i], v[j]);
        tangents[i][j] = chord + 4.0 * offset;
        tangents[j][i] = 4.0 * offset - chord;
        squares += squares_between(r, r.vertices.metrics[v[i]], r.vertices.metrics[v[j]], chord, offset);
    }
    for (const VertexId of : v) density *= r.vertices.metrics[of].measure.density_root;
    return bent_shape<3>(tangents, density, squares);
}

/// The minimum shape of the elements after p replaces one of the vertices, without elements that have p already.
double worst_with(const Adaptation<3>& r, const AdaptationGoal<3>& goal, std::span<const ElementId> elements,
                  std::span<const VertexId> replaced, VertexId p) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements)
        for (const VertexId v : replaced) {
            std::array<VertexId, 4> corners = r.mesh.elements.vertices[e];
            const int at = local_vertex(corners, v);
            if (at < 0 || local_vertex(corners, p) >= 0) continue;
            corners[at] = p;
            worst = std::min(worst, shape_of_vertices(r, goal, corners));
        }
    return worst;
}

double worst_of(const Adaptation<3>& r, std::span<const ElementId> elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, bent_shape_of(r, e));
    return std::max(worst, least_bent_shape);
}

void expect_same_around_edge(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e, int k) {
    const std::vector<double> alike(r.mesh.elements.size(), 1.0);
    EdgeRing ring;
    if (ring.walk(r.mesh, alike, e, k) != EdgeRing::Walk::closed) return;
    const BentSwap found = best_around_edge(r, goal, ring, 0);
    double best = 0;
    for (const VertexId p : ring.around()) best = std::max(best, worst_with(r, goal, ring.elements(), ring.ends(), p));
    RC_ASSERT(found.point.valid() == (best > 0));
    if (!found.point.valid()) return;
    RC_ASSERT(std::abs(found.before - worst_of(r, ring.elements())) < close);
    RC_ASSERT(std::abs(found.after - best) < close);
    RC_ASSERT(!best_around_edge(r, goal, ring, (best + close) / found.before).point.valid());
}

void expect_same_at_face(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e, int face) {
    const FaceNeighbour across = r.mesh.face_neighbours[e][face];
    if (!across.is_element()) return;
    const std::array elements{e, across.element()};
    const VertexId p = r.mesh.elements.vertices[e][face];
    const BentSwap found = best_without_face(r, goal, e, std::span(&face, 1), 0);
    const auto outward = face_opposite<3>(face);
    std::array<VertexId, 3> shared;
    for (int i = 0; i < 3; ++i) shared[i] = r.mesh.elements.vertices[e][outward[i]];
    const double expected = worst_with(r, goal, std::span(elements).last(1), shared, p);
    RC_ASSERT(found.point.valid() == (expected > 0));
    if (!found.point.valid()) return;
    RC_ASSERT(found.point == p && found.beside == across.element());
    RC_ASSERT(std::abs(found.before - worst_of(r, elements)) < close);
    RC_ASSERT(std::abs(found.after - expected) < close);
}

void check_swaps(std::uint64_t seed) {
    Dice dice(seed);
    const BowedDomain<3> domain = bowed_domain(random_domain<3>(seed), dice);
    const std::size_t n = domain.state.mesh.elements.size();
    for (int i = 0; i < 12; ++i) {
        const ElementId e(dice.below(n));
        expect_same_around_edge(domain.state, domain.goal, e, static_cast<int>(dice.below(edges_per_simplex<3>)));
        expect_same_at_face(domain.state, domain.goal, e, static_cast<int>(dice.below(4)));
    }
}

}  // namespace

TEST_CASE("the predicted quality of a swap equals that of its curved tetrahedra") {
    property("3D", [](std::uint64_t seed) { check_swaps(seed); }, {.count = 10});
}
