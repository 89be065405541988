// The verb `curve` on whole meshes.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>

#include "block.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.optimisation;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
Outcome<Curved<D>> curved(const Block<D>& b, const Execution& execution) {
    CurveOptions energy;
    energy.aim = CurvingAim::energy;
    return curve({b.mesh, b.kinds, b.shells}, b.boundary_nodes, b.back, energy, execution);
}

template <int D>
void check_curve(const std::array<int, D>& cells) {
    property("curving by energy takes boundary nodes over and lengthens no volume edge",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto c = *curved(b, one_thread);
                 const auto rule = gauss_legendre(report_points);
                 std::size_t volume = 0, moved = 0;
                 double gain = 0;
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e) {
                     const auto [p, q] = b.mesh.edges.vertices[e];
                     const Vec<D> x = b.mesh.linear.points[p], y = b.mesh.linear.points[q];
                     const auto& node = c.proposal.mid_nodes[e];
                     const bool straight = node.point == midpoint(x, y);
                     RC_ASSERT(c.proposal.kinds[e] == b.kinds[e]);
                     if (b.kinds[e] != EdgeKind::volume) {
                         RC_ASSERT(node == b.boundary_nodes[e]);
                         RC_ASSERT(c.proposal.changes[e] == (straight ? EdgeChange::straight : EdgeChange::projected));
                         RC_ASSERT(c.lengths[e] == 0);
                         RC_ASSERT(c.straight_lengths[e] == 0);
                         continue;
                     }
                     ++volume;
                     moved += !straight;
                     RC_ASSERT(c.proposal.changes[e] == (straight ? EdgeChange::straight : EdgeChange::optimised));
                     RC_ASSERT(c.lengths[e] <= c.straight_lengths[e]);
                     const ElementId hint = b.shells[e].front();
                     const double length = riemannian_length(b.back, QuadraticEdge<D>{x, node, y}, rule, hint).length;
                     const double chord =
                         riemannian_length(b.back, QuadraticEdge<D>::straight(x, y), rule, hint).length;
                     RC_ASSERT(std::abs(c.lengths[e] - length) < 1e-12 * chord);
                     RC_ASSERT(std::abs(c.straight_lengths[e] - chord) < 1e-12 * chord);
                     gain += c.straight_lengths[e] / c.lengths[e] - 1;
                 }
                 RC_ASSERT(c.statistics.volume_edges == volume);
                 RC_ASSERT(c.statistics.curved_edges == moved);
                 RC_ASSERT(c.statistics.lost == 0U);
                 RC_ASSERT(gain / static_cast<double>(volume) > 1e-4);
             },
             {.count = 5});
    property("curving by energy does not depend on the number of threads",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto first = *curved(b, one_thread);
                 for (const int threads : {2, 7}) {
                     const auto other = *curved(b, Execution{.threads = threads});
                     RC_ASSERT(other.proposal == first.proposal);
                     RC_ASSERT(other.lengths == first.lengths);
                     RC_ASSERT(other.straight_lengths == first.straight_lengths);
                 }
             },
             {.count = 2});
    property(
        "updated_lengths measures the edges that moved",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<D>(cells, seed + 1);
            const auto c = *curved(b, one_thread);
            auto after = c.proposal;
            auto nodes = take(after.mid_nodes);
            std::size_t relaxed = 0;
            for (std::size_t e = 0; e < nodes.size(); ++e)
                if (b.kinds[e] == EdgeKind::volume && dice.below(3) == 0) {
                    nodes[e] = b.mesh.mid_nodes[e];
                    ++relaxed;
                }
            after.mid_nodes = nodes;
            const auto lengths =
                updated_lengths({b.mesh.edges, b.shells}, c, after, b.back, MeasuredEdges::some, one_thread)->curved;
            for (std::size_t e = 0; e < nodes.size(); ++e) {
                const bool same = after.mid_nodes[e] == c.proposal.mid_nodes[e];
                const double expected = same ? c.lengths[e] : c.straight_lengths[e];
                RC_ASSERT(std::abs(lengths[e] - expected) <= (same ? 0.0 : 1e-12 * expected));
            }
            RC_ASSERT(relaxed > 0U);
        },
        {.count = 3});
    // Guards against length reductions relative to the chords before a vertex moved.
    property("updated_lengths refers to the present chords where a vertex moved",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto c = *curved(b, one_thread);
                 const EdgeSet<D>& edges = b.mesh.edges;
                 Proposal<D> straight = c.proposal;
                 auto points = take(straight.points);
                 for (Vec<D>& p : points)
                     if (dice.below(4) == 0) p += dice.vector<D>(-0.01, 0.01);
                 straight.points = std::move(points);
                 auto nodes = take(straight.mid_nodes);
                 for (std::size_t e = 0; e < nodes.size(); ++e) {
                     const auto& [p, q] = edges.vertices[e];
                     nodes[e].point = midpoint(straight.points[p], straight.points[q]);
                 }
                 straight.mid_nodes = std::move(nodes);
                 const auto lengths =
                     *updated_lengths({edges, b.shells}, c, straight, b.back, MeasuredEdges::some, one_thread);
                 std::size_t moved = 0;
                 for (std::size_t e = 0; e < edges.size(); ++e) {
                     RC_ASSERT(std::abs(lengths.curved[e] - lengths.straight[e]) <= 1e-12 * lengths.straight[e]);
                     moved += lengths.straight[e] != c.straight_lengths[e];
                 }
                 RC_ASSERT(moved > 0U);
             },
             {.count = 3});
    property("volume edges stay straight without a metric field",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto c = *curve_boundary(b.mesh, b.kinds, b.boundary_nodes, one_thread);
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e)
                     RC_ASSERT(c.proposal.mid_nodes[e] ==
                               (b.kinds[e] == EdgeKind::volume ? b.mesh.mid_nodes[e] : b.boundary_nodes[e]));
                 RC_ASSERT(c.statistics.curved_edges == 0U);
             },
             {.count = 2});
}

}  // namespace

TEST_CASE("curving by energy keeps boundary nodes and lengthens no volume edge, 2D") { check_curve<2>({8, 5}); }
TEST_CASE("curving by energy keeps boundary nodes and lengthens no volume edge, 3D") { check_curve<3>({4, 4, 3}); }

TEST_CASE("curving rejects columns whose length does not fit the mesh") {
    const auto b = shell_block<2>({3, 2}, 1);
    const auto wrong =
        curve({b.mesh, Column<EdgeKind>{}, b.shells}, b.boundary_nodes, b.back, CurveOptions{}, one_thread);
    REQUIRE(!wrong.has_value());
    CHECK(!curve_boundary(b.mesh, b.kinds, Column<LagrangeNode<2>>{}, one_thread).has_value());
}

TEST_CASE("curving stops on request") {
    const auto b = shell_block<2>({3, 2}, 1);
    std::stop_source source;
    source.request_stop();
    const auto stopped_early = curved(b, Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE(!stopped_early.has_value());
    CHECK(stopped_early.error().kind == ErrorKind::stopped);
}
