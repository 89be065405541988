// The global algorithm of the paper reinserts vertices at their positions. Nodes move to or towards their targets, no
// element becomes invalid, and nothing else changes.
#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.validity;
import camber.curving;
import camber.operation;
import camber.adapt;

#include "block.hpp"
#include "dice.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

/// A block with its boundary listed, and the node targets that `curve` computes.
template <int D>
struct NodeTargets {
    Block<D> block;
    std::vector<VertexId> corners;  ///< all boundary vertices, since no boundary curve is smooth
    Proposal<D> proposal;
};

template <int D>
NodeTargets<D> targets_of(Block<D> b) {
    NodeTargets<D> out;
    const auto around = must(balls(b.mesh.linear, one_thread));
    Buffer<SimplexVertices<D - 1>> facets;
    for (const ElementFace& face : boundary_faces<D>(must(neighbours(b.mesh.linear, around, one_thread)))) {
        const auto local = face_opposite<D>(static_cast<int>(face.opposite));
        SimplexVertices<D - 1>& facet = facets.emplace_back();
        for (int i = 0; i < D; ++i) facet[i] = b.mesh.linear.elements.vertices[face.element][local[i]];
    }
    Buffer<Reference> references(facets.size(), 1);
    b.mesh.linear.facets = {std::move(facets), std::move(references), {}};
    out.proposal = must(curve({b.mesh, b.kinds, b.shells}, b.boundary_nodes, b.back, {}, one_thread)).proposal;
    out.block = std::move(b);
    return out;
}

template <int D>
Outcome<ReinsertionResult<D>> reinsert_vertices(const NodeTargets<D>& w, const Execution& execution,
                                                const ReinsertionOptions& by = {}) {
    return reinsert(w.block.mesh, w.proposal, {w.block.kinds.view(), w.corners}, w.block.back, by, execution);
}

template <int D>
double smallest(const NodeTargets<D>& w, const Proposal<D>& proposal) {
    return must(validate(w.block.mesh, proposal, 0, one_thread)).validation().smallest;
}

template <int D>
void check_reinsertion(const std::array<int, D>& cells) {
    property("reinsertion yields valid elements, is idempotent and independent of threads",
             [&](std::uint64_t seed) {
                 const auto w = targets_of(shell_block<D>(cells, seed + 1));
                 const ReinsertionResult<D> r = must(reinsert_vertices(w, one_thread));
                 RC_ASSERT(r.statistics.accepted > 0U);
                 RC_ASSERT(r.left == 0U);
                 RC_ASSERT(r.proposal.points == w.block.mesh.linear.points);
                 RC_ASSERT(must(validate(w.block.mesh, r.proposal, 0, one_thread)).validation().all_valid());
                 for (std::size_t e = 0; e < w.block.mesh.edges.size(); ++e)
                     if (r.proposal.changes[e] != EdgeChange::relaxed)
                         RC_ASSERT(r.proposal.mid_nodes[e] == w.proposal.mid_nodes[e]);
                 if (smallest(w, w.proposal) > 0.1) RC_ASSERT(r.proposal.mid_nodes == w.proposal.mid_nodes);
                 for (const int threads : {2, 5})
                     RC_ASSERT(must(reinsert_vertices(w, Execution{.threads = threads})).proposal == r.proposal);
                 auto repeated = w;
                 repeated.block.mesh.mid_nodes = r.proposal.mid_nodes;
                 repeated.proposal.mid_nodes = r.proposal.mid_nodes;
                 RC_ASSERT(must(reinsert_vertices(repeated, one_thread)).statistics.proposals == 0U);
             },
             {.count = D == 2 ? 8 : 3});
}

}  // namespace

TEST_CASE("reinsertion moves nodes to or towards their targets and keeps elements valid, 2D") {
    check_reinsertion<2>({8, 5});
}
TEST_CASE("reinsertion moves nodes to or towards their targets and keeps elements valid, 3D") {
    check_reinsertion<3>({4, 4, 3});
}

TEST_CASE("reinsertion repairs invalid input elements") {
    // All nodes at their targets, as `curve` returns them: some elements are invalid.
    std::size_t invalid_before = 0, remaining = 0;
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
        auto b = shell_block<3>({4, 4, 3}, seed);
        auto nodes = take(b.boundary_nodes);
        for (std::size_t e = 0; e < nodes.size(); ++e)  // walls bulge four times as far
            nodes[e].point += 3.0 * (nodes[e].point - b.mesh.mid_nodes[e].point);
        b.boundary_nodes = std::move(nodes);
        auto w = targets_of(std::move(b));
        const auto before = must(validate(w.block.mesh, w.proposal, min_bound, one_thread)).validation();
        invalid_before += before.invalid;
        // From straight edges no element becomes invalid.
        const auto from_straight = must(reinsert_vertices(w, one_thread)).proposal;
        CHECK(must(validate(w.block.mesh, from_straight, min_bound, one_thread)).validation().all_valid());
        w.block.mesh.mid_nodes = w.proposal.mid_nodes;
        for (std::size_t v = 0; v < w.block.mesh.linear.points.size(); ++v) w.corners.emplace_back(v);
        w.proposal.mid_nodes = elevate(w.block.mesh.linear, one_thread)->mid_nodes;
        const auto r = must(reinsert_vertices(w, one_thread)).proposal;
        remaining += must(validate(w.block.mesh, r, min_bound, one_thread)).validation().invalid;
    }
    CHECK(invalid_before > 0);
    CHECK(remaining == 0);
}

TEST_CASE("boundary nodes blocked by straight neighbours reach their targets in later sweeps") {
    // Thin layers at the inner wall, whose sagitta exceeds the first layer: straight layer edges block the boundary
    // nodes. Inner nodes cannot all reach their targets; boundary nodes have priority.
    const auto w = targets_of(shell_block<2>({3, 12}, 3, [](double s) { return 1 + 0.2 * s + 0.8 * s * s; }));
    CHECK(smallest(w, w.proposal) < -1);
    const auto r = must(reinsert_vertices(w, one_thread));
    CHECK(r.sweeps > 1);
    std::size_t surface = 0;
    for (std::size_t e = 0; e < w.block.mesh.edges.size(); ++e) {
        if (w.block.kinds[e] == EdgeKind::volume) continue;
        ++surface;
        CHECK(r.proposal.mid_nodes[e] == w.block.boundary_nodes[e]);
    }
    CHECK(surface > 0);
}

TEST_CASE("reinsertion rejects invalid options") {
    const auto w = targets_of(shell_block<2>({3, 2}, 1));
    CHECK(!reinsert_vertices(w, one_thread, {.max_sweeps = 0}).has_value());
}

TEST_CASE("reinsertion rejects a proposal without nodes") {
    const auto w = targets_of(shell_block<2>({3, 2}, 1));
    auto incomplete = w;
    incomplete.proposal.mid_nodes = {};
    CHECK(!reinsert_vertices(incomplete, one_thread).has_value());
}

TEST_CASE("reinsertion stops on request") {
    const auto w = targets_of(shell_block<2>({3, 2}, 1));
    std::stop_source source;
    source.request_stop();
    const auto stopped = reinsert_vertices(w, Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE(!stopped.has_value());
    CHECK(stopped.error().kind == ErrorKind::stopped);
}
