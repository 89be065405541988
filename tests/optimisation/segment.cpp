#include <doctest/doctest.h>

#include <algorithm>
#include <optional>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

double value(const AffineConstraint& c, double theta) { return c.at_0 + theta * (c.at_1 - c.at_0) - c.floor; }

double lowest(const std::vector<AffineConstraint>& constraints, double theta) {
    double low = 1e300;
    for (const auto& c : constraints) low = std::min(low, value(c, theta));
    return low;
}

std::vector<AffineConstraint> some_constraints(std::mt19937_64& random) {
    std::vector<AffineConstraint> constraints(1 + random() % 40);
    for (auto& c : constraints) c = {uniform(random, -0.5, 2), uniform(random, -0.5, 2), uniform(random, -0.3, 0.3)};
    return constraints;
}

}  // namespace

TEST_CASE("segment programs agree with samples") {
    property("feasible returns exactly the interval where all constraints hold",
             [] {
                 auto random = random_source();
                 const auto constraints = some_constraints(random);
                 const auto interval = feasible(constraints);
                 for (int i = 0; i <= 200; ++i) {
                     const double theta = i / 200.0;
                     const double low = lowest(constraints, theta);
                     if (low > 1e-12) RC_ASSERT(interval && interval->low <= theta && theta <= interval->high);
                     if (low < -1e-12)
                         RC_ASSERT(!interval || theta < interval->low + 1e-9 || theta > interval->high - 1e-9);
                 }
             },
             {300});
    property("highest_minimum: no sampled position has a higher minimum",
             [] {
                 auto random = random_source();
                 const auto constraints = some_constraints(random);
                 const double a = uniform(random, 0, 1);
                 const double b = uniform(random, 0, 1);
                 const SegmentInterval within{std::min(a, b), std::max(a, b)};
                 const double theta = max_min_parameter(constraints, within);
                 RC_ASSERT(within.low <= theta && theta <= within.high);
                 const double top = lowest(constraints, theta);
                 for (int i = 0; i <= 200; ++i)
                     RC_ASSERT(lowest(constraints, within.low + (within.high - within.low) * i / 200.0) <= top + 1e-12);
             },
             {300});
}

TEST_CASE("segment programs handle empty constraints and end points") {
    CHECK(feasible({}).has_value());
    CHECK(max_min_parameter({}, {0.25, 0.5}) == 0.5);
    const std::vector<AffineConstraint> never{{-1, -1, 0}};
    CHECK_FALSE(feasible(never).has_value());
    const std::vector<AffineConstraint> at_the_end{{-1, 0, 0}};
    REQUIRE(feasible(at_the_end).has_value());
    CHECK(feasible(at_the_end)->low == 1);
}
