// Property tests of the operator of degree 2 by random operations. The program `curved_invariants` runs more of them.
#include <cstddef>
#include <cstdint>
#include <string>

#include <doctest/doctest.h>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.validity;
import camber.operation;
import camber.adapt;

#include "curved_runs.hpp"
#include "sanitized.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void expect_invariants(std::uint64_t domains, std::size_t least) {
    CurvedTally<D> tally;
    for (std::uint64_t seed = 1; seed <= domains; ++seed) CHECK(CurvedRun<D>(seed, {}).run(tally) == "");
    CHECK(tally.least() >= least);
    std::size_t bent_around = 0;
    for (const auto& row : tally.rows) bent_around += row.bent_around;
    if (!is_sanitized) CHECK(bent_around > 0);  // a sanitized run has too few domains
}

template <int D>
std::string broken_invariant(std::uint64_t seed) {
    CurvedTally<D> tally;
    return CurvedRun<D>(seed, {}).run(tally);
}

}  // namespace

TEST_CASE("random operations on curved meshes satisfy all invariants of the operator, 2D") {
    expect_invariants<2>(less_if_sanitized(40, 4), less_if_sanitized(150, 0));
}

TEST_CASE("random operations on curved meshes satisfy all invariants of the operator, 3D") {
    expect_invariants<3>(less_if_sanitized(16, 1), less_if_sanitized(6, 0));
}

TEST_CASE("splits and reinsertions keep curves next to elements with flat or inverted straight shapes") {
    for (const std::uint64_t seed : {377, 5018}) CHECK(broken_invariant<2>(seed) == "");
    for (const std::uint64_t seed : {6330, 20190}) CHECK(broken_invariant<3>(seed) == "");
}
