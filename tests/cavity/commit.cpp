// The verb commit: all or nothing.
#include <cstddef>
#include <string>
#include <utility>

#include "block.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
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
    const auto validation = must(validate(b.mesh, proposal, 1e-12, alone));
    REQUIRE(validation.invalid == 0);
    REQUIRE(validation.undecided == 0);
    const auto committed = must(commit(b.mesh, proposal, validation));
    CHECK(committed.mid_nodes == proposal.mid_nodes);
    CHECK(committed.mid_nodes.begin() == proposal.mid_nodes.begin());
    CHECK(committed.linear.points.begin() == b.mesh.linear.points.begin());
    CHECK(committed.edges.vertices.begin() == b.mesh.edges.vertices.begin());
    CHECK(must(validate(committed, 1e-12, alone)).invalid == 0);
}

TEST_CASE("one element that is not certified valid, and nothing is committed") {
    const auto b = shell_block<2>({4, 3}, 1);
    auto proposal = straight_proposal(b);
    auto nodes = take(proposal.mid_nodes);
    std::size_t broken = 0;
    while (b.kinds[broken] != EdgeKind::volume) ++broken;
    nodes[broken].point += 10.0 * Vec<2>{{1, 1}};
    proposal.mid_nodes = nodes;
    const auto validation = must(validate(b.mesh, proposal, 1e-12, alone));
    REQUIRE(validation.invalid > 0);
    const auto committed = commit(b.mesh, proposal, validation);
    REQUIRE(!committed.has_value());
    CHECK(committed.error().kind == ErrorKind::input);
    REQUIRE(committed.error().entity.has_value());
    CHECK(committed.error().entity->kind == "triangle");
    const ElementId named(static_cast<std::size_t>(committed.error().entity->number - 1));
    CHECK(validation.verdicts[named] != Verdict::valid);
    // Who wants to see it may.
    CHECK(must(commit_unvalidated(b.mesh, proposal)).mid_nodes == proposal.mid_nodes);
}

TEST_CASE("verdicts and nodes of another mesh are refused") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto other = shell_block<2>({2, 2}, 1);
    const auto proposal = straight_proposal(b);
    const auto validation = must(validate(b.mesh, proposal, 1e-12, alone));
    CHECK(!commit(other.mesh, proposal, validation).has_value());
    CHECK(!commit(b.mesh, straight_proposal(other), validation).has_value());
    CHECK(!commit_unvalidated(b.mesh, straight_proposal(other)).has_value());
}

TEST_CASE("committed, then committed again with its own nodes: nothing changes") {
    const auto b = shell_block<2>({4, 3}, 2);
    const auto proposal = must(curve_boundary(b.mesh, b.kinds, b.boundary_nodes, alone)).proposal;
    const auto once = must(commit(b.mesh, proposal, must(validate(b.mesh, proposal, 1e-12, alone))));
    const auto twice = must(commit(once, proposal, must(validate(once, proposal, 1e-12, alone))));
    CHECK(once == twice);
}
