// What passes asked for in vain they do not ask for again, and would ask in vain: nothing near has changed.
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.adapt;

#include "bowed.hpp"
#include "dice.hpp"
#include "domains.hpp"
#include "goals.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

template <int D, class Options>
using Verb = Outcome<Adapted<D>> (*)(Adaptation<D>, const AdaptationGoal<D>&, const Options&, const Execution&);

/// A pass again and again until it finds nothing to do, and then once more with all that was refused forgotten.
template <int D, class Options>
Adaptation<D> settled(Adaptation<D> r, const AdaptationGoal<D>& goal, Verb<D, Options> verb) {
    constexpr int enough = 100;
    std::size_t accepted = 1;
    for (int turn = 0; turn < enough && accepted > 0; ++turn) {
        auto done = must(verb(std::move(r), goal, {}, alone));
        accepted = done.statistics.accepted;
        r = std::move(done.state);
    }
    RC_ASSERT(accepted == 0U);
    RC_ASSERT(must(verb(r, goal, {}, alone)).statistics.planned == 0U);
    Adaptation<D> fresh = r;
    fresh.refusals.forget();
    fresh.shapes = {};
    RC_ASSERT(must(verb(std::move(fresh), goal, {}, alone)).statistics.accepted == 0U);
    return r;
}

template <int D>
void expect_right(Adaptation<D> r, const AdaptationGoal<D>& goal) {
    for (int round = 0; round < 2; ++round) {
        r = settled<D, CollapseOptions>(std::move(r), goal, &collapse<D>);
        r = must(split<D>(std::move(r), goal, {}, alone)).state;
        r = settled<D, SwapOptions>(std::move(r), goal, &swap<D>);
        r = settled<D, SmoothOptions>(std::move(r), goal, &smooth<D>);
    }
}

template <int D>
void of_straight(std::uint64_t seed) {
    const auto [state, goal] = straight_domain<D>(seed);
    expect_right(state, goal);
    settled<D, MendOptions>(state, goal, &mend<D>);
}

template <int D>
void of_curved(std::uint64_t seed) {
    Dice dice(seed);
    BowedDomain<D> domain = bowed_domain(random_domain<D>(seed), dice);
    expect_right(std::move(domain.state), domain.goal);
}

}  // namespace

TEST_CASE("what stands refused would be refused again") {
    property("2D", [](std::uint64_t seed) { of_straight<2>(seed); }, {.count = 20});
    property("3D", [](std::uint64_t seed) { of_straight<3>(seed); }, {.count = 6});
    property("2D, degree 2", [](std::uint64_t seed) { of_curved<2>(seed); }, {.count = 6});
    property("3D, degree 2", [](std::uint64_t seed) { of_curved<3>(seed); }, {.count = 2});
}

TEST_CASE("limits that are others forget what was refused") {
    Refusals refusals;
    const std::vector<VertexId> ids{VertexId(std::size_t{1})};
    refusals.begin(AskingPass::smooth, {0.8});
    refusals.refuse<VertexTag>(AskingPass::smooth, ids, 3);
    CHECK(refusals.stands(AskingPass::smooth, ids[0], ids));
    CHECK_FALSE(refusals.stands(AskingPass::swap, ids[0], ids));
    CHECK_FALSE(refusals.stands(AskingPass::smooth, VertexId(std::size_t{2}), ids));
    refusals.begin(AskingPass::smooth, {0.8});
    CHECK(refusals.stands(AskingPass::smooth, ids[0], ids));
    refusals.begin(AskingPass::smooth, {0.7});
    CHECK_FALSE(refusals.stands(AskingPass::smooth, ids[0], ids));
}
