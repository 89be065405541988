// Analytic surfaces as geometry.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

double coordinate(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 100001) / 100000.0; }
Vec<3> point_in(double low, double high) {
    return {{coordinate(low, high), coordinate(low, high), coordinate(low, high)}};
}

const Execution one_thread{.threads = 1};

}  // namespace

TEST_CASE("closest points on analytic surfaces are idempotent and minimal") {
    const std::vector<AnalyticSurface<3>> surfaces{
        Plane<3>{{{0.1, 0.2, 0.3}}, {{1, 2, -1}}}, Sphere<3>{{{0.1, 0, 0}}, 1.3},
        Cylinder{{{0, 0.2, 0}}, {{1, 1, 3}}, 0.8}, Torus{{{0, 0, 0.1}}, {{0.2, 0.1, 1}}, 1.2, 0.3}};
    camber::testing::property("projection of a foot returns it, and the normal points along the distance",
                              [&] {
                                  const auto& surface = *rc::gen::elementOf(surfaces);
                                  const Vec<3> p = point_in(-3, 3);
                                  const auto foot = closest_point<3>(surface, p);
                                  RC_ASSERT(distance(closest_point<3>(surface, foot.point).point, foot.point) < 1e-13);
                                  RC_ASSERT(std::fabs(norm(foot.normal) - 1) < 1e-14);
                                  RC_ASSERT(norm(cross(p - foot.point, foot.normal)) < 1e-12);
                              },
                              {.count = 400});
    camber::testing::property(
        "no foot of another point is nearer",
        [&] {
            const auto& surface = *rc::gen::elementOf(surfaces);
            const Vec<3> p = point_in(-3, 3);
            const auto other = closest_point<3>(surface, point_in(-3, 3));
            RC_ASSERT(distance(closest_point<3>(surface, p).point, p) <= distance(other.point, p) + 1e-13);
        },
        {.count = 400});
}

TEST_CASE("closest points are exact on axis-aligned planes and defined at centres and axes") {
    const auto foot = closest_point<3>(Plane<3>{{{0, 0, 0.1}}, {{0, 0, -2}}}, Vec<3>{{0.3, 0.7, 12.34}});
    CHECK(foot.point == Vec<3>{{0.3, 0.7, 0.1}});
    for (const AnalyticSurface<3>& surface :
         {AnalyticSurface<3>(Sphere<3>{{}, 2}), AnalyticSurface<3>(Cylinder{{}, {{0, 1, 0}}, 2})})
        CHECK(distance(closest_point<3>(surface, Vec<3>{}).point, Vec<3>{}) == doctest::Approx(2));
}

TEST_CASE("a surface that does not fit the mesh is rejected with the farthest vertex") {
    camber::testing::property(
        "a sphere with a wrong radius or centre is rejected with its farthest vertex",
        [] {
            const auto mesh = sphere(3, 5, static_cast<unsigned>(*rc::gen::inRange(1, 100))).mesh();
            const double wrong = *rc::gen::element(-1, 1) * coordinate(0.6, 4.5);
            const auto fits = [&](const Vec<3>& centre, double radius) {
                return check_fit<3>(mesh, {{{1, Sphere<3>{centre, radius}}}}, one_thread);
            };
            RC_ASSERT(fits({}, 5).has_value());
            RC_ASSERT(fits({{0, 0.02, 0}}, 5.02).has_value());  // edges are about 2.5 long
            for (const auto& found : {fits({}, 5 + wrong), fits({{0, wrong, 0}}, 5)}) {
                RC_ASSERT(!found.has_value());
                RC_ASSERT(found.error().kind == ErrorKind::input);
                RC_ASSERT(found.error().entity.has_value());
                RC_ASSERT(found.error().entity->kind == "vertex");
            }
            // The reported vertex has the largest distance from the shifted sphere.
            const auto beside = fits({{0, wrong, 0}}, 5);
            const auto off = [&](const Vec<3>& p) { return std::fabs(norm(p - Vec<3>{{0, wrong, 0}}) - 5); };
            const double named = off(mesh.points[beside.error().entity->number - 1]);
            for (const Vec<3>& p : mesh.points) RC_ASSERT(off(p) <= named + 1e-12);
        },
        {.count = 30});
    const auto found = check_fit<3>(sphere(3, 5).mesh(), {{{1, Sphere<3>{{}, 4}}}}, one_thread);
    REQUIRE_FALSE(found.has_value());
    CHECK(found.error().what.starts_with("is 1 away from the sphere of reference 1, "));
    CHECK(found.error().what.find(" vertices of the mesh on the sphere of reference 1 are off by more than 5 %") < 200);
}

TEST_CASE("check_fit accepts a few vertices that are slightly off the surface") {
    const auto fits = [&](double share, std::size_t vertices) {
        auto mesh = sphere(5, 5).mesh();
        Buffer<Vec<3>> points(mesh.points.begin(), mesh.points.end());
        const auto& [a, b, c] = mesh.facets.vertices[0];
        const double edge = distance(points[a.index()], points[b.index()]);
        for (std::size_t v = 0; v < vertices; ++v) points[v] = (1 - share * edge / 5) * points[v];
        mesh.points = std::move(points);
        return check_fit<3>(mesh, {{{1, Sphere<3>{{}, 5}}}}, one_thread).has_value();
    };
    CHECK(fits(0.2, 1));  // of 152 vertices
    CHECK(fits(0.005, 150));
    CHECK_FALSE(fits(1.5, 1));
    CHECK_FALSE(fits(0.2, 100));
}

namespace {

/// Checks the edges of facets against the sphere of this radius about the origin; vertices may be off it.
template <int D>
void check_no_cusps(const LinearMesh<D>& linear, double radius) {
    const auto b = build(linear);
    const AnalyticGeometry<D> geometry{{{1, Sphere<D>{{}, radius}}}};
    const auto nodes = boundary_nodes(b.mesh, b.features, Geometry<D>(geometry), one_thread).value();
    for (std::size_t f = 0; f < linear.facets.size(); ++f)
        for (const EdgeId e : b.mesh.edges.of_facets[f]) {
            const auto& [low, high] = b.mesh.edges.vertices[e];
            const Vec<D>&p = linear.points[low], &q = linear.points[high], &node = nodes[e.index()].point;
            const Vec<D> leaves = 4 * node - 3 * p - q, arrives = 3 * q + p - 4 * node;
            const double length = distance(p, q);
            CHECK(dot(leaves, arrives) >= -1e-12 * length * length);  // the tangent turns by at most 90 degrees
            // The edge is nearly straight, nearly parallel to the surface, or has the maximum bow.
            const double ends = 0.5 * (norm(p) + norm(q)), middle = norm(midpoint(p, q)), limit = off_limit * length;
            const double bow = norm(node) - middle, parallel = radius + (ends - radius) / ends * middle - middle;
            CHECK((std::fabs(bow) <= 1.001 * limit || std::fabs(bow - parallel) <= 1.001 * limit ||
                   std::fabs(bow) >= 0.249 * length));
            if (std::fabs(ends - radius) <= off_limit * length) CHECK(std::fabs(norm(node) - radius) <= 1e-13 * radius);
        }
}

}  // namespace

TEST_CASE("edges at vertices off the surface have no cusps") {
    for (const double share : {-0.6, -0.3, -0.1, -0.04, 0.0, 0.04, 0.1, 0.3, 0.6}) {  // of the edge length
        CAPTURE(share);
        for (const int n : {5, 8, 30}) {
            Soup<2> rim;
            for (int i = 0; i < n; ++i) {
                rim.points.push_back({{std::cos(2 * pi * i / n), std::sin(2 * pi * i / n)}});
                rim.facets.push_back({static_cast<std::size_t>(i), static_cast<std::size_t>((i + 1) % n)});
            }
            check_no_cusps<2>(rim.mesh(), 1 + share * 2 * std::sin(pi / n));
        }
        for (const std::size_t n : {2, 5}) {
            const auto mesh = sphere(n, 1).mesh();
            const auto& [a, b, c] = mesh.facets.vertices[0];
            check_no_cusps<3>(mesh, 1 + share * distance(mesh.points[a], mesh.points[b]));
        }
    }
}

TEST_CASE("invalid analytic surfaces are rejected") {
    const auto mesh = sphere(2, 5).mesh();
    const auto message = [&](const AnalyticGeometry<3>& geometry) {
        const auto found = check_fit<3>(mesh, geometry, one_thread);
        return found ? std::string() : describe(found.error());
    };
    const Sphere<3> right{{}, 5};
    CHECK(message({{{1, right}}}).empty());
    CHECK(message({}).empty());
    CHECK(message({{{1, right}, {7, right}}}) == "no boundary triangle of the mesh has reference 7 (it has 1)");
    CHECK(message({{{1, right}, {1, Plane<3>{{}, {{0, 0, 1}}}}}}) ==
          "reference 1 is assigned to two surfaces (list each reference once)");
    for (const double radius : {1e300, 1e12, -1.0, std::nan(""), HUGE_VAL})
        CHECK(message({{{1, Sphere<3>{{{-radius, 0, 0}}, radius}}}})
                  .starts_with("reference 1: the radius of its sphere, "));
    CHECK(message({{{1, Cylinder{{}, {{0, 0, 1}}, 1e300}}}}).find("out of range for a boundary of size 1") < 80);
    CHECK(message({{{1, Plane<3>{{{1e300, 0, 0}}, {{1, 1, 0}}}}}}).find("away from the plane of reference 1") < 60);
    const auto square = polygon({{{1, 0}}, {{0, 1}}, {{-1, 0}}, {{0, -1}}}).mesh();
    CHECK(check_fit<2>(square, {{{1, Sphere<2>{{}, 1}}}}, one_thread).has_value());
    CHECK_FALSE(check_fit<2>(square, {{{1, Sphere<2>{{}, 1.2}}}}, one_thread).has_value());
}

TEST_CASE("boundary nodes of a half cylinder lie on its cylinder and its planes") {
    auto mesh = half_cylinder(12, 5).mesh();
    auto linear = build(mesh);
    Buffer<Reference> references(mesh.facets.size());
    for (std::size_t f = 0; f < references.size(); ++f)
        references[f] = static_cast<Reference>(linear.features.patches[f]) + 1;
    mesh.facets.references = std::move(references);
    const auto b = build(mesh);
    AnalyticGeometry<3> geometry;
    std::vector<bool> flat;
    for (std::size_t p = 0; p < b.features.patch_count; ++p) flat.push_back(b.surrogate.flats[p].is_flat());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!flat[b.features.patches[f]])
            geometry.surfaces = {{mesh.facets.references[f], Cylinder{{}, {{0, 0, 1}}, 1}}};
    // The planes are not prescribed; beside the cylinder they are taken from the mesh.
    const auto nodes = boundary_nodes(b.mesh, b.features, Geometry<3>(geometry), one_thread).value();
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const EdgeId e : b.mesh.edges.of_facets[f]) {
            const Vec<3> p = nodes[e.index()].point;
            if (flat[b.features.patches[f]]) {
                const auto& plane = b.surrogate.flats[b.features.patches[f]];
                CHECK(plane.axis >= 0);
                CHECK(p[static_cast<std::size_t>(plane.axis)] == plane.point[static_cast<std::size_t>(plane.axis)]);
            } else {
                CHECK(std::fabs(std::hypot(p[0], p[1]) - 1) < 1e-14);
            }
        }
    const auto d = boundary_distance<3>(b.mesh, nodes, b.features, Geometry<3>(geometry), one_thread).value();
    CHECK(d.largest > 0);
    CHECK(d.largest < 1e-3);
    const auto straight =
        boundary_distance<3>(b.mesh, b.mesh.mid_nodes.view(), b.features, Geometry<3>(geometry), one_thread).value();
    CHECK(straight.largest > 5e-3);
}

TEST_CASE("straight geometry keeps nodes at the chord midpoints") {
    const auto b = build(torus(10, 1, 0.4).mesh());
    const auto nodes = boundary_nodes(b.mesh, b.features, Geometry<3>(StraightGeometry<3>{}), one_thread).value();
    for (std::size_t e = 0; e < nodes.size(); ++e) CHECK(nodes[e] == b.mesh.mid_nodes[e]);
    CHECK(boundary_distance<3>(b.mesh, nodes, b.features, Geometry<3>(StraightGeometry<3>{}), one_thread)
              .value()
              .largest < 1e-15);
    CHECK(boundary_distance<3>(b.mesh, b.nodes, b.features, Geometry<3>(StraightGeometry<3>{}), one_thread)
              .value()
              .largest > 1e-2);
    CHECK(project<3>(Geometry<3>(StraightGeometry<3>{}), {}, Vec<3>{{1, 2, 3}}).point == Vec<3>{{1, 2, 3}});
}
