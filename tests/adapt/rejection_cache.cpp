// Passes do not repeat rejected operations until a neighbouring element changes. A repetition would be rejected again.
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

/// Repeats a pass until it accepts nothing, then once more with the cached rejections cleared.
template <int D, class Options>
Adaptation<D> run_until_rejected(Adaptation<D> r, const AdaptationGoal<D>& goal, Verb<D, Options> verb) {
    constexpr int max_runs = 100;
    std::size_t accepted = 1;
    for (int run = 0; run < max_runs && accepted > 0; ++run) {
        auto result = must(verb(std::move(r), goal, {}, one_thread));
        accepted = result.statistics.accepted;
        r = std::move(result.state);
    }
    RC_ASSERT(accepted == 0U);
    RC_ASSERT(must(verb(r, goal, {}, one_thread)).statistics.planned == 0U);
    Adaptation<D> cleared = r;
    cleared.rejection_cache.forget();
    cleared.shapes = {};
    RC_ASSERT(must(verb(std::move(cleared), goal, {}, one_thread)).statistics.accepted == 0U);
    return r;
}

template <int D>
void check_passes(Adaptation<D> r, const AdaptationGoal<D>& goal) {
    for (int round = 0; round < 2; ++round) {
        r = run_until_rejected<D, CollapseOptions>(std::move(r), goal, &collapse<D>);
        r = must(split<D>(std::move(r), goal, {}, one_thread)).state;
        r = run_until_rejected<D, SwapOptions>(std::move(r), goal, &swap<D>);
        r = run_until_rejected<D, SmoothOptions>(std::move(r), goal, &smooth<D>);
    }
}

template <int D>
void check_straight(std::uint64_t seed) {
    const auto [state, goal] = straight_domain<D>(seed);
    check_passes(state, goal);
    run_until_rejected<D, MendOptions>(state, goal, &mend<D>);
}

template <int D>
void check_curved(std::uint64_t seed) {
    Dice dice(seed);
    BowedDomain<D> domain = bowed_domain(random_domain<D>(seed), dice);
    check_passes(std::move(domain.state), domain.goal);
}

}  // namespace

TEST_CASE("a cached rejection agrees with a new evaluation of the operation") {
    property("2D", [](std::uint64_t seed) { check_straight<2>(seed); }, {.count = 20});
    property("3D", [](std::uint64_t seed) { check_straight<3>(seed); }, {.count = 6});
    property("2D, degree 2", [](std::uint64_t seed) { check_curved<2>(seed); }, {.count = 6});
    property("3D, degree 2", [](std::uint64_t seed) { check_curved<3>(seed); }, {.count = 2});
}

TEST_CASE("changed limits clear the cached rejections of a pass") {
    RejectionCache rejection_cache;
    const std::vector<VertexId> ids{VertexId(std::size_t{1})};
    rejection_cache.begin(CachedPass::smooth, {0.8});
    rejection_cache.refuse<VertexTag>(CachedPass::smooth, ids, 3);
    CHECK(rejection_cache.is_rejected(CachedPass::smooth, ids[0], ids));
    CHECK_FALSE(rejection_cache.is_rejected(CachedPass::swap, ids[0], ids));
    CHECK_FALSE(rejection_cache.is_rejected(CachedPass::smooth, VertexId(std::size_t{2}), ids));
    rejection_cache.begin(CachedPass::smooth, {0.8});
    CHECK(rejection_cache.is_rejected(CachedPass::smooth, ids[0], ids));
    rejection_cache.begin(CachedPass::smooth, {0.7});
    CHECK_FALSE(rejection_cache.is_rejected(CachedPass::smooth, ids[0], ids));
}
