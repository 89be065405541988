// The comparison mesh of curved walls: the same boundary and interfaces, with straight edges elsewhere.
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

/// 1 for boundary edges of the lattice, found independently: the middle of the chord is on a side of the box.
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

/// Moves nodes at random in the directions that `allowed` selects.
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
    property("only inner edges and edges within flat sides are bent",
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
    property("only boundary edges are bent",
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
                     RC_ASSERT(error.same_boundary_inverted == error.curved_inverted);
                 }
             },
             {.count = 10});
}

template <int D>
void check_straightened_inside() {
    property("all edges are bent",
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
                 const auto expected = error_of<D>(inside, any_field<D>(), 1e-5);
                 RC_ASSERT(agree(error.same_boundary.l2.value, expected.curved.l2.value, 2e-5));
                 RC_ASSERT(agree(error.same_boundary.h1.value, expected.curved.h1.value, 2e-5));
                 RC_ASSERT(agree(error.volume.curved, expected.volume.curved, 1e-13));
             },
             {.count = 5});
}

/// Two materials with a curved interface in a flat boundary.
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

/// Layers around a cylinder, r = 1 + 0.02 i, with angles of 0.8. The first layer is thinner than the sagitta of the
/// wall.
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
    CHECK(error.straight_inverted == 0);
    CHECK(error.curved_inverted == 0);
    CHECK(error.same_boundary_inverted > 0);
    CHECK(error.same_boundary_inverted < mesh.linear.elements.size());
    CHECK(std::isfinite(error.same_boundary.h1.value));
    CHECK(error.unresolved == 0);
    CHECK(error.volume.straight < error.volume.curved);
}

}  // namespace

TEST_CASE("the comparison mesh is the straight mesh where the boundary is flat, 2D") { check_straight_boundary<2>(); }
TEST_CASE("the comparison mesh is the straight mesh where the boundary is flat, 3D") { check_straight_boundary<3>(); }
TEST_CASE("the comparison mesh is the mesh itself where inner edges are straight, 2D") { check_straight_inside<2>(); }
TEST_CASE("the comparison mesh is the mesh itself where inner edges are straight, 3D") { check_straight_inside<3>(); }
TEST_CASE("the comparison mesh has straight inner edges, 2D") { check_straightened_inside<2>(); }
TEST_CASE("the comparison mesh has straight inner edges, 3D") { check_straightened_inside<3>(); }
TEST_CASE("the comparison mesh keeps curved interfaces, 2D") { check_interface<2>(); }
TEST_CASE("the comparison mesh keeps curved interfaces, 3D") { check_interface<3>(); }
TEST_CASE("elements inverted in the comparison mesh are counted, 2D") { check_inverted_layers<2>(); }
TEST_CASE("elements inverted in the comparison mesh are counted, 3D") { check_inverted_layers<3>(); }

TEST_CASE("the volume of a mesh under a quadratic map is exact") {
    // x + a y z, y + b z x, z + c x y: det J = 1 - bc x² - ac y² - ab z² + 2 abc xyz.
    const double a = 0.1, b = -0.05, c = 0.07, n = 2;
    const auto mesh = mapped<3>(mesh_of_cells<3>(2, 0, 0), [=](const Vec<3>& x) {
        return Vec<3>{{x[0] + a * x[1] * x[2], x[1] + b * x[2] * x[0], x[2] + c * x[0] * x[1]}};
    });
    const double exact =
        std::pow(n, 3) - (b * c + a * c + a * b) * std::pow(n, 5) / 3 + 2 * a * b * c * std::pow(n, 6) / 8;
    CHECK(agree(error_of<3>(mesh, any_field<3>()).volume.curved, exact, 1e-13));
}

TEST_CASE("the area of a curved edge differs from the chord by two thirds of chord times sagitta") {
    auto mesh = mesh_of_cells<2>(2, 0, 0);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (auto& node : nodes)
        if (node.point[1] == 0) node.point[1] -= 0.09;  // both lower edges bulge outwards
    mesh.mid_nodes = std::move(nodes);
    const auto volume = error_of<2>(mesh, any_field<2>()).volume;
    CHECK(volume.straight == 4);
    CHECK(agree(volume.curved, 4 + 2 * 2.0 / 3 * 0.09, 1e-14));
}
