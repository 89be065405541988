// Planes stay planes, along an axis to the last bit. Ridges separate their sides.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

// The largest |n·(node − point)| of the mid nodes of a patch.
double off_patch(const Built<3>& b, std::uint32_t patch, const Vec<3>& point, const Vec<3>& normal) {
    double worst = 0;
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f)
        if (b.features.patches[f] == patch)
            for (const EdgeId e : b.mesh.edges.of_facets[f])
                worst = std::fmax(worst, std::fabs(dot(b.nodes[e.index()].point - point, normal)));
    return worst;
}

}  // namespace

TEST_CASE("nodes of a cube are the chord midpoints") {
    const auto b = build(cube(5).mesh());
    for (std::size_t e = 0; e < b.nodes.size(); ++e) REQUIRE(b.nodes[e] == b.mesh.mid_nodes[e]);
    CHECK(distance_of(b).largest == 0);
    const auto turned = build(transformed_soup(cube(5), rotated).mesh());
    for (std::size_t e = 0; e < turned.nodes.size(); ++e) REQUIRE(turned.nodes[e] == turned.mesh.mid_nodes[e]);
    CHECK(distance_of(turned).largest == 0);
}

TEST_CASE("nodes of a half cylinder are exact in its planes and on its arcs") {
    const auto b = build(half_cylinder(20, 8).mesh());
    std::size_t planes = 0;
    for (std::uint32_t patch = 0; patch < b.features.patch_count; ++patch) {
        const auto& flat = b.surrogate.flats[patch];
        if (!flat.is_flat()) continue;
        ++planes;
        CHECK(flat.axis >= 0);
        CHECK(off_patch(b, patch, flat.point, flat.normal) == 0);
    }
    CHECK(planes == 3);
    double ridge = 0, wall = 0;
    for (std::size_t e = 0; e < b.nodes.size(); ++e) {
        const auto& [low, high] = b.mesh.edges.vertices[e];
        const auto radius = [](const Vec<3>& p) { return std::hypot(p[0], p[1]); };
        const Vec<3> p = b.nodes[e].point, a = b.mesh.linear.points[low], c = b.mesh.linear.points[high];
        if (std::fabs(radius(a) - 1) > 1e-9 || std::fabs(radius(c) - 1) > 1e-9) continue;
        if (a[1] == 0 && c[1] == 0) {
            CHECK(p == midpoint(a, c));  // the straight ridges of the plane y = 0
            continue;
        }
        double& worst = b.features.edge_kinds[e] == EdgeKind::ridge ? ridge : wall;
        worst = std::fmax(worst, std::fabs(radius(p) - 1));
    }
    CHECK(ridge < 1e-14);  // a circle is exact
    CHECK(wall < 1e-4);    // 3e-3 with straight edges
}

TEST_CASE("nodes of a rotated half cylinder lie in its planes to rounding") {
    const auto b =
        build(transformed_soup(half_cylinder(20, 8), [](const Vec<3>& p) { return 3.0 * rotated(p); }).mesh());
    std::size_t planes = 0;
    for (std::uint32_t patch = 0; patch < b.features.patch_count; ++patch) {
        const auto& flat = b.surrogate.flats[patch];
        if (!flat.is_flat()) continue;
        ++planes;
        CHECK(off_patch(b, patch, flat.point, flat.normal) < 1e-14);
    }
    CHECK(planes == 3);
}

TEST_CASE("a plane that continues into a cylinder stays straight away from it") {
    // A sheet: flat for x < 0, then bent about the y axis.
    const auto sheet = [](double u, double v) {
        const double s = 2 * u - 1;
        return s <= 0 ? Vec<3>{{s, v, 0}} : Vec<3>{{std::sin(s), v, std::cos(s) - 1}};
    };
    const auto b = build(grid_mesh({.n = 24, .m = 12, .grading = 0}, sheet).mesh());
    CHECK(b.features.patch_count == 1);
    for (std::size_t e = 0; e < b.nodes.size(); ++e) {
        const auto& [low, high] = b.mesh.edges.vertices[e];
        if (b.mesh.linear.points[low][0] < -0.35 && b.mesh.linear.points[high][0] < -0.35)
            CHECK(b.nodes[e].point[2] == 0);
    }
}

TEST_CASE("required facets keep the chord midpoints") {
    auto mesh = torus(16, 1, 0.4).mesh();
    mesh.facets.required = Buffer<std::uint32_t>{3};
    const auto b = build(mesh);
    for (const EdgeId e : b.mesh.edges.of_facets[3]) CHECK(b.nodes[e.index()] == b.mesh.mid_nodes[e]);
    CHECK(b.nodes[b.mesh.edges.of_facets[40][0].index()] != b.mesh.mid_nodes[b.mesh.edges.of_facets[40][0]]);
}

TEST_CASE("two curved sides that meet in a ridge are both accurate") {
    // Two cylinders of radius 1 that meet in the line x = 0 and bend in opposite directions.
    const auto side = [](double sign) {
        return [sign](double u, double v) {
            const double a = 0.9 * u;
            return Vec<3>{{sign * (1 - std::cos(a)), v, std::sin(a)}};
        };
    };
    const Grid grid{.n = 10, .m = 8, .grading = 0};
    const auto b = build(welded({grid_mesh(grid, side(1), 1), grid_mesh(grid, side(-1), 2)}).mesh());
    CHECK(b.features.patch_count == 2);
    double worst = 0;
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f)
        for (const EdgeId e : b.mesh.edges.of_facets[f]) {
            const Vec<3> p = b.nodes[e.index()].point;
            const double sign = b.mesh.linear.facets.references[f] == 1 ? 1 : -1;
            if (std::fabs(p[0]) > 1e-12) worst = std::fmax(worst, std::fabs(std::hypot(sign - p[0], p[2]) - 1));
        }
    CHECK(worst < 3e-5);  // 1e-3 with straight edges
}

TEST_CASE("nodes slide only within planes") {
    const Vec<3> shift{{0.01, 0.02, 0.03}};
    const auto slide = [&](const Built<3>& b, const Geometry<3>& geometry) {
        const std::vector<Vec<3>> shifts(b.mesh.edges.size(), shift);
        Buffer<LagrangeNode<3>> nodes(b.nodes.begin(), b.nodes.end());
        return slid_nodes<3>(b.mesh, std::move(nodes), shifts, b.features, geometry, Execution{.threads = 1}).value();
    };
    for (const auto& soup : {cube(5), transformed_soup(cube(5), rotated)}) {
        const auto b = build(soup.mesh());
        const auto nodes = slide(b, Geometry<3>(b.surrogate));
        std::size_t slid = 0;
        for (std::size_t e = 0; e < nodes.size(); ++e) {
            if (b.features.edge_kinds[e] == EdgeKind::ridge) {
                REQUIRE(nodes[e] == b.nodes[e]);
                continue;
            }
            const Vec<3> moved = nodes[e].point - b.nodes[e].point;
            ++slid;
            // The difference between shift and move is normal to the plane, which contains the chord.
            CHECK(std::fabs(dot(moved, shift - moved)) < 1e-15);
            const auto& [low, high] = b.mesh.edges.vertices[e];
            CHECK(std::fabs(dot(shift - moved, b.mesh.linear.points[high] - b.mesh.linear.points[low])) < 1e-14);
        }
        CHECK(slid > 0);
    }
    const auto bent = build(torus(16, 1, 0.4).mesh());
    const auto unchanged = slide(bent, Geometry<3>(bent.surrogate));
    for (std::size_t e = 0; e < unchanged.size(); ++e) REQUIRE(unchanged[e] == bent.nodes[e]);
    const auto flat = build(cube(3).mesh());
    CHECK_FALSE(slid_nodes<3>(flat.mesh, flat.mesh.mid_nodes, {}, flat.features, Geometry<3>(flat.surrogate),
                              Execution{.threads = 1})
                    .has_value());
}
