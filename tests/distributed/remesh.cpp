// A mesh brought to a metric block by block: the domain and its features stay, and where blocks met it is as good as
// anywhere.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "dynamic_measures.hpp"
#include "goals.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.distributed;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void expect_same_domain(const DynamicMesh<D>& mesh, const Sizes& expected) {
    const auto consistent = check_consistency(mesh, alone);
    if (!consistent) RC_FAIL(describe(consistent.error()));
    const Sizes now = measures(mesh);
    RC_ASSERT(now.size() == expected.size());
    for (const auto& [key, value] : expected) RC_ASSERT(std::abs(now.at(key) - value) < 1e-8);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e))) RC_ASSERT(volume_of(mesh, mesh.elements.vertices[e]) > 0);
}

template <int D>
std::size_t corners_of(const DynamicMesh<D>& mesh) {
    std::size_t n = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        n += !mesh.is_free(VertexId(v)) && mesh.states[v].place == VertexPlace::corner ? 1 : 0;
    return n;
}

template <int D>
BroughtToMetric<D> by_blocks(Adaptation<D> r, const AdaptationGoal<D>& goal, std::size_t elements,
                             const Execution& execution) {
    const ToMetricOptions options;
    return must(bring_to_metric_by_blocks(std::move(r), goal, options, elements, block_turns<D>(options),
                                          plainly(execution)));
}

template <int D>
void brought_to_a_metric(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, dice.uniform(0.35, 1.5), dice);
    const Adaptation<D> r = begun(mesh, goal);
    const Sizes domain = measures(r.mesh);
    const std::size_t corners = corners_of(r.mesh);
    const auto [state, told] = by_blocks(r, goal, 1 + dice.below(60), alone);
    expect_same_domain(state.mesh, domain);
    RC_ASSERT(corners_of(state.mesh) == corners);
    RC_ASSERT(told.after.unit_share() >= told.before.unit_share() - 0.1);
    for (std::size_t v = 0; v < state.mesh.points.size(); ++v) {
        RC_ASSERT(!state.mesh.is_free(VertexId(v)));
        const auto sample = sample_value(goal.field, state.mesh.points[v], state.vertices.metrics[v].back);
        const Sym<D> difference = sample.log_metric.l - state.vertices.metrics[v].log_metric.l;
        RC_ASSERT(inner(difference, difference) < 1e-16);
    }
}

}  // namespace

TEST_CASE("blocks keep the domain and its features") {
    property("2D", [](std::uint64_t seed) { brought_to_a_metric<2>(seed); }, {.count = 30});
    property("3D", [](std::uint64_t seed) { brought_to_a_metric<3>(seed); }, {.count = 10});
}

TEST_CASE("blocks give the same mesh for any number of threads") {
    const LinearMesh<3> mesh = random_domain<3>(5);
    Dice dice(5);
    const AdaptationGoal<3> goal = goal_over(mesh, 0.3, dice);
    const auto by_one = by_blocks(begun(mesh, goal), goal, 300, {.threads = 1});
    const auto by_two = by_blocks(begun(mesh, goal), goal, 300, {.threads = 2});
    CHECK(by_one.statistics.split.accepted > 100);
    CHECK(by_one.statistics.split == by_two.statistics.split);
    CHECK(by_one.state.mesh.points == by_two.state.mesh.points);
    CHECK(by_one.state.mesh.elements == by_two.state.mesh.elements);
    CHECK(by_one.state.mesh.facets == by_two.state.mesh.facets);
    CHECK(by_one.state.mesh.edges == by_two.state.mesh.edges);
    CHECK(by_one.state.vertices.metrics == by_two.state.vertices.metrics);
}
