// Placement of boundary nodes by metric length and by distance from the geometry, where the solution is known.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

#include "../surface/meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.surface;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

/// A metric on a box around the geometry. Its logarithm is linear in each element.
template <int D>
BackMesh<D> field_of(int cells, const std::function<Sym<D>(const Vec<D>&)>& log_metric) {
    LatticeOptions<D> options;
    for (int& n : options.cells) n = cells;
    options.place = [cells](const Vec<D>& p) {
        Vec<D> q;
        for (int i = 0; i < D; ++i) q[i] = -4 + 8 * p[i] / cells;
        return q;
    };
    const auto mesh = lattice_mesh(options);
    Buffer<LogMetric<D>> logs(mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) logs[v] = {log_metric(mesh.points[v])};
    return must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<D>>(std::move(logs)), one_thread));
}
template <int D>
Sym<D> isotropic(double log_value) {
    return log_value * Sym<D>::identity();
}

/// A single edge with the facets next to it.
EdgeSite<3> edge_at(const Vec<3>& a, const Vec<3>& b, const Vec<3>& left, const Vec<3>& right) {
    return {{}, EdgeKind::surface, {a, b}, {{{}, 1, {a, b, left}}, {{}, 1, {b, a, right}}}};
}
EdgeSite<2> edge_at(const Vec<2>& a, const Vec<2>& b) { return {{}, EdgeKind::surface, {a, b}, {{{}, 1, {a, b}}}}; }

constexpr PlacementOptions by_length{.boundary_nodes = BoundaryNodeAim::length};
constexpr PlacementOptions by_length_at_any_distance{.boundary_nodes = BoundaryNodeAim::length, .distance_share = 1};
constexpr PlacementOptions by_accuracy{.boundary_nodes = BoundaryNodeAim::accuracy};

template <int D>
struct EdgePlacement {
    Geometry<D> geometry;
    BackMesh<D> back;
    EdgeSite<D> site;
    CurveOptions search = {};

    [[nodiscard]] LagrangeNode<D> projected() const { return {geometry->middle_of(site)}; }
    [[nodiscard]] PlacedNode<D> placed(const PlacementOptions& options, const std::optional<Vec<D>>& from = {},
                                       std::span<const Vec<D>> thin = {}) const {
        const LagrangeNode<D> present = from ? LagrangeNode<D>{*from} : projected();
        return placed_node<D>(geometry, {site, present, thin, ElementId(std::size_t{0})}, back, {search, options});
    }
    [[nodiscard]] double length(const Vec<D>& node) const {
        return riemannian_length(back, QuadraticEdge<D>{site.ends[0], {node}, site.ends[1]},
                                 gauss_legendre(report_points), ElementId(std::size_t{0}))
            .length;
    }
    [[nodiscard]] double off(const Vec<D>& p) const {
        return project<D>(geometry, {.facet = {}, .reference = Reference{1}}, p).distance;
    }
};

Vec<3> on_cylinder(double angle, double z) { return {{std::cos(angle), std::sin(angle), z}}; }

/// A point moved along a surface.
template <int D>
Vec<D> beside(const Geometry<D>& geometry, const Vec<D>& p, const Vec<D>& by) {
    return project<D>(geometry, {.facet = {}, .reference = Reference{1}}, p + by).point;
}

/// A point on a torus by its angles.
Vec<3> on_torus(double a, double b) {
    const double r = 1 + 0.3 * std::cos(b);
    return {{r * std::cos(a), r * std::sin(a), 0.3 * std::sin(b)}};
}
EdgePlacement<3> on_torus(Dice& dice, double size) {
    const double a = dice.uniform(-3, 3), b = dice.uniform(-3, 3), way = dice.uniform(0, 6.3);
    const auto at = [&](double along, double across) {
        const double x = along * std::cos(way) - across * std::sin(way);
        const double y = along * std::sin(way) + across * std::cos(way);
        return on_torus(a + size * x, b + size / 0.3 * y);
    };
    Sym<3> mean, slope;
    for (double& c : mean.c) c = dice.uniform(-1, 1);
    for (double& c : slope.c) c = dice.uniform(-2, 2);
    const Vec<3> direction = dice.vector<3>();
    return {Geometry<3>(AnalyticGeometry<3>{{{1, Torus{{}, {{0, 0, 1}}, 1, 0.3}}}}),
            field_of<3>(9, [=](const Vec<3>& p) { return mean + std::sin(2 * dot(direction, p)) * slope; }),
            edge_at(at(0, 0), at(1, 0), at(0.5, 0.8), at(0.5, -0.8))};
}

TEST_CASE("on a sphere in a constant isotropic metric the node is placed at the middle of the geodesic") {
    property("the node is at the middle of the geodesic of a sphere from any start", [](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<3> a = normalised(dice.vector<3>()), b = normalised(a + dice.uniform(0.05, 0.4) * dice.vector<3>());
        RC_PRE(distance(a, b) > 0.02);
        const Vec<3> c = normalised(cross(a, b)), m = normalised(a + b);
        const double h = distance(a, b);
        const EdgePlacement<3> placement{Geometry<3>(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 1}}}}),
                                         field_of<3>(2, [](const Vec<3>&) { return isotropic<3>(1); }),
                                         edge_at(a, b, normalised(m + h * c), normalised(m - h * c))};
        const auto from_middle = placement.placed(by_length);
        RC_ASSERT(distance(from_middle.node.point, m) < 1e-3 * h);
        RC_ASSERT(from_middle.after <= from_middle.before);
        const Vec<3> start = beside(placement.geometry, m, dice.uniform(-0.15, 0.15) * h * c);
        const auto from_beside = placement.placed(by_length_at_any_distance, start);
        RC_ASSERT(std::abs(dot(from_beside.node.point - m, c)) < 2e-3 * h);
        RC_ASSERT(std::abs(norm(from_beside.node.point) - 1) < 1e-12);
    });
}

TEST_CASE("in a plane and a constant metric the node is placed at the middle of the chord") {
    property("the node is at the middle of the chord in a plane, to the last bit", [](std::uint64_t seed) {
        Dice dice(seed);
        Vec<3> a = dice.vector<3>(), b = dice.vector<3>();
        a[2] = b[2] = 0.25;
        RC_PRE(distance(a, b) > 0.1);
        const double h = distance(a, b);
        const Vec<3> side{{a[1] - b[1], b[0] - a[0], 0}};
        Sym<3> log_metric;
        for (double& c : log_metric.c) c = dice.uniform(-2, 2);
        const EdgePlacement<3> placement{Geometry<3>(AnalyticGeometry<3>{{{1, Plane<3>{{{0, 0, 0.25}}, {{0, 0, 1}}}}}}),
                                         field_of<3>(2, [&](const Vec<3>&) { return log_metric; }),
                                         edge_at(a, b, a + side, b - side)};
        const Vec<3> middle = midpoint(a, b);
        RC_ASSERT(placement.placed(by_length).node.point == middle);
        const Vec<3> start = middle + dice.uniform(-0.2, 0.2) * side;
        const auto back = placement.placed(by_length, start);
        RC_ASSERT(back.node.point[2] == 0.25);
        RC_ASSERT(back.after <= back.before);
        RC_ASSERT(back.after < placement.length(middle) * (1 + 1e-4));
        RC_ASSERT(placement.placed(by_accuracy, start).status == PlacementStatus::fixed);
        static_cast<void>(h);
    });
}

TEST_CASE("on a cylinder with sizes varying along its axis no sampled node gives a shorter edge") {
    property("no sampled node on a cylinder gives a shorter edge", [](std::uint64_t seed) {
        Dice dice(seed);
        const double from = dice.uniform(-3, 3), wide = dice.uniform(0.1, 0.5), z = dice.uniform(-1, 1);
        const double rise = dice.uniform(-2, 2);
        const EdgePlacement<3> placement{
            Geometry<3>(AnalyticGeometry<3>{{{1, Cylinder{{}, {{0, 0, 1}}, 1}}}}),
            field_of<3>(4, [&](const Vec<3>& p) { return isotropic<3>(2 * rise * p[2]); }),
            edge_at(on_cylinder(from, z), on_cylinder(from + wide, z), on_cylinder(from + 0.5 * wide, z + wide),
                    on_cylinder(from + 0.5 * wide, z - wide))};
        const auto found = placement.placed(by_length_at_any_distance);
        double least = placement.length(on_cylinder(from + 0.5 * wide, z));
        const double straight = least;
        for (int i = -1000; i <= 1000; ++i)
            least = std::fmin(least, placement.length(on_cylinder(from + 0.5 * wide, z + 0.28e-3 * i * wide)));
        RC_ASSERT(found.after <= straight);
        RC_ASSERT(found.after <= least + 0.05 * (straight - least) + 1e-6 * straight);
        RC_ASSERT(placement.off(found.node.point) < 1e-12);
        // Sizes decrease towards +z for rise > 0, so the edge bends the other way.
        if (found.status == PlacementStatus::placed) RC_ASSERT((found.node.point[2] - z) * rise < 0);
    });
}

TEST_CASE("on a torus nodes stay on the surface and edges become no longer than with projected nodes") {
    std::size_t placed = 0;
    property("placement by length keeps nodes on the torus and lengthens no edge", [&](std::uint64_t seed) {
        Dice dice(seed);
        const EdgePlacement<3> placement = on_torus(dice, dice.uniform(0.02, 0.25));
        const auto found = placement.placed(by_length);
        RC_ASSERT(placement.off(found.node.point) < 1e-12);
        RC_ASSERT(found.after <= found.before);
        RC_ASSERT(std::abs(found.after - placement.length(found.node.point)) < 1e-12 * found.before);
        RC_ASSERT(std::abs(found.before - placement.length(placement.projected().point)) < 1e-12 * found.before);
        if (found.status != PlacementStatus::placed) RC_ASSERT(found.node == placement.projected());
        placed += found.status == PlacementStatus::placed;
    });
    CHECK(placed > successes_here(100) / 2);
    property("placement by accuracy keeps nodes on the torus and lengthens no edge", [&](std::uint64_t seed) {
        Dice dice(seed);
        const EdgePlacement<3> placement = on_torus(dice, dice.uniform(0.02, 0.25));
        const auto found = placement.placed(by_accuracy);
        RC_ASSERT(placement.off(found.node.point) < 1e-12);
        RC_ASSERT(found.after <= found.before);
        if (found.status != PlacementStatus::placed) RC_ASSERT(found.node == placement.projected());
    });
}

TEST_CASE("a node off the geometry of its edge is not moved") {
    Dice dice(1);
    const EdgePlacement<3> placement = on_torus(dice, 0.1);
    const Vec<3> off = 1.01 * placement.projected().point;
    const auto found = placement.placed(by_length, off);
    CHECK(found.status == PlacementStatus::off);
    CHECK(found.node.point == off);
}

TEST_CASE("nodes of a 2D boundary stay on their curve") {
    property("placed nodes stay on a circle in any field", [](std::uint64_t seed) {
        Dice dice(seed);
        const double from = dice.uniform(-3, 3), wide = dice.uniform(0.05, 0.8), rise = dice.uniform(-2, 2);
        const auto at = [](double angle) { return Vec<2>{{std::cos(angle), std::sin(angle)}}; };
        const EdgePlacement<2> placement{
            Geometry<2>(AnalyticGeometry<2>{{{1, Sphere<2>{{}, 1}}}}),
            field_of<2>(5, [&](const Vec<2>& p) { return isotropic<2>(rise * p[0] * p[1]); }),
            edge_at(at(from), at(from + wide))};
        for (const PlacementOptions& options : {by_length, by_accuracy}) {
            const auto found = placement.placed(options);
            RC_ASSERT(std::abs(norm(found.node.point) - 1) < 1e-12);
            RC_ASSERT(found.after <= found.before);
            RC_ASSERT(distance(found.node.point, at(from + 0.5 * wide)) < 0.21 * 2 * std::sin(0.5 * wide));
        }
    });
}

/// A coarse edge on the surrogate of a fine mesh of the unit sphere.
EdgePlacement<3> on_fine_sphere(const Geometry<3>& geometry, const Vec<3>& a, const Vec<3>& b, double slope) {
    const Vec<3> c = normalised(cross(a, b)), m = normalised(a + b);
    const auto on = [&](const Vec<3>& p) { return beside(geometry, normalised(p), Vec<3>{}); };
    return {geometry, field_of<3>(6, [=](const Vec<3>& p) { return isotropic<3>(slope * dot(c, p)); }),
            edge_at(on(a), on(b), on(m + c), on(m - c))};
}

TEST_CASE("on a surrogate nodes move across facets and stay on the surface") {
    const auto b = surface_tests::build<3>(surface_tests::sphere(8, 1).mesh());
    const Geometry<3> geometry(b.surrogate);
    std::size_t walked = 0, placed = 0;
    property("nodes of an edge across several facets stay on the surrogate", [&](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<3> p = normalised(dice.vector<3>()), q = normalised(p + 0.5 * dice.vector<3>());
        RC_PRE(distance(p, q) > 0.2);
        const EdgePlacement<3> placement = on_fine_sphere(geometry, p, q, dice.uniform(2, 6));
        const auto found = placement.placed(by_length_at_any_distance);
        RC_ASSERT(found.status != PlacementStatus::off);
        RC_ASSERT(placement.off(found.node.point) < 1e-12);
        RC_ASSERT(found.after <= found.before);
        walked += found.has_left_facets;
        placed += found.status == PlacementStatus::placed;
    });
    CHECK(placed > successes_here(100) / 2);
    CHECK(walked > 0);
}

TEST_CASE("on a thin patch nodes keep their distance from its ridges") {
    // A strip of a sphere with 0.02 on both sides of the edge. The metric would move the node ten times as far.
    const Vec<3> a = normalised(Vec<3>{{1, 0, 0}}), b = normalised(Vec<3>{{1, 0.4, 0}}), m = normalised(a + b);
    for (const double slope : {-8.0, 8.0}) {
        const auto at = [](const Vec<3>& p, double z) { return normalised(p + Vec<3>{{0, 0, z}}); };
        const EdgePlacement<3> placement{Geometry<3>(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 1}}}}),
                                         field_of<3>(6, [=](const Vec<3>& p) { return isotropic<3>(slope * p[2]); }),
                                         edge_at(a, b, at(m, 0.02), at(m, -0.02))};
        const std::array<Vec<3>, 2> thin{at(m, 0.02), at(m, -0.02)};
        const auto unrestricted = placement.placed(by_length_at_any_distance),
                   restricted = placement.placed(by_length_at_any_distance, {}, thin);
        CHECK(std::abs(unrestricted.node.point[2]) > 0.008);
        CHECK(std::abs(restricted.node.point[2]) < 0.0081);
        CHECK(restricted.after <= restricted.before);
    }
}

TEST_CASE("a node on a ridge stays on both surfaces") {
    property("nodes of a ridge stay on both the sphere and the plane", [](std::uint64_t seed) {
        Dice dice(seed);
        const double z = dice.uniform(-0.8, 0.8), r = std::sqrt(1 - z * z), from = dice.uniform(-3, 3);
        const double wide = dice.uniform(0.1, 0.6), rise = dice.uniform(-3, 3);
        const auto at = [&](double angle) { return Vec<3>{{r * std::cos(angle), r * std::sin(angle), z}}; };
        const Vec<3> p = at(from), q = at(from + wide), inside{{0, 0, z}}, pole{{0, 0, z < 0 ? 1.0 : -1.0}};
        const EdgeSite<3> site{
            {}, EdgeKind::ridge, {p, q}, {{{}, 1, {p, q, normalised(p + q + pole)}}, {{}, 2, {q, p, inside}}}};
        const EdgePlacement<3> placement{
            Geometry<3>(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 1}}, {2, Plane<3>{{{0, 0, z}}, {{0, 0, 1}}}}}}),
            field_of<3>(6, [&](const Vec<3>& x) { return isotropic<3>(rise * x[0]); }), site};
        for (const PlacementOptions& options : {by_length, by_length_at_any_distance, by_accuracy}) {
            const auto found = placement.placed(options);
            RC_ASSERT(found.status != PlacementStatus::off);
            RC_ASSERT(std::abs(norm(found.node.point) - 1) < 1e-12);
            RC_ASSERT(std::abs(found.node.point[2] - z) < 1e-12);
            RC_ASSERT(found.after <= found.before);
        }
    });
}

}  // namespace
