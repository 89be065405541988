// Closest points are never worse than brute force, for any start.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"
#include "sanitized.hpp"

using camber::testing::is_sanitized;
using camber::testing::less_if_sanitized;
using namespace surface_tests;

namespace {

double coordinate(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 100001) / 100000.0; }

Vec<3> point_in(double low, double high) {
    return {{coordinate(low, high), coordinate(low, high), coordinate(low, high)}};
}

double sampled_distance(const CubicSimplex<2, 3>& facet, const Vec<3>& p) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& alpha : multi_indices<12, 2>)
        least = std::fmin(least, distance(p, point_at(facet, {alpha[0] / 12.0, alpha[1] / 12.0, alpha[2] / 12.0})));
    return least;
}

}  // namespace

TEST_CASE("closest_on finds the nearest point of a cubic triangle") {
    camber::testing::property(
        "no sample is nearer than the foot, and the foot is at its coordinates",
        [] {
            CubicSimplex<2, 3> facet;
            for (std::size_t n = 0; n < 10; ++n) {
                const auto& alpha = multi_indices<3, 2>[n];
                facet.control[n] = Vec<3>{{alpha[1] / 3.0, alpha[2] / 3.0, 0}} + 0.12 * point_in(-1, 1);
            }
            const Vec<3> p = point_in(-1, 2);
            const auto foot = closest_on(facet, p);
            RC_ASSERT(std::sqrt(foot.distance_squared) <= sampled_distance(facet, p) + 1e-3);
            RC_ASSERT(distance(foot.point, point_at(facet, foot.xi)) < 1e-13);
            RC_ASSERT(std::fabs(distance(foot.point, p) - std::sqrt(foot.distance_squared)) < 1e-13);
            for (const double x : foot.xi) RC_ASSERT(x >= 0 && x <= 1);
        },
        {.count = 500});
    camber::testing::property(
        "no search on a slightly bent triangle ends nearer than the foot",
        [] {
            CubicSimplex<2, 3> facet;
            const double bend = coordinate(0, 0.08), narrow = coordinate(0.02, 1), size = std::exp(coordinate(-14, 14));
            for (std::size_t n = 0; n < 10; ++n) {
                const auto& alpha = multi_indices<3, 2>[n];
                const Vec<3> flat{{alpha[1] / 3.0 + alpha[2] / 6.0, narrow * alpha[2] / 3.0, 0}};
                const Vec<3> off = bend * point_in(-1, 1);
                facet.control[n] = size * (flat + Vec<3>{{off[0], narrow * off[1], off[2]}});
            }
            const Vec<3> p = size * point_in(-1, 2);
            const auto foot = closest_on(facet, p);
            for (int k = 0; k < 10; ++k) {
                const double u = coordinate(0, 1), v = coordinate(0, 1 - u);
                const auto other = closest_from(facet, p, {1 - u - v, u, v});
                RC_ASSERT(std::sqrt(foot.distance_squared) <= std::sqrt(other.distance_squared) + 1e-9 * size);
            }
        },
        {.count = 500});
    camber::testing::property(
        "a search never ends farther than its start",
        [] {
            CubicSimplex<2, 3> facet;  // any triangle, including folded ones
            for (auto& c : facet.control) c = point_in(-1, 1);
            const Vec<3> p = point_in(-2, 2);
            const double u = coordinate(0, 1), v = coordinate(0, 1 - u);
            const Barycentric<2> start{1 - u - v, u, v};
            const auto foot = closest_from(facet, p, start);
            RC_ASSERT(foot.distance_squared <= norm_squared(point_at(facet, start) - p) * (1 + 1e-14));
        },
        {.count = 500});
}

TEST_CASE("distances in packs equal those of single points for any instruction set") {
    camber::testing::property(
        "packed distances with an inner foot equal those of closest_from",
        [] {
            CubicSimplex<2, 3> facet;
            for (std::size_t n = 0; n < 10; ++n) {
                const auto& alpha = multi_indices<3, 2>[n];
                facet.control[n] = Vec<3>{{alpha[1] / 3.0, alpha[2] / 3.0, 0}} + 0.12 * point_in(-1, 1);
            }
            std::array<Barycentric<2>, 66> starts{};
            std::array<Vec<3>, 66> points;
            const double off = coordinate(0, 0.2);
            for (std::size_t n = 0; n < starts.size(); ++n) {
                const auto& alpha = multi_indices<10, 2>[n];
                starts[n] = {alpha[0] / 10.0, alpha[1] / 10.0, alpha[2] / 10.0};
                points[n] = point_at(facet, starts[n]) + off * point_in(-1, 1);
            }
            std::array<double, 66> found{};
            distances_inside(facet, starts, points, found, Instructions::baseline);
            for (std::size_t n = 0; n < starts.size(); ++n) {
                const auto foot = closest_from(facet, points[n], starts[n]);
                const double least = std::sqrt(foot.distance_squared);
                if (!std::isnan(found[n])) RC_ASSERT(std::fabs(found[n] - least) <= 1e-12);
                const bool inside = foot.xi[0] > 0.1 && foot.xi[1] > 0.1 && foot.xi[2] > 0.1;
                if (inside && least < 0.02) RC_ASSERT(!std::isnan(found[n]));
            }
            const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
            for (const Instructions set : {Instructions::baseline, Instructions::avx2, Instructions::avx512}) {
                if (!has(set)) continue;
                std::array<double, 66> again{};
                distances_inside(facet, starts, points, again, set);
                for (std::size_t n = 0; n < starts.size(); ++n) {
                    double single = 0;
                    distances_inside(facet, {&starts[n], 1}, {&points[n], 1}, {&single, 1}, set);
                    RC_ASSERT(same(again[n], found[n]));
                    RC_ASSERT(same(single, found[n]));
                }
            }
        },
        {.count = 100});
}

TEST_CASE("derivatives of a cubic triangle match finite differences") {
    camber::testing::property("first and second derivatives equal differences", [] {
        CubicSimplex<2, 3> facet;
        for (auto& c : facet.control) c = point_in(-1, 1);
        const double h = 1e-4;
        const auto at = [&](double u, double v) { return expand(facet, Barycentric<2>{1 - u - v, u, v}); };
        const auto x = at(0.3, 0.2);
        RC_ASSERT(distance(x.first[0], (at(0.3 + h, 0.2).point - at(0.3 - h, 0.2).point) / (2 * h)) < 1e-6);
        RC_ASSERT(distance(x.first[1], (at(0.3, 0.2 + h).point - at(0.3, 0.2 - h).point) / (2 * h)) < 1e-6);
        RC_ASSERT(distance(x.second[0][0], (at(0.3 + h, 0.2).first[0] - at(0.3 - h, 0.2).first[0]) / (2 * h)) < 1e-5);
        RC_ASSERT(distance(x.second[0][1], (at(0.3, 0.2 + h).first[0] - at(0.3, 0.2 - h).first[0]) / (2 * h)) < 1e-5);
        RC_ASSERT(distance(x.second[1][1], (at(0.3, 0.2 + h).first[1] - at(0.3, 0.2 - h).first[1]) / (2 * h)) < 1e-5);
    });
}

TEST_CASE("projection onto a surrogate finds the nearest point") {
    const auto b = build(torus(20, 1, 0.4).mesh());
    REQUIRE(b.features.ridge_edges == 0);
    const Geometry<3> geometry = b.surrogate;
    camber::testing::property("no sample of any facet is nearer than the projection",
                              [&] {
                                  const Vec<3> p = point_in(-1.6, 1.6);
                                  const auto found = project<3>(geometry, {}, p);
                                  double least = std::numeric_limits<double>::infinity();
                                  for (const auto& facet : b.surrogate.facets)
                                      least = std::fmin(least, sampled_distance(facet, p));
                                  RC_ASSERT(found.distance <= least + 1e-12);
                                  RC_ASSERT(std::fabs(distance(found.point, p) - found.distance) < 1e-12);
                              },
                              {.count = 60});
    camber::testing::property(
        "a walk from a neighbouring facet finds the result of the search",
        [&] {
            const double a = coordinate(0, 2 * pi), c = coordinate(0, 2 * pi), r = 1 + 0.41 * std::cos(c);
            const Vec<3> p{{r * std::cos(a), r * std::sin(a), 0.41 * std::sin(c)}};
            const auto found = project<3>(geometry, {}, p);
            for (const FacetId next : b.surrogate.neighbours[found.facet]) {
                RC_ASSERT(next.valid());
                const auto walked = project<3>(geometry, {.facet = next}, p);
                RC_ASSERT(std::fabs(walked.distance - found.distance) < 1e-9);
            }
            RC_ASSERT(std::fabs(dot(found.normal, p - found.point)) > (1 - 1e-3) * found.distance);
        },
        {.count = 200});
    camber::testing::property(
        "an initial candidate does not change the result of closest_among",
        [&] {
            const Vec<3> p = point_in(-1.6, 1.6);
            const auto all = [](FacetId) { return true; };
            const auto found = closest_among(b.surrogate, p, all);
            const FacetId start(static_cast<std::size_t>(*rc::gen::inRange<std::size_t>(0, b.surrogate.facets.size())));
            for (const FacetId known : {start, found.facet}) {
                const auto again = closest_among(b.surrogate, p, all, closest_near(b.surrogate, known, p));
                RC_ASSERT(again.facet.valid());
                RC_ASSERT(std::fabs(std::sqrt(again.distance_squared) - std::sqrt(found.distance_squared)) < 1e-12);
            }
        },
        {.count = 200});
    camber::testing::property(
        "a walk never ends farther than its first facet",
        [&] {
            const Vec<3> p = point_in(-2, 2);
            const FacetId start(static_cast<std::size_t>(*rc::gen::inRange<std::size_t>(0, b.surrogate.facets.size())));
            const auto walked = closest_near(b.surrogate, start, p);
            RC_ASSERT(std::sqrt(walked.distance_squared) <= sampled_distance(b.surrogate.facets[start], p) + 1e-3);
        },
        {.count = 200});
}

TEST_CASE("projection stops at open rims and respects references") {
    auto soup =
        welded({grid_mesh(
                    {.n = 6, .m = 6, .grading = 0}, [](double u, double v) { return Vec<3>{{u, v, 0}}; }, 1),
                grid_mesh({.n = 6, .m = 6, .grading = 0}, [](double u, double v) { return Vec<3>{{u, v, 1}}; }, 2)});
    const Geometry<3> geometry = build(soup.mesh()).surrogate;
    const auto rim = project<3>(geometry, {.reference = 1}, Vec<3>{{1.5, 0.5, 0.9}});
    CHECK(distance(rim.point, Vec<3>{{1, 0.5, 0}}) < 1e-12);
    const auto nearest = project<3>(geometry, {}, Vec<3>{{0.3, 0.3, 0.9}});
    CHECK(distance(nearest.point, Vec<3>{{0.3, 0.3, 1}}) < 1e-12);
    const auto none = project<3>(geometry, {.reference = 9}, Vec<3>{{0.3, 0.3, 0.9}});
    CHECK(none.point == Vec<3>{{0.3, 0.3, 0.9}});
    CHECK_FALSE(none.facet.valid());
}

TEST_CASE("closest_on_ridges finds the nearest point of the ridge curves") {
    const auto b = build(half_cylinder(20, 8).mesh());
    const auto foot = closest_on_ridges(b.surrogate, Vec<3>{{0.9, 0.9, 1.1}});
    CHECK(distance(foot.point, Vec<3>{{std::sqrt(0.5), std::sqrt(0.5), 1}}) < 1e-6);
    CHECK(closest_on_ridges(build(torus(12, 1, 0.5).mesh()).surrogate, Vec<3>{}).row > 0);
}

TEST_CASE("boundary nodes of another mesh are projected onto the surrogate") {
    const auto fine = build((is_sanitized ? half_cylinder(16, 6) : half_cylinder(32, 12)).mesh());
    const Geometry<3> geometry = fine.surrogate;
    const Execution execution{.threads = 1};
    const auto coarse = build((is_sanitized ? half_cylinder(8, 3, 7) : half_cylinder(16, 5, 7)).mesh());
    const auto nodes = boundary_nodes(coarse.mesh, coarse.features, geometry, execution).value();
    double worst = 0;
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const Vec<3> p = nodes[e].point;
        const double to_wall = std::fabs(std::hypot(p[0], p[1]) - 1);
        const double to_plane = std::fmin(std::fabs(p[1]), std::fmin(std::fabs(p[2]), std::fabs(p[2] - 1)));
        worst = std::fmax(worst, std::fmin(to_wall, to_plane));
    }
    CHECK(worst < less_if_sanitized(2e-5, 5e-4));
    const auto d = boundary_distance<3>(coarse.mesh, nodes, coarse.features, geometry, execution).value();
    CHECK(d.largest < less_if_sanitized(1e-3, 5e-3));
}

TEST_CASE("curves and distances do not depend on the facet numbers of another mesh") {
    const Geometry<3> geometry = PrescribedSurrogate<3>{build(torus(20, 1, 0.3, 5).mesh()).surrogate};
    const Execution execution{.threads = 1};
    auto coarse = build(torus(12, 1, 0.3).mesh());
    // The listed edges are edges of the surface and no ridges.
    const std::size_t listed = 100;
    Buffer<SimplexVertices<1>> ends(listed);
    Buffer<EdgeId> rows(listed);
    for (std::size_t i = 0; i < listed; ++i) {
        rows[i] = EdgeId(7 * i);
        ends[i] = coarse.mesh.edges.vertices[rows[i]];
    }
    coarse.mesh.linear.edges = {std::move(ends), Buffer<Reference>(listed, 0), {}};
    coarse.mesh.edges.of_edges = std::move(rows);
    const auto& [linear, edges, mid_nodes] = coarse.mesh;
    const auto curves = find_embedded_curves(linear, edges, coarse.features, geometry, {}, execution).value();
    REQUIRE(curves.edges.size() > listed - 5);  // the others are ridges
    const auto nodes = nodes_on_curves(coarse.mesh, Buffer<LagrangeNode<3>>(mid_nodes.begin(), mid_nodes.end()), curves,
                                       geometry, execution)
                           .value();
    for (const EdgeId e : curves.edges) {
        const auto& [a, b] = edges.vertices[e];
        const double chord = distance(linear.points[a], linear.points[b]);
        CHECK(distance(nodes[e.index()].point, midpoint(linear.points[a], linear.points[b])) < 0.3 * chord);
    }
    const Geometry<3> mixed = MixedGeometry<3>{{1}, geometry, AnalyticGeometry<3>{}};
    for (std::size_t f = 0; f < linear.facets.size(); ++f) {
        const FacetSite<3> facet = facet_site(linear, FacetId(f));
        const Vec<3> p = facet.corners[0];
        CHECK(geometry->distance_at_facets(std::span(&facet, 1), p) < 1e-3);
        CHECK(mixed->distance_at_facets(std::span(&facet, 1), p) < 1e-3);
    }
}
