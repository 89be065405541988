// The paper's global algorithm: vertices put in again where they are. Nodes go to where they are wanted, or towards it,
// no element breaks, and nothing else changes.
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

/// A block with its boundary listed, and where `curve` wants its nodes.
template <int D>
struct Wanted {
    Block<D> block;
    std::vector<VertexId> corners;  ///< all of the boundary: nothing there is smooth
    Proposal<D> proposal;
};

template <int D>
Wanted<D> wanted(Block<D> b) {
    Wanted<D> out;
    const auto around = must(balls(b.mesh.linear, alone));
    Buffer<SimplexVertices<D - 1>> facets;
    for (const ElementFace& face : boundary_faces<D>(must(neighbours(b.mesh.linear, around, alone)))) {
        const auto local = face_opposite<D>(static_cast<int>(face.opposite));
        SimplexVertices<D - 1>& facet = facets.emplace_back();
        for (int i = 0; i < D; ++i) facet[i] = b.mesh.linear.elements.vertices[face.element][local[i]];
    }
    Buffer<Reference> references(facets.size(), 1);
    b.mesh.linear.facets = {std::move(facets), std::move(references), {}};
    out.proposal = must(curve({b.mesh, b.kinds, b.shells}, b.boundary_nodes, b.back, {}, alone)).proposal;
    out.block = std::move(b);
    return out;
}

template <int D>
Outcome<Reinserted<D>> put_in_again(const Wanted<D>& w, const Execution& execution, const ReinsertionOptions& by = {}) {
    return reinsert(w.block.mesh, w.proposal, {w.block.kinds.view(), w.corners}, w.block.back, by, execution);
}

template <int D>
double smallest(const Wanted<D>& w, const Proposal<D>& proposal) {
    return must(validate(w.block.mesh, proposal, 0, alone)).validation().smallest;
}

template <int D>
void expect_laws(const std::array<int, D>& cells) {
    property("valid; nodes are wanted, kept or between; threads have no say; what is there stays",
             [&](std::uint64_t seed) {
                 const auto w = wanted(shell_block<D>(cells, seed + 1));
                 const Reinserted<D> r = must(put_in_again(w, alone));
                 RC_ASSERT(r.statistics.accepted > 0U);
                 RC_ASSERT(r.left == 0U);
                 RC_ASSERT(r.proposal.points == w.block.mesh.linear.points);
                 RC_ASSERT(must(validate(w.block.mesh, r.proposal, 0, alone)).validation().all_valid());
                 for (std::size_t e = 0; e < w.block.mesh.edges.size(); ++e)
                     if (r.proposal.changes[e] != EdgeChange::relaxed)
                         RC_ASSERT(r.proposal.mid_nodes[e] == w.proposal.mid_nodes[e]);
                 if (smallest(w, w.proposal) > 0.1) RC_ASSERT(r.proposal.mid_nodes == w.proposal.mid_nodes);
                 for (const int threads : {2, 5})
                     RC_ASSERT(must(put_in_again(w, Execution{.threads = threads})).proposal == r.proposal);
                 auto there = w;
                 there.block.mesh.mid_nodes = r.proposal.mid_nodes;
                 there.proposal.mid_nodes = r.proposal.mid_nodes;
                 RC_ASSERT(must(put_in_again(there, alone)).statistics.proposals == 0U);
             },
             {.count = D == 2 ? 8 : 3});
}

}  // namespace

TEST_CASE("vertices put in again: laws in triangles") { expect_laws<2>({8, 5}); }
TEST_CASE("vertices put in again: laws in tetrahedra") { expect_laws<3>({4, 4, 3}); }

TEST_CASE("vertices put in again: elements that come in invalid are mended, and the rest stays") {
    // All nodes where they are wanted, as the verb curve leaves them: some elements are broken.
    std::size_t broken = 0, left = 0;
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
        auto b = shell_block<3>({4, 4, 3}, seed);
        auto nodes = take(b.boundary_nodes);
        for (std::size_t e = 0; e < nodes.size(); ++e)  // walls that bulge four times as far
            nodes[e].point += 3.0 * (nodes[e].point - b.mesh.mid_nodes[e].point);
        b.boundary_nodes = std::move(nodes);
        auto w = wanted(std::move(b));
        const auto before = must(validate(w.block.mesh, w.proposal, min_bound, alone)).validation();
        broken += before.invalid;
        // From straight edges none breaks.
        const auto from_straight = must(put_in_again(w, alone)).proposal;
        CHECK(must(validate(w.block.mesh, from_straight, min_bound, alone)).validation().all_valid());
        w.block.mesh.mid_nodes = w.proposal.mid_nodes;
        for (std::size_t v = 0; v < w.block.mesh.linear.points.size(); ++v) w.corners.emplace_back(v);
        w.proposal.mid_nodes = elevate(w.block.mesh.linear, alone)->mid_nodes;
        const auto r = must(put_in_again(w, alone)).proposal;
        left += must(validate(w.block.mesh, r, min_bound, alone)).validation().invalid;
    }
    CHECK(broken > 0);
    CHECK(left == 0);
}

TEST_CASE("vertices put in again: nodes of the boundary that straight neighbours keep back get there in later sweeps") {
    // Thin layers at the inner wall, whose sagitta exceeds the first one: straight layer edges are in its way.
    // Inner nodes cannot all be where they are wanted: those of the boundary come first.
    const auto w = wanted(shell_block<2>({3, 12}, 3, [](double s) { return 1 + 0.2 * s + 0.8 * s * s; }));
    CHECK(smallest(w, w.proposal) < -1);
    const auto r = must(put_in_again(w, alone));
    CHECK(r.sweeps > 1);
    std::size_t surface = 0;
    for (std::size_t e = 0; e < w.block.mesh.edges.size(); ++e) {
        if (w.block.kinds[e] == EdgeKind::volume) continue;
        ++surface;
        CHECK(r.proposal.mid_nodes[e] == w.block.boundary_nodes[e]);
    }
    CHECK(surface > 0);
}

TEST_CASE("vertices put in again: what is wrong is refused") {
    const auto w = wanted(shell_block<2>({3, 2}, 1));
    CHECK(!put_in_again(w, alone, {.max_sweeps = 0}).has_value());
    auto short_one = w;
    short_one.proposal.mid_nodes = {};
    CHECK(!put_in_again(short_one, alone).has_value());
    std::stop_source source;
    source.request_stop();
    const auto early = put_in_again(w, Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE(!early.has_value());
    CHECK(early.error().kind == ErrorKind::stopped);
}
