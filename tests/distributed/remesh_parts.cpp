// A mesh cut into parts is the same mesh when they are joined, and a part changes within its rim.
#include <array>
#include <cstddef>
#include <cstdint>

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
void cut_and_joined(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.5, dice);
    const Adaptation<D> before = begun(mesh, goal);
    const auto rows = must(rows_of(before));
    const std::size_t elements = 1 + dice.below(30);
    const auto weights = must(expected_elements(rows, 1, alone));
    const auto cut = must(cut_into_parts(rows, weights, elements, dice.uniform(0, 1), alone));
    std::size_t all = 0;
    for (const auto& part : cut.parts) {
        RC_ASSERT(!part.elements.empty());
        all += part.elements.size();
    }
    RC_ASSERT(all == before.mesh.element_count());
    const auto after = must(assembled(must(joined(cut)).rows, alone));
    const auto consistent = check_consistency(after.state.mesh, alone);
    if (!consistent) RC_FAIL(describe(consistent.error()));
    RC_ASSERT(by_places(after.state.mesh) == by_places(before.mesh));
    RC_ASSERT(after.rim_lines == 0);
    for (const std::uint8_t on_rim : after.on_rim) RC_ASSERT(on_rim == 0);
}

template <int D>
void parts_without_passes(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    const AdaptationGoal<D> goal = goal_over(mesh, 0.5, dice);
    const Adaptation<D> before = begun(mesh, goal);
    const auto rows_before = must(rows_of(before));
    const auto weights = must(expected_elements(rows_before, 1, alone));
    auto cut = must(cut_into_parts(rows_before, weights, 1 + dice.below(30), dice.uniform(0, 1), alone));
    for (auto& rows : cut.parts) rows = must(rows_of_part(must(assembled(rows, alone)), rows));
    const auto after = must(assembled(must(joined(cut)).rows, alone));
    RC_ASSERT(by_places(after.state.mesh) == by_places(before.mesh));
    // States and marks, too: what was a rim is none any more.
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

TEST_CASE("a mesh that is cut and joined is the same mesh") {
    property("2D", [](std::uint64_t seed) { cut_and_joined<2>(seed); }, {.count = 60});
    property("3D", [](std::uint64_t seed) { cut_and_joined<3>(seed); }, {.count = 30});
}

TEST_CASE("parts that nothing was done to are the same mesh") {
    property("2D", [](std::uint64_t seed) { parts_without_passes<2>(seed); }, {.count = 60});
    property("3D", [](std::uint64_t seed) { parts_without_passes<3>(seed); }, {.count = 30});
}
