// Interpolation of fields at the nodes of another mesh.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "dice.hpp"
#include "fields.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.transfer;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_polynomials() {
    property("polynomials of the degree of the field are reproduced at the nodes of any mesh",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto from = quadratic(rough_box<D>(3, seed + 1));
                 const auto to = bent_inside(quadratic(rough_box<D>(4, seed + 2)), 0.1, dice);
                 for (const int degree : {1, 2}) {
                     const std::vector<Function<D>> functions{polynomial<D>(degree, dice), polynomial<D>(degree, dice)};
                     const auto out = transferred<D>(from, {field_of(from, degree, functions)}, to);
                     RC_ASSERT(largest_difference(out.fields[0], field_of(to, degree, functions)) < 1e-13);
                     RC_ASSERT(out.statistics.outside == 0U);
                     RC_ASSERT(out.statistics.preserved + out.statistics.interpolated == node_count_of(to, degree));
                 }
             },
             {.count = 10});
    property("functions of degree 2 in the reference are reproduced on curved meshes",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const QuadraticMap<D> map(dice);
                 const auto a = quadratic(rough_box<D>(3, seed + 1)), b = quadratic(rough_box<D>(4, seed + 2));
                 const auto u = polynomial<D>(2, dice);
                 const auto out = transferred<D>(map(a), {field_of(a, 2, {u})}, map(b));
                 RC_ASSERT(largest_difference(out.fields[0], field_of(b, 2, {u})) < 1e-11);
                 RC_ASSERT(out.statistics.largest_distance < 1e-12);
             },
             {.count = 10});
}

template <int D>
void check_unchanged_nodes() {
    property("values of unchanged nodes are preserved to the last bit",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto from = bent_inside(quadratic(rough_box<D>(3, seed + 1)), 0.05, dice);
                 const auto to = renumbered(moved_at_corner(from, dice), dice);
                 const std::vector fields{rough_field(node_count_of(from, 2), 2, 3, dice),
                                          rough_field(node_count_of(from, 1), 1, 1, dice)};
                 for (const auto& method : words(TransferMethod{})) {
                     const auto out = transferred<D>(from, fields, to, {.method = method.value});
                     std::size_t same = 0;
                     for (std::size_t n = 0; n < node_count_of(to, 2); ++n) {
                         const std::size_t o = node_at(from, node_place(to, n));
                         if (o == node_count_of(from, 2)) continue;
                         ++same;
                         // An unchanged node of changed elements is projected.
                         if (method.value == TransferMethod::conserve && touches_corner(to, n)) continue;
                         for (std::size_t c = 0; c < 3; ++c)
                             RC_ASSERT(out.fields[0].values[3 * n + c] == fields[0].values[3 * o + c]);
                         if (n < node_count_of(to, 1)) RC_ASSERT(out.fields[1].values[n] == fields[1].values[o]);
                     }
                     RC_ASSERT(out.statistics.preserved == same);
                     RC_ASSERT(same < node_count_of(to, 2));
                     RC_ASSERT(out.statistics.changed_elements > 0U);
                 }
             },
             {.count = 10});
    property("transfer to the same mesh changes nothing",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = bent_inside(quadratic(rough_box<D>(2, seed + 1)), 0.1, dice);
                 const std::vector fields{rough_field(node_count_of(mesh, 2), 2, D, dice)};
                 const auto out = transferred<D>(mesh, fields, mesh, {.method = TransferMethod::conserve});
                 RC_ASSERT(out.fields == fields);
                 RC_ASSERT(out.statistics.preserved == node_count_of(mesh, 2));
                 RC_ASSERT(out.statistics.patches + out.statistics.changed_elements + out.statistics.projected == 0U);
             },
             {.count = 5});
    SUBCASE("interpolation to a refined mesh and back returns the same values") {
        Dice dice(3);
        const auto coarse = quadratic(lattice_in_box<D>(4)), fine = quadratic(lattice_in_box<D>(8));
        const std::vector fields{rough_field(node_count_of(coarse, 2), 2, 2, dice)};
        const auto there = transferred<D>(coarse, fields, fine);
        CHECK(there.statistics.outside == 0);
        CHECK(transferred<D>(fine, there.fields, coarse).fields == fields);
        const auto& integrals = there.statistics.integrals[0][0];
        CHECK(integrals.before[1] == doctest::Approx(integrals.after[1]).epsilon(1e-12));
    }
}

template <int D>
void check_outside_nodes() {
    SUBCASE("nodes outside take the value of the nearest boundary point and are counted") {
        Dice dice(5);
        const auto from = quadratic(rough_box<D>(3, 1));
        auto linear = rough_box<D>(3, 1);
        auto points = take(std::move(linear.points));
        constexpr double out_by = 1e-3;
        for (Vec<D>& p : points)
            if (p[0] == 1) p[0] += out_by;
        linear.points = std::move(points);
        const auto to = quadratic(std::move(linear));
        const Function<D> along = [](const Vec<D>& x) { return x[0]; };
        const auto out = transferred<D>(from, {field_of(from, 2, {along})}, to);
        std::size_t beyond = 0;
        for (std::size_t n = 0; n < node_count_of(to, 2); ++n) {
            const double x = node_place(to, n)[0];
            CHECK(out.fields[0].values[n] == doctest::Approx(std::min(x, 1.0)).epsilon(1e-12));
            beyond += x > 1 + 1e-9 ? 1 : 0;
        }
        CHECK(out.statistics.outside == beyond);
        CHECK(out.statistics.lost == 0);
        CHECK(out.statistics.largest_distance == doctest::Approx(out_by).epsilon(1e-9));
    }
}

/// The box in two materials, left and right of a wall.
template <int D>
QuadraticMesh<D> two_materials(double wall) {
    LatticeOptions<D> options;
    options.cells.fill(4);
    options.place = [wall](const Vec<D>& p) {
        Vec<D> x = p / 4;
        x[0] = x[0] <= 0.5 ? 2 * wall * x[0] : 1 - 2 * (1 - wall) * (1 - x[0]);
        return x;
    };
    auto mesh = lattice_mesh(options);
    auto references = take(std::move(mesh.elements.references));
    for (std::size_t e = 0; e < references.size(); ++e) {
        Vec<D> centre;
        for (const Vec<D>& p : corners(mesh, e)) centre += p / (D + 1);
        references[e] = centre[0] < wall ? 7 : 3;
    }
    mesh.elements.references = std::move(references);
    return quadratic(std::move(mesh));
}

template <int D>
void check_material_values() {
    SUBCASE("a node takes the value of its own material") {
        // u is x on the left and its mirror image on the right. The left material extended beyond its wall has the
        // value at the wall.
        constexpr double wall = 0.5, moved = 0.7;
        const auto from = two_materials<D>(wall), to = two_materials<D>(moved);
        const Function<D> tent = [](const Vec<D>& x) { return std::min(x[0], 1 - x[0]); };
        const auto out = transferred<D>(from, {field_of(from, 2, {tent})}, to);
        for (std::size_t n = 0; n < node_count_of(to, 2); ++n) {
            const double x = node_place(to, n)[0];
            // On the wall both materials are evaluated; the right one contains the node.
            const double left = std::min(x, wall), right = 1 - x;
            CHECK(out.fields[0].values[n] == doctest::Approx(x < moved - 1e-9 ? left : right).epsilon(1e-12));
        }
        CHECK(out.statistics.outside > 0);
        CHECK(out.statistics.integrals[0].size() == 2);
        CHECK(*out.statistics.integrals[0][0].reference == 3);
        CHECK(out.statistics.integrals[0][0].before[0] == doctest::Approx(0.125).epsilon(1e-12));
    }
    SUBCASE("a mesh with one material is interpolated from all materials") {
        const auto from = two_materials<D>(0.5);
        auto to = two_materials<D>(0.55);
        to.linear.elements.references = Buffer<Reference>(to.linear.elements.size(), 3);
        const Function<D> along = [](const Vec<D>& x) { return x[0]; };
        const auto out = transferred<D>(from, {field_of(from, 2, {along})}, to);
        CHECK(largest_difference(out.fields[0], field_of(to, 2, {along})) < 1e-12);
        CHECK(out.statistics.outside == 0);
        CHECK(!out.statistics.integrals[0][0].reference);
    }
    SUBCASE("a new material is interpolated from all materials") {
        const auto from = two_materials<D>(0.5);
        auto to = two_materials<D>(0.55);
        auto references = take(std::move(to.linear.elements.references));
        for (Reference& r : references)
            if (r == 7) r = 8;
        to.linear.elements.references = std::move(references);
        const Function<D> along = [](const Vec<D>& x) { return x[0]; };
        const auto out = transferred<D>(from, {field_of(from, 2, {along})}, to);
        CHECK(largest_difference(out.fields[0], field_of(to, 2, {along})) < 1e-12);
        CHECK(out.statistics.integrals[0].size() == 2);
    }
}

}  // namespace

TEST_CASE("interpolation reproduces polynomials of the degree of the field") {
    check_polynomials<2>();
    check_polynomials<3>();
}
TEST_CASE("transfer keeps the values of unchanged nodes, 2D") { check_unchanged_nodes<2>(); }
TEST_CASE("transfer keeps the values of unchanged nodes, 3D") { check_unchanged_nodes<3>(); }
TEST_CASE("interpolation handles nodes outside the old mesh, 2D") { check_outside_nodes<2>(); }
TEST_CASE("interpolation handles nodes outside the old mesh, 3D") { check_outside_nodes<3>(); }
TEST_CASE("interpolation respects materials, 2D") { check_material_values<2>(); }
TEST_CASE("interpolation respects materials, 3D") { check_material_values<3>(); }
