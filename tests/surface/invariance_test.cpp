// The surrogate moves, turns and scales with the mesh and does not depend on the number of threads.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

// The largest distance between the nodes of b and the image of those of a.
template <class Image>
double difference(const Built<3>& a, const Built<3>& b, Image&& image) {
    double worst = 0;
    for (std::size_t e = 0; e < a.nodes.size(); ++e)
        worst = std::fmax(worst, distance(image(a.nodes[e].point), b.nodes[e].point));
    for (std::size_t f = 0; f < a.surrogate.facets.size(); ++f)
        for (std::size_t c = 0; c < 10; ++c)
            worst =
                std::fmax(worst, distance(image(a.surrogate.facets[f].control[c]), b.surrogate.facets[f].control[c]));
    return worst;
}

}  // namespace

TEST_CASE("the surrogate moves with rotation, translation and scaling") {
    camber::testing::property(
        "nodes and control points move with the mesh",
        [] {
            const auto seed = static_cast<unsigned>(*rc::gen::inRange(1, 1000));
            const double scale = std::pow(10.0, *rc::gen::inRange(-6, 7));
            const Vec<3> shift{{*rc::gen::inRange(-5, 6) * scale, *rc::gen::inRange(-5, 6) * scale, 0}};
            const auto image = [&](const Vec<3>& p) { return scale * rotated(p) + shift; };
            const auto soup = *rc::gen::element(0, 1) == 0 ? torus(12, 1, 0.5, seed) : half_cylinder(12, 4, seed);
            const auto a = build(soup.mesh());
            const auto b = build(transformed_soup(soup, image).mesh());
            RC_ASSERT(a.features == b.features);
            RC_ASSERT(difference(a, b, image) < 1e-10 * scale);
        },
        {.count = 20});
}

TEST_CASE("scaling by powers of two changes no digit of the surrogate") {
    camber::testing::property("nodes scale exactly, and features do not change",
                              [] {
                                  const auto seed = static_cast<unsigned>(*rc::gen::inRange(1, 1000));
                                  const int exponent = *rc::gen::element(-1, 1) * *rc::gen::inRange(200, 231);
                                  const auto image = [&](const Vec<3>& p) { return std::ldexp(1.0, exponent) * p; };
                                  const auto soup =
                                      *rc::gen::element(0, 1) == 0 ? torus(8, 1, 0.5, seed) : half_cylinder(8, 4, seed);
                                  const auto a = build(soup.mesh());
                                  const auto b = build(transformed_soup(soup, image).mesh());
                                  RC_ASSERT(a.features == b.features);
                                  RC_ASSERT(difference(a, b, image) == 0);
                              },
                              {.count = 12});
}

TEST_CASE("the surrogate far from the origin is accurate to rounding") {
    const Vec<3> shift{{1e6, -1e6, 1e6}};
    const auto image = [&](const Vec<3>& p) { return p + shift; };
    for (const auto& soup : {torus(16, 1, 0.5), half_cylinder(16, 6)}) {
        const auto a = build(soup.mesh());
        const auto b = build(transformed_soup(soup, image).mesh());
        CHECK(a.features == b.features);
        CHECK(difference(a, b, image) < 1e-8);
        CHECK(std::fabs(distance_of(a).largest - distance_of(b).largest) < 1e-8);
    }
    const auto b = build(transformed_soup(cube(4), image).mesh());
    for (std::size_t e = 0; e < b.nodes.size(); ++e) REQUIRE(b.nodes[e] == b.mesh.mid_nodes[e]);
}

TEST_CASE("surrogate and distances do not depend on the number of threads") {
    const auto mesh = half_cylinder(24, 8).mesh();
    const auto one = build(mesh, {}, {.threads = 1}), four = build(mesh, {}, {.threads = 4});
    CHECK(one.features == four.features);
    CHECK(one.nodes == four.nodes);
    CHECK(one.surrogate.facets == four.surrogate.facets);
    CHECK(one.surrogate.edge_curves == four.surrogate.edge_curves);
    const auto distance_with = [&](int threads) {
        return boundary_distance<3>(one.mesh, one.nodes, one.features, Geometry<3>(one.surrogate), {.threads = threads})
            .value();
    };
    CHECK(distance_with(1).largest == distance_with(4).largest);
    CHECK(distance_with(1).mean == distance_with(4).mean);
}
