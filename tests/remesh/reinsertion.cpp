// Vertices put in again where they are: nodes go to their targets, or towards them, and nothing else changes.
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
import camber.dynamic;
import camber.surface;
import camber.validity;
import camber.crossing;
import camber.remesh;

#include "bowed.hpp"
#include "dice.hpp"
#include "operation_runs.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
std::vector<std::uint8_t> edges_on_boundary(const DynamicMesh<D>& mesh) {
    std::vector<std::uint8_t> on(mesh.edges.size(), 0);
    for (std::size_t i = 0; i < mesh.elements.size(); ++i) {
        if (mesh.is_free(ElementId(i))) continue;
        for (int face = 0; face <= D; ++face)
            for (int k = 0; k < edges_per_simplex<D>; ++k)
                if (!mesh.across[i][face].is_element() && local_edges<D>[k][0] != face && local_edges<D>[k][1] != face)
                    on[mesh.edges_of[i][k].index()] = 1;
    }
    return on;
}

/// Where the goal has the node of an edge.
template <int D>
Vec<D> target_of(const Remeshing<D>& r, const RemeshingGoal<D>& goal, VertexId a, VertexId b) {
    const Vec<D>& p = r.mesh.points[a];
    const Vec<D>& q = r.mesh.points[b];
    if (goal.search && q.c < p.c) return target_of(r, goal, b, a);
    if (goal.search)
        return minimise_edge<D>(goal.field, p, q, r.metrics[a].back, goal.search->rules, goal.search->options)
            .node.point;
    const Vec<D> chord = q - p;
    const EdgeEnds<D> ends{{r.metrics[a].log_metric, r.gradients[a]}, {r.metrics[b].log_metric, r.gradients[b]}};
    Vec<D> offset;
    accurate_offsets<D>({&chord, 1}, {&ends, 1}, goal.accuracy, {&offset, 1});
    return midpoint(p, q) + offset;
}

/// Nodes of the inner edges by their ends, which reinsertion keeps while the numbers of edges may change.
template <int D>
struct InnerNode {
    VertexId a, b;
    Vec<D> node;
    friend bool operator==(const InnerNode&, const InnerNode&) = default;
};
template <int D>
std::vector<InnerNode<D>> inner_nodes(const Remeshing<D>& r, int side) {
    const auto on = edges_on_boundary(r.mesh);
    std::vector<InnerNode<D>> nodes;
    for (std::size_t e = 0; e < on.size(); ++e)
        if (!r.mesh.is_free(EdgeId(e)) && on[e] == side)
            nodes.push_back({r.mesh.edges[e][0], r.mesh.edges[e][1], r.mesh.nodes[e].point});
    std::ranges::sort(nodes, [](const auto& x, const auto& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    return nodes;
}
template <int D>
double length_in_metric(const Remeshing<D>& r, const InnerNode<D>& of, const Vec<D>& v) {
    return std::sqrt(std::max(r.metrics[of.a].measure.length_squared(v), r.metrics[of.b].measure.length_squared(v)));
}

template <int D>
double worst_quality(const Remeshing<D>& r) {
    double worst = 1;
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e)
        if (!r.mesh.is_free(ElementId(e))) worst = std::min(worst, quality_of_shape(shape_of(r, ElementId(e)), D));
    return worst;
}
template <int D>
bool all_valid(const Remeshing<D>& r) {
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e)
        if (!r.mesh.is_free(ElementId(e)) &&
            decide(NodalSimplex<D>{nodes_of(r.mesh, ElementId(e))}, 0) != Verdict::valid)
            return false;
    return true;
}

/// How far nodes are from their targets, in all, before and after.
struct Misfit {
    double before = 0, after = 0;
};

template <int D>
Misfit expect_laws(const BowedDomain<D>& domain) {
    const Remeshing<D>& before = domain.state;
    RC_ASSERT(all_valid(before));
    const auto by = [&](int threads) {
        return must(reinsert_vertices<D>(before, domain.goal, {}, Execution{.threads = threads})).state;
    };
    const Remeshing<D> after = by(1);
    RC_ASSERT(by(2).mesh.nodes == after.mesh.nodes);
    must(check_consistency(after.mesh, alone));
    RC_ASSERT(after.mesh.points == before.mesh.points);
    RC_ASSERT(all_valid(after));
    RC_ASSERT(worst_quality(after) >= std::min(0.05, worst_quality(before)) * (1 - 1e-8));
    RC_ASSERT(inner_nodes(after, 1) == inner_nodes(before, 1));
    const auto from = inner_nodes(before, 0);
    const auto to = inner_nodes(after, 0);
    RC_ASSERT(from.size() == to.size());
    Misfit misfit;
    for (std::size_t i = 0; i < from.size(); ++i) {
        RC_ASSERT(from[i].a == to[i].a);
        RC_ASSERT(from[i].b == to[i].b);
        const Vec<D> target = target_of(before, domain.goal, from[i].a, from[i].b);
        const double was = length_in_metric(before, from[i], from[i].node - target);
        const double is = length_in_metric(before, to[i], to[i].node - target);
        RC_ASSERT(is <= was + 1e-3);
        misfit.before += was;
        misfit.after += is;
    }
    return misfit;
}

template <int D>
BowedDomain<D> random_bowed(std::uint64_t seed) {
    Dice dice(seed);
    return bowed_domain<D>(domain_with_required<D>(seed), dice);
}

template <int D>
void expect_laws_of_reinsertion(const char* name, int trials) {
    property(name,
             [] {
                 BowedDomain<D> domain = random_bowed<D>(*rc::gen::inRange<std::uint64_t>(1, 100000));
                 if (*rc::gen::arbitrary<bool>()) domain.goal.search.emplace(EdgeMinimiserOptions{});
                 expect_laws(domain);
             },
             {.count = trials});
}

/// Of the misfit of four domains.
template <int D>
double share_left(bool searches) {
    Misfit sum;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        BowedDomain<D> domain = random_bowed<D>(seed);
        if (searches) domain.goal.search.emplace(EdgeMinimiserOptions{});
        const Misfit misfit = expect_laws(domain);
        sum.before += misfit.before;
        sum.after += misfit.after;
    }
    MESSAGE("misfit ", sum.before, " to ", sum.after);
    return sum.after / sum.before;
}

}  // namespace

TEST_CASE("vertices put in again: laws in 2D") { expect_laws_of_reinsertion<2>("reinsertion as a pass, 2D", 40); }

TEST_CASE("vertices put in again: laws in 3D") { expect_laws_of_reinsertion<3>("reinsertion as a pass, 3D", 8); }

TEST_CASE("vertices put in again: most nodes come to their targets") {
    for (const bool searches : {false, true}) {
        CHECK(share_left<2>(searches) < 0.3);
        CHECK(share_left<3>(searches) < 0.3);
    }
}

TEST_CASE("vertices put in again: options out of range are refused, and a straight mesh is as it was") {
    const LinearMesh<2> mesh = domain_with_required<2>(1);
    Buffer<LogMetric<2>> logs(mesh.points.size());
    const RemeshingGoal<2> goal{
        must(make_back_mesh(mesh, must(balls(mesh, alone)), Column<LogMetric<2>>(std::move(logs)), alone)), {}};
    const Remeshing<2> r = must(begin_remeshing(mesh, must(unique_edges(mesh, alone)), {}, goal, alone));
    CHECK(must(reinsert_vertices<2>(r, goal, {}, alone)).statistics.proposals == 0);
    CHECK(!reinsert_vertices<2>(r, goal, {.turns = 0}, alone));
}
