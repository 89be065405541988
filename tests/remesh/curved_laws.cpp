// The laws of the operator of degree 2 by random operations: `./x laws` runs them whole.
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.dynamic;
import camber.surface;
import camber.validity;
import camber.remesh;

#include "curved_runs.hpp"
#include "sanitized.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void expect_laws(std::uint64_t domains, std::size_t least) {
    CurvedTally<D> tally;
    for (std::uint64_t seed = 1; seed <= domains; ++seed) CHECK(CurvedRun<D>(seed, {}).run(tally) == "");
    CHECK(tally.least() >= least);
}

}  // namespace

TEST_CASE("random operations on bowed meshes keep all laws, in 2D") {
    // Of these two seeds splits are among elements whose straight shapes are flat, or inverted.
    CurvedTally<2> tally;
    CHECK(CurvedRun<2>(63, {}).run(tally) == "");
    expect_laws<2>(less_if_sanitized(100, 10), less_if_sanitized(300, 20));
}

TEST_CASE("random operations on bowed meshes keep all laws, in 3D") {
    CurvedTally<3> tally;
    CHECK(CurvedRun<3>(481, {}).run(tally) == "");
    expect_laws<3>(less_if_sanitized(40, 2), less_if_sanitized(20, 0));
}
