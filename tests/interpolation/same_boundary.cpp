// Laws of the mesh that curved ones are compared with where their walls are curved: the same boundary and interfaces,
// straight edges elsewhere.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.interpolation;

#include "bent_meshes.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

/// 1: an edge of the lattice's boundary, by a way of its own: the middle of its chord is on a side of the box.
template <int D>
std::vector<std::uint8_t> edges_on_sides(const QuadraticMesh<D>& mesh, int cells) {
    std::vector<std::uint8_t> on(mesh.edges.size(), 0);
    for (std::size_t e = 0; e < on.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Vec<D> middle = midpoint(mesh.linear.points[a], mesh.linear.points[b]);
        for (int c = 0; c < D; ++c)
            if (middle[c] == 0 || middle[c] == cells) on[e] = 1;
    }
    return on;
}

/// Nodes of the chosen edges moved at random, where `allowed` in each direction.
template <int D, class Allowed>
QuadraticMesh<D> moved(QuadraticMesh<D> mesh, const Allowed& allowed, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> move(-0.06, 0.06);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e)
        for (int c = 0; c < D; ++c)
            if (const double by = move(random); allowed(e, nodes[e].point, c)) nodes[e].point[c] += by;
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
ScalarField<D> any_field() {
    return field_of<D>(wave<D>);
}

bool same(const InterpolantError& a, const InterpolantError& b) {
    return a.l2.value == b.l2.value && a.h1.value == b.h1.value && a.l2.squares == b.l2.squares &&
           a.h1.squares == b.h1.squares && a.h1.rounding == b.h1.rounding && a.h1.uncertainty == b.h1.uncertainty;
}

constexpr int cells = 3;

template <int D>
void check_straight_boundary() {
    property("edges bent inside, and within flat sides",
             [](std::uint64_t seed) {
                 const auto within = [&](std::size_t, const Vec<D>& p, int c) { return p[c] != 0 && p[c] != cells; };
                 const auto mesh = moved(mesh_of_cells<D>(cells, 0, 0), within, seed);
                 const auto error = error_of<D>(mesh, any_field<D>());
                 RC_ASSERT(error.compared_with == Comparison::straight);
                 RC_ASSERT(same(error.same_boundary, error.straight));
                 RC_ASSERT(error.volume.straight == error.volume.curved);
                 RC_ASSERT(error.curved.l2.value != error.straight.l2.value);
             },
             {.count = 10});
}

template <int D>
void check_straight_inside() {
    property("edges bent on the boundary alone",
             [](std::uint64_t seed) {
                 const auto straight = mesh_of_cells<D>(cells, 0, 0);
                 const auto on = edges_on_sides(straight, cells);
                 const auto mesh = moved(straight, [&](std::size_t e, auto&&...) { return on[e] == 1; }, seed);
                 const auto quadratic = field_of<D>([](const Vec<D>& x) { return x[0] * x[D - 1] - 2 * x[1] * x[1]; });
                 for (const auto& field : {any_field<D>(), quadratic}) {
                     const auto error = error_of<D>(mesh, field);
                     RC_ASSERT(error.compared_with == Comparison::same_boundary);
                     RC_ASSERT(same(error.same_boundary, error.curved));
                     RC_ASSERT(same(error.compared(), error.curved));
                     RC_ASSERT(error.same_boundary_turned == error.curved_turned);
                 }
             },
             {.count = 10});
}

template <int D>
void check_second_making() {
    property("edges bent everywhere",
             [](std::uint64_t seed) {
                 const auto straight = mesh_of_cells<D>(cells, 0, 0);
                 const auto mesh = moved(straight, [](auto&&...) { return true; }, seed);
                 const auto on = edges_on_sides(straight, cells);
                 auto nodes = take(Column(straight.mid_nodes));
                 for (std::size_t e = 0; e < nodes.size(); ++e)
                     if (on[e] == 1) nodes[e] = mesh.mid_nodes[e];
                 auto inside = straight;
                 inside.mid_nodes = std::move(nodes);
                 const auto error = error_of<D>(mesh, any_field<D>(), 1e-5);
                 const auto wanted = error_of<D>(inside, any_field<D>(), 1e-5);
                 RC_ASSERT(agree(error.same_boundary.l2.value, wanted.curved.l2.value, 2e-5));
                 RC_ASSERT(agree(error.same_boundary.h1.value, wanted.curved.h1.value, 2e-5));
                 RC_ASSERT(agree(error.volume.curved, wanted.volume.curved, 1e-13));
             },
             {.count = 5});
}

/// Two materials, divided by a curved interface; outside all is flat.
template <int D>
void check_interface() {
    auto mesh = mesh_of_cells<D>(2, 0, 0);
    auto references = take(Column(mesh.linear.elements.references));
    for (std::size_t e = 0; e < references.size(); ++e) {
        const auto& vertices = mesh.linear.elements.vertices[e];
        references[e] =
            std::any_of(vertices.begin(), vertices.end(), [&](VertexId v) { return mesh.linear.points[v][0] > 1; }) ? 2
                                                                                                                    : 1;
    }
    const auto of_two = [&](std::size_t, const Vec<D>& p, int c) { return c == 0 && p[0] == 1; };
    const auto bowed = moved(mesh, of_two, 7);
    const auto one = error_of<D>(bowed, any_field<D>());
    CHECK(one.compared_with == Comparison::straight);
    mesh.linear.elements.references = std::move(references);
    const auto two = error_of<D>(moved(mesh, of_two, 7), any_field<D>());
    CHECK(two.compared_with == Comparison::same_boundary);
    CHECK(same(two.same_boundary, two.curved));
}

/// Layers around a cylinder, of which the first is thinner than the wall's sagitta: r = 1 + 0.02 i, angles of 0.8.
template <int D>
void check_inverted_layers() {
    const auto mesh = mapped<D>(mesh_of_cells<D>(2, 0, 0), [](Vec<D> x) {
        const double r = 1 + 0.02 * x[0], angle = 0.8 * x[1];
        x[0] = r * std::cos(angle);
        x[1] = r * std::sin(angle);
        return x;
    });
    const auto error = error_of<D>(
        mesh, field_of<D>([](const Vec<D>& x) { return std::exp(-10 * (std::sqrt(x[0] * x[0] + x[1] * x[1]) - 1)); }));
    CHECK(error.straight_turned == 0);
    CHECK(error.curved_turned == 0);
    CHECK(error.same_boundary_turned > 0);
    CHECK(error.same_boundary_turned < mesh.linear.elements.size());
    CHECK(std::isfinite(error.same_boundary.h1.value));
    CHECK(error.unresolved == 0);
    CHECK(error.volume.straight < error.volume.curved);
}

}  // namespace

TEST_CASE("where the boundary is flat the comparison is the straight mesh, to the bit, in 2D") {
    check_straight_boundary<2>();
}
TEST_CASE("where the boundary is flat the comparison is the straight mesh, to the bit, in 3D") {
    check_straight_boundary<3>();
}
TEST_CASE("where inner edges are straight the comparison is the mesh itself, to the bit, in 2D") {
    check_straight_inside<2>();
}
TEST_CASE("where inner edges are straight the comparison is the mesh itself, to the bit, in 3D") {
    check_straight_inside<3>();
}
TEST_CASE("the comparison is the mesh with inner edges made straight, in 2D") { check_second_making<2>(); }
TEST_CASE("the comparison is the mesh with inner edges made straight, in 3D") { check_second_making<3>(); }
TEST_CASE("interfaces are kept as the boundary is, in 2D") { check_interface<2>(); }
TEST_CASE("interfaces are kept as the boundary is, in 3D") { check_interface<3>(); }
TEST_CASE("thin layers whose inner edges go straight are counted where they are inverted, in 2D") {
    check_inverted_layers<2>();
}
TEST_CASE("thin layers whose inner edges go straight are counted where they are inverted, in 3D") {
    check_inverted_layers<3>();
}

TEST_CASE("volumes are those of a quadratic map") {
    // x + a y z, y + b z x, z + c x y: det J = 1 - bc x² - ac y² - ab z² + 2 abc xyz.
    const double a = 0.1, b = -0.05, c = 0.07, n = 2;
    const auto mesh = mapped<3>(mesh_of_cells<3>(2, 0, 0), [=](const Vec<3>& x) {
        return Vec<3>{{x[0] + a * x[1] * x[2], x[1] + b * x[2] * x[0], x[2] + c * x[0] * x[1]}};
    });
    const double exact =
        std::pow(n, 3) - (b * c + a * c + a * b) * std::pow(n, 5) / 3 + 2 * a * b * c * std::pow(n, 6) / 8;
    CHECK(agree(error_of<3>(mesh, any_field<3>()).volume.curved, exact, 1e-13));
}

TEST_CASE("areas differ by the segments of the walls: two thirds of chord by sagitta") {
    auto mesh = mesh_of_cells<2>(2, 0, 0);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (auto& node : nodes)
        if (node.point[1] == 0) node.point[1] -= 0.09;  // both edges below bulge outwards
    mesh.mid_nodes = std::move(nodes);
    const auto volume = error_of<2>(mesh, any_field<2>()).volume;
    CHECK(volume.straight == 4);
    CHECK(agree(volume.curved, 4 + 2 * 2.0 / 3 * 0.09, 1e-14));
}
