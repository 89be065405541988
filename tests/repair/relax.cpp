#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

import camber.core;
import camber.bezier;
import camber.crossing;
import camber.metric;
import camber.validity;
import camber.optimisation;
import camber.curving;
import camber.repair;

#include "generators.hpp"
#include "sanitized.hpp"

using namespace camber;
using namespace generators;
using camber::testing::less_if_sanitized;
using camber::testing::property;

namespace {

constexpr double bound = 1e-12;

template <int D>
JudgedProposal<D> judged(const Planned<D>& p) {
    return validate(p.mesh, p.proposal, bound, Execution{1}).value();
}

template <int D>
Repaired<D> relaxed(const Planned<D>& p, RepairMethod method, int threads = 1) {
    RepairOptions options;
    options.min_scaled_jacobian = bound;
    options.method = method;
    return relax(judged(p), options, Execution{threads}).value();
}

/// Checks that each node lies between the middle of its chord and its proposed position, and that the statistics are
/// correct.
template <int D>
void check_nodes(const Planned<D>& p, const Repaired<D>& r) {
    const Proposal<D>& result = r.judged.proposal();
    std::size_t volume = 0;
    std::size_t surface = 0;
    for (std::size_t e = 0; e < p.mesh.edges.size(); ++e) {
        const Vec<D> before = p.proposal.mid_nodes[e].point;
        const Vec<D> after = result.mid_nodes[e].point;
        const Vec<D> middle = p.mesh.mid_nodes[e].point;
        RC_ASSERT(result.kinds[e] == p.proposal.kinds[e]);
        if (before == after) {
            RC_ASSERT(result.changes[e] == p.proposal.changes[e]);
            continue;
        }
        ++(p.proposal.kinds[e] == EdgeKind::volume ? volume : surface);
        RC_ASSERT(result.changes[e] == (after == middle ? EdgeChange::straightened : EdgeChange::relaxed));
        RC_ASSERT(std::abs(distance(before, after) + distance(after, middle) - distance(before, middle)) < 1e-12);
    }
    RC_ASSERT(r.statistics.moved_volume_nodes == volume);
    RC_ASSERT(r.statistics.moved_surface_nodes == surface);
}

template <int D>
void check_relaxation(const Planned<D>& p, RepairMethod method) {
    const auto before = judged(p).validation();
    const auto r = relaxed(p, method);
    const Validation<D>& after = r.judged.validation();
    RC_ASSERT(after.all_valid());
    RC_ASSERT(r.statistics.corrected_elements == before.invalid + before.undecided);
    check_nodes(p, r);
    const auto again = validate(p.mesh, r.judged.proposal(), bound, Execution{1}).value().validation();
    RC_ASSERT(again.verdicts == after.verdicts);
    RC_ASSERT(again.straight_inverted == after.straight_inverted);
    RC_ASSERT(std::abs(again.smallest - after.smallest) <= scaled_jacobian_tolerance);
}

template <int D>
void test_ends_valid(RepairMethod method) {
    property(std::string("relax returns a valid mesh and correct statistics, ") + std::to_string(D) + "D, " +
                 (method == RepairMethod::segment ? "shell" : "paper"),
             [method] {
                 auto random = random_source();
                 const double volume = uniform(random, 0, 0.6);
                 const double surface = uniform(random, 0, 0.4);
                 check_relaxation(planned<D>(random, D == 2 ? 8 : 3, volume, surface), method);
             },
             {D == 2 ? 40 : 20});
}

/// Boundary nodes are displaced so little that the mesh with straight volume edges is valid.
template <int D>
void test_surface_spared() {
    property("relax keeps nodes of surface edges where volume edges suffice, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 const auto p = planned<D>(random, D == 2 ? 8 : 3, uniform(random, 0, 0.4), 0.02);
                 RC_ASSERT(relaxed(p, RepairMethod::segment).statistics.moved_surface_nodes == 0);
                 RC_ASSERT(relaxed(p, RepairMethod::backtracking).statistics.moved_surface_nodes == 0);
             },
             {20});
}

template <int D>
double total_displacement(const Planned<D>& p, const Repaired<D>& r) {
    double sum = 0;
    for (std::size_t e = 0; e < p.mesh.edges.size(); ++e)
        sum += distance(r.judged.proposal().mid_nodes[e].point, p.mesh.mid_nodes[e].point);
    return sum;
}

template <int D>
void test_segments_keep_more() {
    std::mt19937_64 random(3);
    const auto p = planned<D>(random, D == 2 ? 20 : 6, 0.25, 0.1);
    const auto shell = relaxed(p, RepairMethod::segment);
    const auto paper = relaxed(p, RepairMethod::backtracking);
    CHECK(shell.statistics.corrected_elements > 0);
    CHECK(shell.statistics.moved_volume_nodes < paper.statistics.moved_volume_nodes);
    CHECK(total_displacement(p, shell) > total_displacement(p, paper));
}

template <int D>
void test_threads() {
    std::mt19937_64 random(5);
    const auto p = planned<D>(random, less_if_sanitized(D == 2 ? 30 : 7, D == 2 ? 15 : 4), 0.3, 0.2);
    for (const auto method : {RepairMethod::segment, RepairMethod::backtracking}) {
        const auto one = relaxed(p, method, 1);
        const auto two = relaxed(p, method, 2);
        CHECK(one.judged == two.judged);
    }
}

template <int D>
std::size_t crossing_in(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& nodes) {
    return find_crossings<D>(mesh, mesh.linear.points.view(), nodes.view(), Execution{1}).value().crossing;
}

/// True if facets cross. Pairs that the search over all pairs left undecided are searched again without its work limit.
template <int D>
bool any_cross(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& nodes) {
    const auto points = mesh.linear.points.view();
    const auto found = find_crossings<D>(mesh, points, nodes.view(), Execution{1}).value();
    return std::ranges::any_of(found.found, [&](const FacetCrossing& pair) {
        if (pair.verdict != Crossing::undecided) return pair.verdict == Crossing::crossing;
        const auto first = nodal_facet<D>(mesh, points, nodes.view(), pair.first);
        if (pair.first == pair.second) return crossing_of_itself(first) == Crossing::crossing;
        return crossing_of(first, nodal_facet<D>(mesh, points, nodes.view(), pair.second)) == Crossing::crossing;
    });
}

/// Checks that nodes of crossing facets lie between the middles of their chords and their positions, and that no facets
/// cross.
template <int D>
void check_uncrossing(std::mt19937_64& random, int n, double surface) {
    const Planned<D> p = planned<D>(random, n, 0, surface);
    const Proposal<D>& proposal = p.proposal;
    const auto found = uncrossed_nodes<D>(p.mesh, p.mesh.linear.points.view(), proposal.mid_nodes.view(),
                                          proposal.kinds.view(), Execution{1})
                           .value();
    Buffer<LagrangeNode<D>> nodes(proposal.mid_nodes.begin(), proposal.mid_nodes.end());
    for (const auto& [edge, node] : found.nodes) {
        const Vec<D> before = proposal.mid_nodes[edge].point, middle = p.mesh.mid_nodes[edge].point;
        RC_ASSERT(proposal.kinds[edge] == EdgeKind::surface);
        RC_ASSERT(node != proposal.mid_nodes[edge]);
        RC_ASSERT(std::abs(distance(before, node.point) + distance(node.point, middle) - distance(before, middle)) <
                  1e-12);
        nodes[edge.index()] = node;
    }
    RC_ASSERT(crossing_in<D>(p.mesh, nodes) == 0);
    RC_ASSERT(found.crossings.crossing == 0);
    RC_ASSERT(found.nodes.empty() == (crossing_in<D>(p.mesh, proposal.mid_nodes) == 0));
    RC_CLASSIFY(!found.nodes.empty(), "walls crossed");
    // Moving any of them back by one step of the search makes facets cross.
    for (const auto& [edge, node] : found.nodes) {
        const Vec<D> middle = p.mesh.mid_nodes[edge].point;
        auto farther = nodes;
        farther[edge.index()].point += (1.0 / 256) * (proposal.mid_nodes[edge].point - middle);
        RC_ASSERT(any_cross<D>(p.mesh, farther));
    }
}

}  // namespace

TEST_CASE("relax returns a valid mesh and correct statistics") {
    test_ends_valid<2>(RepairMethod::segment);
    test_ends_valid<2>(RepairMethod::backtracking);
    test_ends_valid<3>(RepairMethod::segment);
    test_ends_valid<3>(RepairMethod::backtracking);
}

TEST_CASE("relax keeps nodes of surface edges where volume edges suffice") {
    test_surface_spared<2>();
    test_surface_spared<3>();
}

TEST_CASE("relaxation by segments keeps more curvature than backtracking") {
    test_segments_keep_more<2>();
    test_segments_keep_more<3>();
}

TEST_CASE("relax does not depend on the number of threads") {
    test_threads<2>();
    test_threads<3>();
}

TEST_CASE("relax does not change a valid mesh") {
    std::mt19937_64 random(2);
    const auto p = planned<3>(random, 3, 0.02, 0.02);
    const auto r = relaxed(p, RepairMethod::segment);
    CHECK(r.judged.proposal() == p.proposal);
    CHECK(r.statistics.corrected_elements == 0);
    CHECK(r.statistics.moved_volume_nodes == 0);
    CHECK(r.statistics.moved_surface_nodes == 0);
}

TEST_CASE("relax reports elements that are inverted when straight") {
    // Two vertices of one element are swapped: it is inverted, its neighbours are not.
    std::mt19937_64 random(2);
    auto p = planned<2>(random, 4, 0.1, 0);
    auto vertices = take(p.mesh.linear.elements.vertices);
    std::swap(vertices[9][0], vertices[9][1]);
    p.mesh.linear.elements.vertices = vertices;
    auto edges = take(p.mesh.edges.of_elements);
    std::swap(edges[9][1], edges[9][2]);
    p.mesh.edges.of_elements = edges;
    for (const auto method : {RepairMethod::segment, RepairMethod::backtracking}) {
        const auto r = relaxed(p, method);
        CHECK(r.judged.validation().invalid == 1);
        CHECK(r.judged.validation().straight_inverted == 1);
        CHECK(r.judged.validation().verdicts[9] == Verdict::invalid);
    }
}

TEST_CASE("relax rejects options out of range") {
    std::mt19937_64 random(2);
    const auto p = planned<2>(random, 3, 0.5, 0);
    const auto refused = [&](RepairOptions options) {
        const auto r = relax(judged(p), options, Execution{1});
        REQUIRE_FALSE(r.has_value());
        CHECK(r.error().kind == ErrorKind::usage);
        return r.error().what;
    };
    RepairOptions options;
    options.theta = 1;
    CHECK(refused(options) == "theta must be above 0 and below 1, got 1");
    options = {};
    options.min_scaled_jacobian = 1;
    refused(options);
    options = {};
    options.max_corrections = 0;
    refused(options);
}

TEST_CASE("relaxation of crossing walls ends as soon as none cross") {
    property("relaxation removes all crossings and no more than that, 2D",
             [] {
                 std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
                 check_uncrossing<2>(random, *rc::gen::inRange(1, 4), 1.2);
             },
             {.count = less_if_sanitized(20, 4)});
    property("relaxation removes all crossings and no more than that, 3D",
             [] {
                 std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
                 check_uncrossing<3>(random, 1, 0.8);
             },
             {.count = less_if_sanitized(3, 1)});
}
