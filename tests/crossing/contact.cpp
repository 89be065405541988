// Contact of facets at bounded work: straight facets are decided in integer arithmetic, coplanar facets in their plane,
// and the rest shares a limited number of steps.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "facets.hpp"
#include "property.hpp"
#include "walls.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.crossing;

using namespace camber;
using camber::testing::property;
using namespace camber::testing;

namespace {

template <int D>
NodalFacet<D> lattice_facet(Engine& engine, double most) {
    std::array<Vec<D>, D> vertices;
    for (Vec<D>& v : vertices)
        for (double& x : v.c) x = std::floor(uniform(engine, 0, most + 1));
    return straight_facet<D>(vertices);
}

/// Directions that include one that separates two straight facets, if any does.
std::vector<Vec<2>> parting_directions(const NodalFacet<2>& a, const NodalFacet<2>& b) {
    std::vector<Vec<2>> out;
    for (const auto* f : {&a, &b}) {
        const Vec<2> along = f->nodes[1] - f->nodes[0];
        for (const Vec<2>& n : {along, Vec<2>{{-along[1], along[0]}}}) {
            out.push_back(n);
            out.push_back(-n);
        }
    }
    return out;
}
std::vector<Vec<3>> parting_directions(const NodalFacet<3>& a, const NodalFacet<3>& b) {
    const auto edge = [](const NodalFacet<3>& f, int i) { return f.nodes[(i + 1) % 3] - f.nodes[i]; };
    std::vector<Vec<3>> out;
    const auto add = [&](const Vec<3>& n) {
        if (!(norm(n) > 0)) return;
        out.push_back(n);
        out.push_back(-n);
    };
    for (const auto* f : {&a, &b}) {
        const Vec<3> normal = cross(edge(*f, 0), edge(*f, 1));
        add(normal);
        for (int i = 0; i < 3; ++i) add(cross(normal, edge(*f, i)));
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) add(cross(edge(a, i), edge(b, j)));
    return out;
}

double measure_of(const NodalFacet<2>& f) { return norm(f.nodes[1] - f.nodes[0]); }
double measure_of(const NodalFacet<3>& f) { return norm(cross(f.nodes[1] - f.nodes[0], f.nodes[2] - f.nodes[0])); }

template <int D>
void check_straight_facets() {
    property(D == 2 ? "straight facets are decided and consistent with small shifts, 2D"
                    : "straight facets are decided and consistent with small shifts, 3D",
             [] {
                 Engine engine(*rc::gen::arbitrary<std::uint64_t>());
                 const auto a = lattice_facet<D>(engine, 3), b = lattice_facet<D>(engine, 3);
                 RC_PRE(measure_of(a) > 0 && measure_of(b) > 0);
                 const Crossing found = crossing_of(a, b);
                 RC_ASSERT(found != Crossing::undecided);
                 RC_ASSERT(crossing_of(renumbered(b, 1, true), a) == found);
                 // A small shift confirms the verdict: crossing facets still cross, and touching facets separate in
                 // some direction.
                 bool parts = false, stays = true;
                 for (const Vec<D>& n : parting_directions(a, b)) {
                     const auto moved = mapped<D>(b, [&](const Vec<D>& p) { return p + n * 0x1p-20; });
                     const Crossing then = crossing_of(a, moved);
                     RC_ASSERT(then != Crossing::undecided);
                     parts = parts || then == Crossing::disjoint;
                     stays = stays && then == Crossing::crossing;
                 }
                 RC_ASSERT((found == Crossing::crossing ? stays : parts));
             },
             {.count = 150});
}

/// Two plates of squares in two triangles each, in the planes z = 0 and z = `height`.
QuadraticMesh<3> plates(std::size_t n, double height, double bow) {
    std::vector<Vec<3>> points;
    std::vector<SimplexVertices<2>> facets;
    for (const bool upper : {false, true}) {
        const std::size_t first = points.size(), m = upper ? n + 1 : n;
        for (std::size_t i = 0; i <= m; ++i)
            for (std::size_t j = 0; j <= m; ++j)
                points.push_back({{static_cast<double>(i) / static_cast<double>(m),
                                   static_cast<double>(j) / static_cast<double>(m), upper ? height : 0}});
        const auto at = [&](std::size_t i, std::size_t j) { return VertexId(first + i * (m + 1) + j); };
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t j = 0; j < m; ++j) {
                facets.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                facets.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    }
    return wall_of<3>(points, facets, [=](const Vec<3>& p) {
        return Vec<3>{{p[0] + bow * std::sin(9 * p[0] + 5 * p[1]), p[1] + bow * std::cos(7 * p[0] - 3 * p[1]), p[2]}};
    });
}

/// Rings between arcs in one plane, rotated in space by `turn`.
QuadraticMesh<3> rings(std::size_t count, std::size_t around, double width, double turn) {
    const auto place = [=](double r, double t) {
        const double x = r * std::cos(t), y = r * std::sin(t);
        return Vec<3>{{x, std::cos(turn) * y, std::sin(turn) * y}};
    };
    std::vector<Vec<3>> points;
    const auto radius = [=](std::size_t k) { return 1 + width * static_cast<double>(k); };
    for (std::size_t k = 0; k <= count; ++k)
        for (std::size_t i = 0; i < around; ++i)
            points.push_back(
                place(radius(k), 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(around)));
    std::vector<SimplexVertices<2>> facets;
    const auto at = [&](std::size_t k, std::size_t i) { return VertexId(k * around + i % around); };
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = 0; i < around; ++i) {
            facets.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1)});
            facets.push_back({at(k, i), at(k + 1, i + 1), at(k, i + 1)});
        }
    auto mesh = wall_of<3>(points, facets, [](const Vec<3>& p) { return p; });
    Buffer<LagrangeNode<3>> nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const double r = (norm(points[a.index()]) + norm(points[b.index()])) / 2;
        nodes[e].point = normalised(nodes[e].point) * r;
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

/// The result does not depend on the number of threads, and its work is bounded.
void check_bounds(const QuadraticMesh<3>& mesh, const Crossings& found, std::size_t steps_per_pair) {
    CHECK(found.steps <= max_steps(mesh.linear.facets.size()) + steps_per_pair * found.pairs);
    CHECK(found.cut_short <= found.undecided);
    CHECK(crossings_of(mesh, 2) == found);
}

}  // namespace

// Guards against touching facets that are subdivided 4000 times and stay undecided.
TEST_CASE("straight facets are decided, and small shifts confirm the decision") {
    check_straight_facets<2>();
    check_straight_facets<3>();
}

// Guards against milliseconds for each pair of boxes in face contact.
TEST_CASE("facets of coincident walls do not cross") {
    SUBCASE("contact of straight facets is decided in at most two steps per pair") {
        const auto mesh = plates(8, 0, 0);
        const Crossings found = crossings_of(mesh);
        CHECK(found.touching > 200);
        CHECK(found.crossing + found.undecided == 0);
        CHECK(found.steps <= 2 * found.pairs + 2 * mesh.linear.facets.size());
        CHECK(crossings_of(mesh, 2) == found);
        CHECK(crossings_of(plates(8, 1e-6, 0)).all_disjoint());
    }
    SUBCASE("facets curved within their plane are not crossing") {
        const auto mesh = plates(8, 0, 0.01);
        const Crossings found = crossings_of(mesh);
        CHECK(found.touching > 200);
        CHECK(found.crossing == 0);
        CHECK(found.undecided < found.touching / 10);
        check_bounds(mesh, found, 32);
        CHECK(crossings_of(plates(8, 1e-6, 0.01)).all_disjoint());
    }
    SUBCASE("crossings of coincident curved walls need bounded work") {
        const UnitSphere<3> unit = icosphere<3>(1);
        std::vector<Vec<3>> points(unit.points.begin(), unit.points.end());
        std::vector<SimplexVertices<2>> facets(unit.facets.begin(), unit.facets.end());
        const std::size_t n = points.size(), m = facets.size();
        for (std::size_t i = 0; i < n; ++i) {
            const Vec<3> p = points[i];
            points.push_back({{0.8 * p[0] - 0.6 * p[1], 0.6 * p[0] + 0.8 * p[1], p[2]}});
        }
        for (std::size_t f = 0; f < m; ++f) {
            SimplexVertices<2> facet = facets[f];
            for (VertexId& v : facet) v = VertexId(v.index() + n);
            facets.push_back(facet);
        }
        const auto mesh = wall_of<3>(points, facets, [](const Vec<3>& p) { return normalised(p); });
        check_bounds(mesh, crossings_of(mesh), 32);
    }
}

// Guards against minutes for nested arcs in a plane wall.
TEST_CASE("rings of layers in a plane are disjoint at bounded work") {
    for (const double turn : {0.0, 0.7}) {
        const auto mesh = rings(40, 8, 0.01, turn);
        const Crossings found = crossings_of(mesh);
        CHECK(found.pairs > 20'000);
        CHECK(found.all_disjoint());
        CHECK(found.steps <= 40 * found.pairs);
    }
}

// Guards against minutes for a quadratic mesh with one coordinate at 9e18.
TEST_CASE("a distant vertex keeps the number of search steps within its limit") {
    auto mesh = rings(10, 8, 0.1, 0.3);
    Buffer<Vec<3>> points = take(std::move(mesh.linear.points));
    points[points.size() / 2][0] = 0x1p63;
    mesh.linear.points = std::move(points);
    check_bounds(mesh, crossings_of(mesh), 32);
}
