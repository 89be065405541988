// Nodes of inner edges are moved by distortion: no element becomes worse than the worst one around, and all stay
// certified.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.validity;
import camber.crossing;
import camber.operation;
import camber.adapt;

#include "bowed.hpp"
#include "dice.hpp"
#include "domains.hpp"
#include "exact_oracle.hpp"
#include "operation_runs.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

constexpr SmoothOptions by_distortion{.target_quality = 1, .nodes = SmoothedNodes::distortion};

template <int D>
double quality_of(const Adaptation<D>& r, ElementId e) {
    return quality_of_shape(shape_of(r, e), D);
}
struct Qualities {
    double worst = std::numeric_limits<double>::infinity(), mean = 0;
};
template <int D>
Qualities qualities_of(const Adaptation<D>& r) {
    Qualities q;
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) {
        if (r.mesh.is_free(ElementId(e))) continue;
        const double quality = quality_of(r, ElementId(e));
        q.worst = std::min(q.worst, quality);
        q.mean += quality / static_cast<double>(r.mesh.element_count());
    }
    return q;
}

/// Compares the elements whose nodes moved. The worst of them is no worse than before, and nothing else changes.
template <int D>
void expect_no_worse(const Adaptation<D>& before, const Adaptation<D>& after) {
    RC_ASSERT(after.mesh.points == before.mesh.points);
    RC_ASSERT(after.mesh.elements == before.mesh.elements);
    RC_ASSERT(after.mesh.facets == before.mesh.facets);
    const auto moved = [&](EdgeId e) { return !(after.mesh.nodes[e] == before.mesh.nodes[e]); };
    double worst_before = std::numeric_limits<double>::infinity();
    double worst_after = worst_before;
    std::vector<std::uint8_t> on_boundary(before.mesh.edges.size(), 0);
    for (std::size_t i = 0; i < before.mesh.elements.size(); ++i) {
        const ElementId e(i);
        if (before.mesh.is_free(e)) continue;
        bool touched = false;
        for (const EdgeId edge : before.mesh.edges_of[e]) touched |= moved(edge);
        for (int face = 0; face <= D; ++face)
            if (!before.mesh.face_neighbours[e][face].is_element())
                for (int k = 0; k < edges_per_simplex<D>; ++k)
                    if (local_edges<D>[k][0] != face && local_edges<D>[k][1] != face)
                        on_boundary[before.mesh.edges_of[e][k].index()] = 1;
        if (!touched) continue;
        RC_ASSERT(!before.mesh.elements.marks[e].has(Mark::required));
        const NodalSimplex<D> element{nodes_of(after.mesh, e)};
        const double bound = decide(NodalSimplex<D>{nodes_of(before.mesh, e)}, 0.1) == Verdict::valid ? 0.1 : 0.0;
        RC_ASSERT(decide(element, bound) == Verdict::valid);
        RC_ASSERT(oracle::answer<D>(element, 0) != oracle::Answer::invalid);
        worst_before = std::min(worst_before, quality_of(before, e));
        worst_after = std::min(worst_after, quality_of(after, e));
    }
    RC_ASSERT(worst_after >= worst_before * (1 - 1e-13));
    for (std::size_t e = 0; e < on_boundary.size(); ++e)
        if (on_boundary[e] != 0) RC_ASSERT(!moved(EdgeId(e)));
}

/// Nodes are displaced at random, so that most of them can be improved.
template <int D>
Adaptation<D> bowed_state(std::uint64_t seed, Vec<D>& stretch) {
    Dice dice(seed);
    BowedDomain<D> domain = bowed_domain<D>(domain_with_required<D>(seed), dice);
    stretch = domain.stretch;
    return std::move(domain.state);
}

template <int D>
void check_smoothing(const char* name, int trials) {
    property(name,
             [] {
                 const auto seed = *rc::gen::inRange<std::uint64_t>(1, 100000);
                 Vec<D> stretch;
                 const Adaptation<D> before = bowed_state<D>(seed, stretch);
                 Adaptation<D> after = before;
                 const NodeMoves moves = must(smooth_nodes(after, by_distortion, Execution{.threads = 2}));
                 RC_ASSERT(moves.moved <= moves.tried);
                 expect_no_worse(before, after);
                 // The result does not depend on the number of threads.
                 Adaptation<D> single_threaded = before;
                 must(smooth_nodes(single_threaded, by_distortion, Execution{.threads = 1}));
                 RC_ASSERT(single_threaded.mesh.nodes == after.mesh.nodes);
                 if (moves.moved > 0) {
                     const Qualities q = qualities_of(before);
                     const Qualities p = qualities_of(after);
                     RC_ASSERT(p.worst >= q.worst * (1 - 1e-13));
                     RC_ASSERT(p.mean > q.mean);
                     RC_ASSERT(after.mesh.stamp != before.mesh.stamp);
                     must(check_consistency(after.mesh, one_thread));
                 }
             },
             {.count = trials});
}

/// Displaced nodes return most of the way in a metric that does not require them.
template <int D>
void expect_gain(double least) {
    double before = 0, after = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Vec<D> stretch;
        Adaptation<D> r = bowed_state<D>(seed, stretch);
        const auto inner = [&] { return qualities_of(r).mean; };
        const double bowed = inner();
        must(smooth_nodes(r, {.target_quality = 1, .sweeps = 10}, one_thread));
        before += bowed / 6;
        after += inner() / 6;
    }
    CHECK(after - before > least);
    MESSAGE("mean quality ", before, " to ", after);
}

/// A straight mesh in a constant metric.
Adaptation<2> straight_state() {
    const LinearMesh<2> mesh = domain_with_required<2>(1);
    Buffer<LogMetric<2>> logs(mesh.points.size());
    const AdaptationGoal<2> goal{
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<2>>(std::move(logs)), one_thread)),
        {}};
    return must(begin_adaptation(mesh, must(unique_edges(mesh, one_thread)), {}, goal, one_thread));
}

}  // namespace

TEST_CASE("smoothing nodes by distortion keeps elements valid and no worse, 2D") {
    check_smoothing<2>("smoothing by distortion makes no element worse, 2D", 60);
}

TEST_CASE("smoothing nodes by distortion keeps elements valid and no worse, 3D") {
    check_smoothing<3>("smoothing by distortion makes no element worse, 3D", 20);
}

TEST_CASE("smoothing nodes by distortion raises the mean quality") {
    expect_gain<2>(0.01);
    expect_gain<3>(0.01);
}

TEST_CASE("smoothing by distortion is invariant under stretching of the mesh with its metric") {
    // The distortion measure is invariant under a stretching of the mesh with its metric. Powers of two leave only
    // rounding errors.
    Dice dice(3);
    LinearMesh<2> mesh = domain_with_required<2>(4);
    const auto smoothed = [&](double share) {
        LinearMesh<2> there = mesh;
        Buffer<Vec<2>> points(mesh.points.size());
        Buffer<LogMetric<2>> logs(points.size());
        for (std::size_t v = 0; v < points.size(); ++v) {
            points[v] = stretched<2>(mesh.points[v], {{1, share}});
            logs[v] = log_metric_of_sizes<2>({{1 + 0.2 * mesh.points[v][0], share * (1 + 0.2 * mesh.points[v][0])}});
        }
        there.points = std::move(points);
        const AdaptationGoal<2> goal{must(make_back_mesh(there, must(balls(there, one_thread)),
                                                         Column<LogMetric<2>>(std::move(logs)), one_thread)),
                                     {}};
        Adaptation<2> r = must(begin_adaptation(must(elevate(there, one_thread)), {}, goal, one_thread));
        Dice same(7);
        bow(r, Vec<2>{{1, share}}, same);
        must(smooth_nodes(r, by_distortion, one_thread));
        return r;
    };
    const Adaptation<2> plain = smoothed(1);
    const Adaptation<2> thin = smoothed(0x1p-20);
    double most = 0;
    for (std::size_t e = 0; e < plain.mesh.nodes.size(); ++e)
        most = std::max(most,
                        distance(plain.mesh.nodes[e].point, unstretched<2>(thin.mesh.nodes[e].point, {{1, 0x1p-20}})));
    CHECK(most < 1e-6);
}

TEST_CASE("node smoothing moves nothing in a straight mesh") {
    Adaptation<2> r = straight_state();
    CHECK(must(smooth_nodes(r, by_distortion, one_thread)).tried == 0);
}

TEST_CASE("node smoothing rejects options out of range") {
    Adaptation<2> r = straight_state();
    CHECK(!smooth_nodes(r, {.target_quality = 2}, one_thread));
}
