// The error of the surrogate converges at its theoretical order on known surfaces and irregular meshes, with normals
// from the mesh only.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>

#include "meshes.hpp"
#include "sanitized.hpp"

using namespace surface_tests;

namespace {

// Orders of the larger error of two meshes; one mesh under the sanitizers.
struct Orders {
    double edges, surrogate, quadratic;
    Errors coarse, fine;
};

template <class Make>
Orders orders(Make&& make, const AnalyticSurface<3>& surface, std::size_t coarse, std::size_t fine) {
    const auto measured = [&](std::size_t n) {
        Errors worst;
        for (const unsigned seed : {1U, 2U}) {
            if (camber::testing::is_sanitized && seed > 1) break;
            const auto b = build(make(n, seed).mesh());
            const auto e = errors(b, off_surface(surface));
            worst.edges = std::fmax(worst.edges, e.edges);
            worst.surrogate = std::fmax(worst.surrogate, e.surrogate);
            worst.quadratic = std::fmax(worst.quadratic, e.quadratic);
            worst.straight = std::fmax(worst.straight, e.straight);
        }
        return worst;
    };
    Orders o;
    o.coarse = measured(coarse);
    o.fine = measured(fine);
    const double size = std::log(static_cast<double>(fine) / static_cast<double>(coarse));
    o.edges = std::log(o.coarse.edges / o.fine.edges) / size;
    o.surrogate = std::log(o.coarse.surrogate / o.fine.surrogate) / size;
    o.quadratic = std::log(o.coarse.quadratic / o.fine.quadratic) / size;
    MESSAGE("orders: mid nodes " << o.edges << ", P3 " << o.surrogate << ", P2 " << o.quadratic
                                 << "; fine: straight/P2 " << o.fine.straight / o.fine.quadratic);
    return o;
}

}  // namespace

TEST_CASE("on a torus nodes and P3 surface converge with order 4, the P2 surface with order 3") {
    const auto o = orders([](std::size_t n, unsigned seed) { return torus(n, 1, 0.4, seed); },
                          Torus{{}, {{0, 0, 1}}, 1, 0.4}, 24, 60);
    CHECK(o.edges > 3.5);
    CHECK(o.surrogate > 3.5);
    CHECK(o.quadratic > 2.5);
    CHECK(o.fine.straight > 60 * o.fine.quadratic);
}

TEST_CASE("on a sphere nodes and P3 surface converge with order 4, the P2 surface with order 3") {
    const auto o = orders([](std::size_t n, unsigned seed) { return sphere(n, 1, seed); }, Sphere<3>{{}, 1}, 8, 16);
    CHECK(o.edges > 3.7);
    CHECK(o.surrogate > 3.7);
    CHECK(o.quadratic > 3.0);
    CHECK(o.fine.straight > 300 * o.fine.quadratic);
}

TEST_CASE("on a cylinder with open rims nodes and P3 surface converge with order 4") {
    const auto o = orders([](std::size_t n, unsigned seed) { return tube(2 * n, n, 1, seed); },
                          Cylinder{{}, {{0, 0, 1}}, 1}, 20, 44);
    CHECK(o.edges > 3.5);
    CHECK(o.surrogate > 3.5);
    CHECK(o.fine.straight > 100 * o.fine.quadratic);
}

TEST_CASE("triangles of aspect ratio 100 on a cylinder are curved accurately") {
    SUBCASE("long edges along the axis") {
        const auto b = build(tube(240, 4, 1).mesh());
        const auto e = errors(b, off_surface(Cylinder{{}, {{0, 0, 1}}, 1}));
        CHECK(e.straight > 100 * e.quadratic);
        CHECK(e.straight > 100 * e.surrogate);
    }
    SUBCASE("long edges around the axis") {
        // The sagitta h²/8 is well below the width, otherwise the flat triangles do not follow the surface.
        auto soup = grid_mesh({.n = 30, .m = 60, .grading = 0}, [](double u, double v) {
            const double a = 0.3 * u;
            return Vec<3>{{std::cos(a), std::sin(a), 0.006 * v}};
        });
        const auto b = build(soup.mesh());
        CHECK(b.features.patch_count == 1);
        const auto e = errors(b, off_surface(Cylinder{{}, {{0, 0, 1}}, 1}));
        CHECK(e.straight > 20 * e.quadratic);
        CHECK(e.straight > 20 * e.surrogate);
    }
}

TEST_CASE("curved triangles are as near to the surrogate as to the surface") {
    const auto b = build(sphere(12, 1).mesh());
    const auto e = errors(b, off_surface(Sphere<3>{{}, 1}));
    const auto d = distance_of(b);
    CHECK(d.largest < e.quadratic + e.surrogate + 1e-15);
    CHECK(d.mean <= d.largest);
    CHECK(d.mean > 0);
    CHECK(d.worst.valid());
}
