// The verb commit: all or nothing.
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "block.hpp"
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
Proposal<D> straight_proposal(const Block<D>& b) {
    return must(curve_boundary(b.mesh, b.kinds, b.mesh.mid_nodes, alone)).proposal;
}

}  // namespace

TEST_CASE("a valid proposal becomes the mesh, which shares its columns") {
    const auto b = shell_block<3>({3, 3, 2}, 1);
    const auto proposal = must(curve_boundary(b.mesh, b.kinds, b.boundary_nodes, alone)).proposal;
    const auto judged = must(validate(b.mesh, proposal, 1e-12, alone));
    REQUIRE(judged.validation().all_valid());
    const auto [committed, maps] = must(commit(judged));
    CHECK(committed.mid_nodes == proposal.mid_nodes);
    CHECK(committed.mid_nodes.begin() == proposal.mid_nodes.begin());
    CHECK(committed.linear.points.begin() == b.mesh.linear.points.begin());
    CHECK(committed.edges.vertices.begin() == b.mesh.edges.vertices.begin());
    CHECK(must(validate(committed, 1e-12, alone)) == judged.validation());
    CHECK(maps.vertices.is_identity());
    CHECK(maps.vertices.size() == committed.linear.points.size());
    CHECK(maps.edges.size() == committed.edges.size());
    CHECK(maps.elements.size() == committed.linear.elements.size());
    CHECK(maps.facets.size() == committed.linear.facets.size());
    CHECK(maps.elements[ElementId(3)] == ElementId(3));
}

TEST_CASE("maps hold what went elsewhere, and what is gone") {
    const IdMap<VertexId> map(Buffer<VertexId>{VertexId(1), VertexId{}, VertexId(0)});
    CHECK(map.size() == 3);
    CHECK(!map.is_identity());
    CHECK(map[VertexId(0)] == VertexId(1));
    CHECK(!map[VertexId(1)].valid());
    CHECK(map[VertexId(2)] == VertexId(0));
}

TEST_CASE("vertices that move are of the proposal: judged with it, and committed with it") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto inner = boundary_marks(b);
    const auto moved = std::find(inner.begin(), inner.end(), 0) - inner.begin();
    auto proposal = straight_proposal(b);
    auto points = take(proposal.points);
    points[static_cast<std::size_t>(moved)] += Vec<2>{{1e-3, 2e-3}};
    proposal.points = points;
    const auto judged = must(validate(b.mesh, proposal, 1e-12, alone));
    const auto committed = must(commit(judged)).mesh;
    CHECK(committed.linear.points == proposal.points);
    CHECK(must(validate(committed, 1e-12, alone)) == judged.validation());
    CHECK(judged.mesh().linear.points == b.mesh.linear.points);
    // Over the other side: its elements are inverted, though no node moved.
    points[static_cast<std::size_t>(moved)] += Vec<2>{{100, 0}};
    proposal.points = points;
    CHECK(!commit(must(validate(b.mesh, proposal, 1e-12, alone))).has_value());
}

TEST_CASE("one element of which det J > 0 is not certain, and nothing is committed") {
    const auto b = shell_block<2>({4, 3}, 1);
    auto proposal = straight_proposal(b);
    auto nodes = take(proposal.mid_nodes);
    std::size_t broken = 0;
    while (b.kinds[broken] != EdgeKind::volume) ++broken;
    nodes[broken].point += 10.0 * Vec<2>{{1, 1}};
    proposal.mid_nodes = nodes;
    const auto judged = must(validate(b.mesh, proposal, 1e-12, alone));
    REQUIRE(!judged.validation().certified());
    const auto committed = commit(judged);
    REQUIRE(!committed.has_value());
    CHECK(committed.error().kind == ErrorKind::input);
    REQUIRE(committed.error().entity.has_value());
    CHECK(committed.error().entity->kind == "triangle");
    const ElementId named(static_cast<std::size_t>(committed.error().entity->number - 1));
    CHECK(judged.validation().verdicts[named] != Verdict::valid);
    // Who wants to see it may.
    CHECK(commit_uncertified(judged).mesh.mid_nodes == proposal.mid_nodes);
}

TEST_CASE("a bound is asked beside the certificate") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto proposal = must(curve_boundary(b.mesh, b.kinds, b.boundary_nodes, alone)).proposal;
    const auto plain = must(validate(b.mesh, proposal, 0, alone));
    REQUIRE(plain.validation().all_valid());
    REQUIRE(plain.validation().smallest < 0.99);
    const auto strict = must(validate(b.mesh, proposal, 0.99, alone));
    CHECK(!strict.validation().all_valid());
    CHECK(strict.validation().certified());
    CHECK(must(commit(strict)).mesh == must(commit(plain)).mesh);
}

TEST_CASE("a proposal of another mesh is refused") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto other = shell_block<2>({2, 2}, 1);
    CHECK(!validate(other.mesh, straight_proposal(b), 1e-12, alone).has_value());
    auto pointless = straight_proposal(b);
    pointless.points = other.mesh.linear.points;
    CHECK(!validate(b.mesh, pointless, 1e-12, alone).has_value());
}

TEST_CASE("committed, then committed again with its own nodes: nothing changes") {
    const auto b = shell_block<2>({4, 3}, 2);
    const auto proposal = must(curve_boundary(b.mesh, b.kinds, b.boundary_nodes, alone)).proposal;
    const auto once = must(commit(must(validate(b.mesh, proposal, 1e-12, alone)))).mesh;
    const auto twice = must(commit(must(validate(once, proposal, 1e-12, alone)))).mesh;
    CHECK(once == twice);
}
