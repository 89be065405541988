#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "property.hpp"

import camber.recipes;
import camber.reports;

using camber::run::estimated_peak_bytes;
using camber::run::expected_growth;

namespace {

constexpr double longest_edge = std::numbers::sqrt2;  // upper limit of unit edge lengths

}  // namespace

TEST_CASE("the estimated peak memory grows with the mesh") {
    camber::testing::property("the estimated peak does not decrease with more vertices or elements", [] {
        const auto vertices = *rc::gen::arbitrary<unsigned>(), elements = *rc::gen::arbitrary<unsigned>();
        const auto more = *rc::gen::arbitrary<unsigned>();
        for (const int dimension : {2, 3}) {
            const std::size_t here = estimated_peak_bytes(vertices, elements, dimension);
            RC_ASSERT(estimated_peak_bytes(std::size_t{vertices} + more, elements, dimension) >= here);
            RC_ASSERT(estimated_peak_bytes(vertices, std::size_t{elements} + more, dimension) >= here);
        }
    });
}

// The expected values were measured with two threads.
TEST_CASE("the estimated peak memory is within 10 % of measured peaks") {
    CHECK(estimated_peak_bytes(278, 1141, 3) == doctest::Approx(10.39e6).epsilon(0.1));
    CHECK(estimated_peak_bytes(46144, 267840, 3) == doctest::Approx(121.1e6).epsilon(0.1));
    CHECK(estimated_peak_bytes(172086, 1008000, 3) == doctest::Approx(414.4e6).epsilon(0.1));
    CHECK(estimated_peak_bytes(845388, 4998000, 3) == doctest::Approx(1784e6).epsilon(0.1));
    CHECK(estimated_peak_bytes(151054, 300731, 2) == doctest::Approx(110.4e6).epsilon(0.1));
    CHECK(estimated_peak_bytes(1501439, 2998523, 2) == doctest::Approx(1108e6).epsilon(0.1));
}

TEST_CASE("the estimated peak memory of huge meshes does not overflow") {
    constexpr std::size_t all = std::numeric_limits<std::size_t>::max();
    CHECK(estimated_peak_bytes(all, all, 3) > std::size_t{1} << 62U);
}

// The expected values were measured with one thread.
TEST_CASE("expected elements and peak memory of splitting are within 10 to 20 % of measured ones") {
    CHECK(expected_growth(8000, longest_edge, 1296, 3, 1).elements == doctest::Approx(101289).epsilon(0.1));
    CHECK(expected_growth(8000, longest_edge, 1296, 3, 1).peak_bytes == doctest::Approx(45.9e6).epsilon(0.2));
    CHECK(expected_growth(23323.6, longest_edge, 1296, 3, 1).peak_bytes == doctest::Approx(97.1e6).epsilon(0.2));
    CHECK(expected_growth(46138, longest_edge, 1000, 2, 1).elements == doctest::Approx(120752).epsilon(0.1));
    CHECK(expected_growth(46138, longest_edge, 1000, 2, 1).peak_bytes == doctest::Approx(54.9e6).epsilon(0.1));
    CHECK(expected_growth(5416, longest_edge, 2000, 3, 2).peak_bytes == doctest::Approx(44.8e6).epsilon(0.1));
}

TEST_CASE("half the edge length gives eight times the tetrahedra and four times the triangles") {
    for (const int dimension : {2, 3})
        CHECK(expected_growth(100, longest_edge / 2, 0, dimension, 1).elements ==
              doctest::Approx(std::pow(2, dimension) * expected_growth(100, longest_edge, 0, dimension, 1).elements));
}

TEST_CASE("the expected peak memory of huge meshes does not overflow") {
    CHECK(expected_growth(1e300, 1e-30, 0, 3, 1).peak_bytes > std::size_t{1} << 62U);
    CHECK(expected_growth(std::numeric_limits<double>::infinity(), longest_edge, 0, 2, 1).peak_bytes > std::size_t{1}
                                                                                                           << 62U);
}
