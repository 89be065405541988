// What a facet knows of its corners: one side of each seam, and something at poles.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

const Geometry<3> globe(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 2}}}});
const Geometry<3> ring(AnalyticGeometry<3>{{{1, Torus{{}, {{0, 0, 1}}, 3, 1}}}});
const Geometry<2> circle(AnalyticGeometry<2>{{{1, Sphere<2>{{}, 2}}}});

Vec<3> on_globe(double longitude, double latitude) {
    return globe->evaluate(GeometryEntity::surface(0), {{longitude, latitude}})->point;
}
Vec<3> on_ring(double u, double v) { return ring->evaluate(GeometryEntity::surface(0), {{u, v}})->point; }

constexpr double turn = 2 * std::numbers::pi;

}  // namespace

TEST_CASE("corners across a seam are seen from one side of it") {
    const FacetSite<3> facet{{}, 1, {on_globe(3.1, 0.1), on_globe(-3.1, 0.1), on_globe(-3.1, 0.2)}};
    const auto seen = parameters_at_corners(globe, facet);
    REQUIRE(seen);
    CHECK((*seen)[0].u[0] == doctest::Approx(3.1));
    CHECK((*seen)[1].u[0] == doctest::Approx(turn - 3.1));
    CHECK((*seen)[2].u[0] == doctest::Approx(turn - 3.1));

    const FacetSite<3> of_ring{{}, 1, {on_ring(-3, 3), on_ring(3, 3), on_ring(3, -3)}};
    const auto both = parameters_at_corners(ring, of_ring);
    REQUIRE(both);
    CHECK((*both)[1].u[0] == doctest::Approx(3 - turn));
    CHECK((*both)[2].u[1] == doctest::Approx(turn - 3));

    const FacetSite<2> edge{{}, 1, {Vec<2>{{-2, 1e-3}}, Vec<2>{{-2, -1e-3}}}};
    const auto ends = parameters_at_corners(circle, edge);
    REQUIRE(ends);
    CHECK(std::abs((*ends)[0].u[0] - (*ends)[1].u[0]) < 0.01);
}

TEST_CASE("a corner at a pole has the longitude of the others") {
    const FacetSite<3> facet{{}, 1, {Vec<3>{{0, 0, 2}}, on_globe(1, 1.5), on_globe(1.5, 1.5)}};
    const auto seen = parameters_at_corners(globe, facet);
    REQUIRE(seen);
    CHECK((*seen)[0].u[0] == doctest::Approx(1.25));
    for (std::size_t i = 0; i < 3; ++i)
        CHECK(distance(globe->evaluate(GeometryEntity::surface(0), (*seen)[i])->point, facet.corners[i]) < 1e-14);
}

TEST_CASE("a facet without a surface knows nothing") {
    CHECK(!parameters_at_corners(globe, FacetSite<3>{{}, 2, {}}));
    CHECK(globe->periods({}) == std::array<double, 2>{0, 0});
}
