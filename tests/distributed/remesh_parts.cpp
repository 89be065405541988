// Cutting a mesh into parts and joining them returns the same mesh.
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "dynamic_measures.hpp"
#include "goals.hpp"
#include "property.hpp"
#include "thread_ranks.hpp"

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

/// A mesh in parts, as stored on one rank.
template <int D>
CutMesh<D> cut(const AdaptationRows<D>& rows, std::size_t elements, double shift, Ranks& ranks) {
    auto shared = must(share_of(rows, ranks));
    const auto weights = must(expected_elements(shared.rows, 1, one_thread));
    return must(cut_into_parts(std::move(shared), weights, elements, shift, ranks, one_thread));
}

template <int D>
void cut_and_joined(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.5, dice);
    const Adaptation<D> before = start_adaptation(mesh, goal);
    const auto ranks = one_rank();
    auto parts = cut(must(rows_of(before)), 1 + dice.below(30), dice.uniform(0, 1), *ranks);
    std::size_t all = 0;
    for (const auto& part : parts.parts) {
        RC_ASSERT(!part.elements.empty());
        all += part.elements.size();
    }
    RC_ASSERT(all == before.mesh.element_count());
    const auto after = must(assembled(must(gathered(must(joined(std::move(parts), *ranks)), *ranks)), one_thread));
    const auto consistent = check_consistency(after.state.mesh, one_thread);
    if (!consistent) RC_FAIL(describe(consistent.error()));
    RC_ASSERT(by_places(after.state.mesh) == by_places(before.mesh));
    RC_ASSERT(after.rim_lines == 0);
    for (const std::uint8_t on_rim : after.on_rim) RC_ASSERT(on_rim == 0);
}

template <int K>
void expect_same(const Buffer<AdaptedSimplex<K>>& a, const Buffer<AdaptedSimplex<K>>& b) {
    RC_ASSERT(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        RC_ASSERT(a[i].vertices == b[i].vertices);
        RC_ASSERT(a[i].reference == b[i].reference);
        RC_ASSERT(a[i].marks == b[i].marks);
        RC_ASSERT(a[i].sides == b[i].sides);
    }
}
template <int D>
void expect_same(const AdaptationRows<D>& a, const AdaptationRows<D>& b) {
    RC_ASSERT(a.vertices.size() == b.vertices.size());
    for (std::size_t v = 0; v < a.vertices.size(); ++v) {
        RC_ASSERT(a.vertices[v].number == b.vertices[v].number);
        RC_ASSERT(a.vertices[v].point == b.vertices[v].point);
        RC_ASSERT(a.vertices[v].state == b.vertices[v].state);
    }
    expect_same(a.elements, b.elements);
    expect_same(a.facets, b.facets);
    expect_same(a.lines, b.lines);
}

/// Parts of a rank in two iterations without passes, then the whole mesh.
template <int D>
struct TwoIterations {
    std::vector<AdaptationRows<D>> first, second;
    AdaptationRows<D> whole;
};
template <int D>
Outcome<TwoIterations<D>> two_iterations(const AdaptationRows<D>& rows, std::size_t elements, double shift,
                                         Ranks& ranks) {
    TwoIterations<D> out;
    auto parts = cut(rows, elements, shift, ranks);
    out.first = parts.parts;
    for (auto& one : parts.parts) one = must(rows_of_part(must(assembled(one, one_thread)), one));
    auto shared = must(joined(std::move(parts), ranks));
    const auto weights = must(expected_elements(shared.rows, 1, one_thread));
    parts = must(cut_into_parts(std::move(shared), weights, elements + 3, 1 - shift, ranks, one_thread));
    out.second = parts.parts;
    for (auto& one : parts.parts) one = must(rows_of_part(must(assembled(one, one_thread)), one));
    out.whole = must(gathered(must(joined(std::move(parts), ranks)), ranks));
    return out;
}

/// Ranks together have the same parts as one rank, and each has the same mesh in the end.
template <int D>
void parts_among_ranks(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.5, dice);
    const auto rows = must(rows_of(start_adaptation(mesh, goal)));
    const std::size_t elements = 1 + dice.below(30);
    const double shift = dice.uniform(0, 1);
    const auto ranks = one_rank();
    const auto by_one = must(two_iterations(rows, elements, shift, *ranks));
    for (const std::size_t count : {2U, 3U, 5U}) {
        const auto results = on_ranks(count, [&](Ranks& rank) { return two_iterations(rows, elements, shift, rank); });
        std::size_t first = 0, second = 0;
        for (const auto& one : results) {
            for (const auto& part : one->first) expect_same(part, by_one.first.at(first++));
            for (const auto& part : one->second) expect_same(part, by_one.second.at(second++));
            expect_same(one->whole, by_one.whole);
        }
        RC_ASSERT(first == by_one.first.size());
        RC_ASSERT(second == by_one.second.size());
    }
}

template <int D>
void parts_without_passes(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.5, dice);
    const Adaptation<D> before = start_adaptation(mesh, goal);
    const auto ranks = one_rank();
    auto parts = cut(must(rows_of(before)), 1 + dice.below(30), dice.uniform(0, 1), *ranks);
    for (auto& rows : parts.parts) rows = must(rows_of_part(must(assembled(rows, one_thread)), rows));
    const auto after = must(assembled(must(gathered(must(joined(std::move(parts), *ranks)), *ranks)), one_thread));
    RC_ASSERT(by_places(after.state.mesh) == by_places(before.mesh));
    // States and marks agree as well: nothing of the rim remains.
    const auto count = [](const DynamicMesh<D>& m) {
        std::size_t corners = 0, required = 0, frozen = 0;
        for (std::size_t v = 0; v < m.points.size(); ++v) {
            corners += m.states[v].place == VertexPlace::corner ? 1 : 0;
            required += m.states[v].marks.has(Mark::required) ? 1 : 0;
            frozen += m.states[v].marks.has(Mark::frozen) ? 1 : 0;
        }
        for (std::size_t f = 0; f < m.facets.size(); ++f) frozen += m.facets.marks[f].has(Mark::frozen) ? 1 : 0;
        for (std::size_t f = 0; f < m.facets.size(); ++f) required += m.facets.marks[f].has(Mark::required) ? 1 : 0;
        return std::array{corners, required, frozen};
    };
    RC_ASSERT(count(after.state.mesh) == count(before.mesh));
}

}  // namespace

TEST_CASE("cutting and joining a mesh returns the same mesh") {
    property("2D", [](std::uint64_t seed) { cut_and_joined<2>(seed); }, {.count = 60});
    property("3D", [](std::uint64_t seed) { cut_and_joined<3>(seed); }, {.count = 30});
}

TEST_CASE("joining unchanged parts returns the same mesh, states and marks") {
    property("2D", [](std::uint64_t seed) { parts_without_passes<2>(seed); }, {.count = 60});
    property("3D", [](std::uint64_t seed) { parts_without_passes<3>(seed); }, {.count = 30});
}

TEST_CASE("several ranks have the same parts and the same mesh as one rank") {
    property("2D", [](std::uint64_t seed) { parts_among_ranks<2>(seed); }, {.count = 20});
    property("3D", [](std::uint64_t seed) { parts_among_ranks<3>(seed); }, {.count = 10});
}
