#include <doctest/doctest.h>

#include <cstddef>
#include <limits>

#include "property.hpp"

import camber.run;

using camber::run::estimated_peak_bytes;

TEST_CASE("the estimate of a run's memory") {
    camber::testing::property("grows with the mesh", [](unsigned vertices, unsigned elements, unsigned more) {
        for (const int dimension : {2, 3}) {
            const std::size_t here = estimated_peak_bytes(vertices, elements, dimension);
            RC_ASSERT(estimated_peak_bytes(std::size_t{vertices} + more, elements, dimension) >= here);
            RC_ASSERT(estimated_peak_bytes(vertices, std::size_t{elements} + more, dimension) >= here);
        }
    });
    SUBCASE("peaks measured with two threads") {
        CHECK(estimated_peak_bytes(278, 1141, 3) == doctest::Approx(10.39e6).epsilon(0.1));
        CHECK(estimated_peak_bytes(19379, 102979, 3) == doctest::Approx(50.16e6).epsilon(0.1));
        CHECK(estimated_peak_bytes(54936, 317520, 3) == doctest::Approx(118.25e6).epsilon(0.1));
        CHECK(estimated_peak_bytes(185193, 1053696, 3) == doctest::Approx(379.63e6).epsilon(0.1));
        CHECK(estimated_peak_bytes(368574, 2163840, 3) == doctest::Approx(711.41e6).epsilon(0.1));
        CHECK(estimated_peak_bytes(361201, 720000, 2) == doctest::Approx(223.74e6).epsilon(0.1));
    }
    SUBCASE("sizes beyond all memory do not wrap around") {
        constexpr std::size_t all = std::numeric_limits<std::size_t>::max();
        CHECK(estimated_peak_bytes(all, all, 3) > std::size_t{1} << 62U);
    }
}
