// The cavity operator's first use: vertices reinserted, and the global algorithm.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <utility>
#include <variant>
#include <vector>

#include "block.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.curving;
import camber.repair;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
Curving<D> start(const Block<D>& b) {
    const std::size_t n = b.mesh.edges.size();
    return {b.mesh,
            b.kinds,
            b.boundary_nodes,
            Buffer<EdgeChange>(n, EdgeChange::straight),
            Buffer<EdgeTarget<D>>(n),
            Buffer<std::uint8_t>(n, 0)};
}

template <int D>
Outcome<Reinserted<D>> all_reinserted(const Block<D>& b, const Execution& execution) {
    return reinsert_all(b.mesh, b.kinds, b.boundary_nodes, b.back, ReinsertAllOptions{}, execution);
}

template <int D>
void operator_laws(const std::array<int, D>& cells) {
    property("a patch changes nodes at its vertex alone, keeps the elements, and never breaks one",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto topology = *cavity_topology(b.mesh, alone);
                 const auto rules = edge_rules({});
                 const ReinsertOptions options;
                 auto curving = start(b);
                 std::size_t patches = 0;
                 for (int trial = 0; trial < 30; ++trial) {
                     const VertexId v(dice.below(b.mesh.linear.points.size()));
                     const auto r = *reinsert(curving, topology, b.back, v, rules, options);
                     const auto* patch = std::get_if<Patch<D>>(&r.result);
                     if (patch == nullptr) continue;
                     ++patches;
                     for (std::size_t i = 0; i < patch->removed.size(); ++i)
                         RC_ASSERT(patch->elements[i] == b.mesh.linear.elements.vertices[patch->removed[i]]);
                     for (const auto& node : patch->nodes) {
                         RC_ASSERT((node.vertices[0] == v || node.vertices[1] == v));
                         RC_ASSERT(node.vertices == b.mesh.edges.vertices[node.edge]);
                     }
                     curving = *commit<D>(std::move(curving), std::span(patch, 1));
                     RC_ASSERT(validate(curving.mesh, options.relax.min_scaled_jacobian, alone)->all_valid());
                 }
                 RC_ASSERT(patches > 0U);
             },
             {.count = 3});
    property(
        "the whole: valid; nodes are those of the verb curve, but for those that validity moved",
        [&](std::uint64_t seed) {
            const auto b = shell_block<D>(cells, seed + 1);
            const auto r = *all_reinserted(b, alone);
            const auto whole = *curve(b.mesh, b.kinds, b.boundary_nodes, b.shells, b.back, {}, alone);
            RC_ASSERT(r.wanted.proposal == whole.proposal);
            RC_ASSERT(r.wanted.lengths == whole.lengths);
            RC_ASSERT(r.wanted.straight_lengths == whole.straight_lengths);
            RC_ASSERT(r.wanted.statistics.curved_edges == whole.statistics.curved_edges);
            RC_ASSERT(validate(r.mesh, RepairOptions{}.min_scaled_jacobian, alone)->all_valid());
            RC_ASSERT(r.mesh.mid_nodes == r.proposal.mid_nodes);
            for (std::size_t e = 0; e < b.mesh.edges.size(); ++e)
                if (r.proposal.changes[e] != EdgeChange::relaxed && r.proposal.changes[e] != EdgeChange::straightened)
                    RC_ASSERT(r.proposal.mid_nodes[e] == whole.proposal.mid_nodes[e]);
            const auto judged = *validate(b.mesh, whole.proposal, RepairOptions{}.min_scaled_jacobian, alone);
            if (judged.validation().all_valid()) RC_ASSERT(r.proposal == whole.proposal);
        },
        {.count = 4});
    property("the same bytes for any number of threads",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto first = *all_reinserted(b, alone);
                 for (const int threads : {2, 5}) {
                     const auto other = *all_reinserted(b, Execution{.threads = threads});
                     RC_ASSERT(other.proposal == first.proposal);
                     RC_ASSERT(other.wanted.lengths == first.wanted.lengths);
                     RC_ASSERT(other.statistics.patches == first.statistics.patches);
                 }
             },
             {.count = 2});
    property("a vertex whose nodes are at their targets is left alone",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto r = *all_reinserted(b, alone);
                 auto curving = start(b);
                 curving.mesh = r.mesh;
                 const auto topology = *cavity_topology(b.mesh, alone);
                 for (std::size_t v = 0; v < b.mesh.linear.points.size(); ++v) {
                     bool there = true;
                     for (std::size_t e = 0; e < b.mesh.edges.size(); ++e) {
                         const auto& [p, q] = b.mesh.edges.vertices[e];
                         if (p.index() == v || q.index() == v)
                             there &= r.proposal.mid_nodes[e] == r.wanted.proposal.mid_nodes[e];
                     }
                     if (!there) continue;
                     const auto again = *reinsert(curving, topology, b.back, VertexId(v), edge_rules({}), {});
                     const auto* rejection = std::get_if<Rejection>(&again.result);
                     RC_ASSERT(rejection != nullptr);
                     RC_ASSERT(rejection->reason == ReinsertionFailure::no_gain);
                 }
             },
             {.count = 1});
}

}  // namespace

TEST_CASE("reinsertion in triangles") { operator_laws<2>({8, 5}); }
TEST_CASE("reinsertion in tetrahedra") { operator_laws<3>({4, 4, 3}); }

TEST_CASE("elements that come in invalid are mended, and the rest stays") {
    // All nodes on their targets, as the verb curve leaves them: some elements are broken.
    std::size_t broken = 0;
    for (const std::uint64_t seed : {1, 2}) {
        auto b = shell_block<3>({4, 4, 3}, seed);
        auto nodes = take(b.boundary_nodes);
        for (std::size_t e = 0; e < nodes.size(); ++e)  // walls that bulge four times as far
            nodes[e].point += 3.0 * (nodes[e].point - b.mesh.mid_nodes[e].point);
        b.boundary_nodes = std::move(nodes);
        const auto whole = must(curve(b.mesh, b.kinds, b.boundary_nodes, b.shells, b.back, {}, alone));
        const double bound = least_bound;  // what is wished for cannot be had everywhere
        broken += must(validate(b.mesh, whole.proposal, bound, alone)).validation().invalid;
        b.mesh.mid_nodes = whole.proposal.mid_nodes;
        const auto r = must(all_reinserted(b, alone));
        CHECK(must(validate(r.mesh, bound, alone)).all_valid());
    }
    CHECK(broken > 0);
}

TEST_CASE("a margin is kept where no surface node pays for it") {
    const auto b = shell_block<3>({4, 4, 3}, 2);
    const auto r = must(all_reinserted(b, alone));
    for (std::size_t e = 0; e < b.mesh.edges.size(); ++e)
        if (b.kinds[e] != EdgeKind::volume) REQUIRE(r.proposal.mid_nodes[e] == b.boundary_nodes[e]);
    CHECK(must(validate(r.mesh, 0, alone)).smallest > 0.009);
}

TEST_CASE("surface nodes that neighbours keep back at first reach their targets in later turns") {
    // Thin layers at the inner wall, whose sagitta exceeds the first one: straight layer edges are in its way.
    auto b = shell_block<2>({4, 8}, 3);
    const auto r = must(all_reinserted(b, alone));
    std::size_t surface = 0;
    for (std::size_t e = 0; e < b.mesh.edges.size(); ++e) {
        if (b.kinds[e] == EdgeKind::volume) continue;
        ++surface;
        CHECK(r.proposal.mid_nodes[e] == b.boundary_nodes[e]);
    }
    CHECK(surface > 0);
}

TEST_CASE("a vertex without elements is rejected, and wrong columns are refused") {
    auto b = shell_block<2>({3, 2}, 1);
    auto points = take(b.mesh.linear.points);
    auto references = take(b.mesh.linear.point_references);
    points.push_back(Vec<2>{});
    references.push_back(0);
    b.mesh.linear.points = std::move(points);
    b.mesh.linear.point_references = std::move(references);
    const auto topology = must(cavity_topology(b.mesh, alone));
    const auto r =
        must(reinsert(start(b), topology, b.back, VertexId(b.mesh.linear.points.size() - 1), edge_rules({}), {}));
    const auto* rejection = std::get_if<Rejection>(&r.result);
    REQUIRE(rejection != nullptr);
    CHECK(rejection->reason == ReinsertionFailure::no_element);
    CHECK(!reinsert_all(b.mesh, Column<EdgeKind>{}, b.boundary_nodes, b.back, {}, alone).has_value());
    std::stop_source source;
    source.request_stop();
    const auto early = all_reinserted(b, Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE(!early.has_value());
    CHECK(early.error().kind == ErrorKind::stopped);
    const Patch<2> foreign{VertexId(std::size_t{0}), {}, {}, {{{}, EdgeId{}, {}}}, 0};
    CHECK(!commit<2>(start(b), std::span(&foreign, 1)).has_value());
}
