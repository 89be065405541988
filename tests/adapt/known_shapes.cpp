// Shapes stored with a mesh between passes are bitwise those of its elements. In degree 2 stored lengths are those of
// its edges.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

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

/// Checks the stored shapes and returns their number.
template <int D>
std::size_t expect_stored_shapes(const Adaptation<D>& r) {
    std::size_t known = 0;
    for (std::size_t e = 0; e < r.shapes.size(); ++e) {
        if (r.mesh.is_free(ElementId(e)) || r.shapes[e] < 0) continue;
        RC_ASSERT(r.shapes[e] == shape_of(r, ElementId(e)));
        ++known;
    }
    return known;
}

/// Lengths are compared up to rounding: packs of edges use another order of operations than single edges.
template <int D>
void expect_stored_lengths(const Adaptation<D>& r) {
    RC_ASSERT(r.lengths.size() == (r.mesh.is_curved() ? r.mesh.edges.size() : 0));
    for (std::size_t e = 0; e < r.lengths.size(); ++e)
        if (!r.mesh.is_free(EdgeId(e)))
            RC_ASSERT(std::abs(r.lengths[e] - measured_length(r, EdgeId(e))) <= 1e-9 * r.lengths[e]);
}

template <int D>
void expect_shapes(Adaptation<D> r, const AdaptationGoal<D>& goal) {
    for (int round = 0; round < 2; ++round) {
        r = must(swap<D>(std::move(r), goal, {.target_quality = 1}, one_thread)).state;
        RC_ASSERT(expect_stored_shapes(r) == r.mesh.element_count());
        r = must(smooth<D>(std::move(r), goal, {.target_quality = 1}, one_thread)).state;
        RC_ASSERT(expect_stored_shapes(r) == r.mesh.element_count());
        r = must(collapse<D>(std::move(r), goal, {}, one_thread)).state;
        expect_stored_shapes(r);
        r = must(split<D>(std::move(r), goal, {}, one_thread)).state;
        expect_stored_shapes(r);
        expect_stored_lengths(r);
        r = must(mend<D>(std::move(r), goal, {.target_quality = 0.9}, one_thread)).state;
        expect_stored_shapes(r);
        expect_stored_lengths(r);
    }
}

template <int D>
void check_straight(std::uint64_t seed) {
    const auto [state, goal] = straight_domain<D>(seed);
    expect_shapes(state, goal);
}

template <int D>
void check_curved(std::uint64_t seed) {
    Dice dice(seed);
    BowedDomain<D> domain = bowed_domain(random_domain<D>(seed), dice);
    expect_shapes(std::move(domain.state), domain.goal);
}

}  // namespace

TEST_CASE("stored shapes and lengths equal those of the elements and edges after each pass") {
    property("2D", [](std::uint64_t seed) { check_straight<2>(seed); }, {.count = 20});
    property("3D", [](std::uint64_t seed) { check_straight<3>(seed); }, {.count = 6});
    property("2D, degree 2", [](std::uint64_t seed) { check_curved<2>(seed); }, {.count = 6});
    property("3D, degree 2", [](std::uint64_t seed) { check_curved<3>(seed); }, {.count = 2});
}
