// Projection of fields where a mesh changed.
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

constexpr TransferOptions conserving{.method = TransferMethod::conserve};

/// True if all integrals agree to 1e-12 of the volume times the largest value.
bool conserves_integrals(const Transferred& out, double size = 1) {
    for (const auto& field : out.statistics.integrals)
        for (const MaterialIntegrals& row : field)
            for (std::size_t c = 0; c < row.before.size(); ++c)
                if (!(std::abs(row.after[c] - row.before[c]) <= 1e-12 * size)) return false;
    return true;
}

template <int D>
void check_reproduction() {
    property("projection reproduces polynomials on straight meshes",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto from = quadratic(rough_box<D>(2, seed + 1)), to = quadratic(rough_box<D>(3, seed + 2));
                 const std::vector<Function<D>> quadratics{polynomial<D>(2, dice), polynomial<D>(2, dice)};
                 const std::vector<Function<D>> affine{polynomial<D>(1, dice)};
                 const auto out =
                     transferred<D>(from, {field_of(from, 2, quadratics), field_of(from, 1, affine)}, to, conserving);
                 RC_ASSERT(largest_difference(out.fields[0], field_of(to, 2, quadratics)) < 1e-12);
                 RC_ASSERT(largest_difference(out.fields[1], field_of(to, 1, affine)) < 1e-12);
                 RC_ASSERT(conserves_integrals(out));
             },
             {.count = 5});
    property("projection reproduces functions of degree 2 in the reference on curved meshes",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const QuadraticMap<D> map(dice);
                 const auto a = quadratic(rough_box<D>(2, seed + 1)), b = quadratic(rough_box<D>(3, seed + 2));
                 const auto u = polynomial<D>(2, dice);
                 const auto out = transferred<D>(map(a), {field_of(a, 2, {u})}, map(b), conserving);
                 RC_ASSERT(largest_difference(out.fields[0], field_of(b, 2, {u})) < 1e-11);
             },
             {.count = 5});
    SUBCASE("projection to a refined mesh and back reproduces the field") {
        Dice dice(3);
        const auto coarse = quadratic(lattice_in_box<D>(2)), fine = quadratic(lattice_in_box<D>(4));
        const std::vector fields{rough_field(node_count_of(coarse, 2), 2, 2, dice)};
        const auto there = transferred<D>(coarse, fields, fine, conserving);
        CHECK(largest_difference(there.fields[0], transferred<D>(coarse, fields, fine).fields[0]) < 1e-12);
        CHECK(largest_difference(transferred<D>(fine, there.fields, coarse, conserving).fields[0], fields[0]) < 1e-11);
    }
}

template <int D>
void check_integrals() {
    property("projection conserves the integrals of any field on any mesh of the domain",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto from = bent_inside(quadratic(rough_box<D>(3, seed + 1)), 0.03, dice);
                 const auto to = bent_inside(quadratic(rough_box<D>(2, seed + 2)), 0.05, dice);
                 const std::vector fields{rough_field(node_count_of(from, 2), 2, D, dice),
                                          rough_field(node_count_of(from, 1), 1, 1, dice)};
                 const auto out = transferred<D>(from, fields, to, conserving);
                 RC_ASSERT(conserves_integrals(out));
                 RC_ASSERT(out.statistics.patches == 1U);
                 RC_ASSERT(out.statistics.turned == 0U);
             },
             {.count = 5});
    SUBCASE("projection conserves the integrals of each material") {
        Dice dice(2);
        auto from = quadratic(rough_box<D>(4, 1)), to = bent_inside(quadratic(lattice_in_box<D>(6)), 0.02, dice);
        // The interface of the rough mesh is not a plane.
        const auto paint = [](QuadraticMesh<D>& mesh, const auto& is_left) {
            auto references = take(std::move(mesh.linear.elements.references));
            for (std::size_t e = 0; e < references.size(); ++e) {
                Vec<D> centre;
                for (const Vec<D>& p : corners(mesh.linear, e)) centre += p / (D + 1);
                references[e] = is_left(centre) ? 2 : 5;
            }
            mesh.linear.elements.references = std::move(references);
        };
        for (auto* mesh : {&from, &to}) paint(*mesh, [](const Vec<D>& x) { return x[0] < 0.5; });
        const std::vector fields{rough_field(node_count_of(from, 2), 2, 2, dice)};
        const auto out = transferred<D>(from, fields, to, conserving);
        CHECK(out.statistics.integrals[0].size() == 2);
        CHECK(conserves_integrals(out));
        // Interpolation does not conserve integrals.
        CHECK(!conserves_integrals(transferred<D>(from, fields, to), 1e6));
    }
    SUBCASE("projection conserves the integrals of the old mesh where the domain changes") {
        Dice dice(4);
        const auto from = quadratic(rough_box<D>(3, 1));
        const auto to = QuadraticMap<D>(dice)(quadratic(rough_box<D>(3, 2)));
        const auto out = transferred<D>(from, {rough_field(node_count_of(from, 2), 2, 1, dice)}, to, conserving);
        CHECK(out.statistics.outside > 0);
        CHECK(conserves_integrals(out));
    }
}

/// Two changes at both ends of a row of boxes form two patches.
template <int D>
void check_separate_patches() {
    SUBCASE("each patch conserves its integrals, and nodes between patches keep their values") {
        Dice dice(6);
        LatticeOptions<D> options;
        options.cells.fill(3);
        options.cells[0] = 9;
        options.place = [](const Vec<D>& p) { return p / 3; };
        const auto from = quadratic(lattice_mesh(options));
        options.place = [](const Vec<D>& p) {
            Vec<D> x = p / 3;
            bool is_inside = true;
            for (int i = 1; i < D; ++i) is_inside = is_inside && p[i] == 1;
            if (is_inside && (p[0] == 1 || p[0] == 8)) x[0] += 0.05;
            return x;
        };
        const auto to = quadratic(lattice_mesh(options));
        const std::vector fields{rough_field(node_count_of(from, 2), 2, 1, dice)};
        const auto out = transferred<D>(from, fields, to, conserving);
        CHECK(out.statistics.patches == 2);
        CHECK(out.statistics.turned == 0);
        CHECK(conserves_integrals(out));
        std::size_t moved = 0;
        double drift = 0;
        for (std::size_t n = 0; n < node_count_of(to, 2); ++n) {
            const bool is_unchanged = out.fields[0].values[n] == fields[0].values[n];
            moved += is_unchanged ? 0 : 1;
            if (node_place(to, n)[0] > 1 && node_place(to, n)[0] < 2) CHECK(is_unchanged);
            drift = std::max(drift, std::abs(out.fields[0].values[n] - fields[0].values[n]));
        }
        CHECK(moved == out.statistics.projected);
        CHECK(moved > 0);
        CHECK(drift < 1);
    }
}

/// The root mean square change of the nodes of a front after twenty transfers back and forth.
template <int D>
double drift_of_front(TransferMethod method, int cells) {
    const auto a = quadratic(rough_box<D>(cells, 1)), b = quadratic(rough_box<D>(cells, 2));
    const Function<D> front = [cells](const Vec<D>& x) { return std::tanh((norm(x) - 0.7) * cells); };
    const auto begin = field_of(a, 2, {front});
    auto field = begin;
    for (int k = 0; k < 10; ++k) {
        const auto there = transferred<D>(a, {field}, b, {.method = method});
        field = transferred<D>(b, there.fields, a, {.method = method}).fields[0];
    }
    double sum = 0;
    for (std::size_t i = 0; i < field.values.size(); ++i) sum += std::pow(field.values[i] - begin.values[i], 2);
    return std::sqrt(sum / static_cast<double>(field.values.size()));
}

template <int D>
void check_local_bounds() {
    property("limited values stay between those of the old elements and conserve integrals",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto from = quadratic(rough_box<D>(4, seed + 1)), to = quadratic(rough_box<D>(5, seed + 2));
                 const double wall = dice.uniform(0.3, 0.7);
                 const Function<D> jump = [wall](const Vec<D>& x) { return x[0] < wall ? 0.0 : 1.0; };
                 const std::vector fields{field_of(from, 2, {jump}), field_of(from, 1, {jump})};
                 auto options = conserving;
                 options.bounds = TransferBounds::local;
                 const auto out = transferred<D>(from, fields, to, options);
                 double least = 1, least_without = 1;
                 for (const double u : out.fields[0].values) least = std::min(least, std::min(u, 1 - u));
                 for (const double u : out.fields[1].values) least = std::min(least, std::min(u, 1 - u));
                 RC_ASSERT(least >= 0);
                 RC_ASSERT(conserves_integrals(out));
                 const auto without = transferred<D>(from, fields, to, conserving);
                 for (const double u : without.fields[0].values)
                     least_without = std::min(least_without, std::min(u, 1 - u));
                 RC_ASSERT(least_without < -1e-3);
             },
             {.count = 3});
}

/// Layers of thickness `thin`, at a distance from the origin.
template <int D>
void check_extreme_layers(double thin, double far) {
    const auto placed = [&](QuadraticMesh<D> mesh) {
        const auto place = [&](Vec<D>& p) {
            p[D - 1] *= thin;
            for (double& x : p.c) x += far;
        };
        auto points = take(std::move(mesh.linear.points));
        for (Vec<D>& p : points) place(p);
        mesh.linear.points = std::move(points);
        return quadratic(std::move(mesh.linear));
    };
    const auto a = quadratic(rough_box<D>(3, 1)), b = quadratic(rough_box<D>(4, 2));
    const auto from = placed(a), to = placed(b);
    Dice dice(3);
    const auto u = polynomial<D>(2, dice);
    // The rounding error of a coordinate, relative to the thickness.
    const double blur = 1e-14 * (1 + far / thin) + 1e-9;
    for (const auto& method : words(TransferMethod{})) {
        const auto out = transferred<D>(from, {field_of(a, 2, {u})}, to, {.method = method.value});
        CHECK(out.statistics.lost == 0);
        CHECK(out.statistics.largest_distance <= 1e-14 * (1 + far));
        CHECK(largest_difference(out.fields[0], field_of(b, 2, {u})) < 10 * blur);
        if (method.value == TransferMethod::conserve) CHECK(conserves_integrals(out, thin));
    }
}

/// Layers of thickness 10⁻⁴ that bend by hundreds of their thickness.
template <int D>
void check_bent_layers() {
    Dice dice(5);
    const QuadraticMap<D> map(dice);
    const auto thin = [](QuadraticMesh<D> mesh) {
        auto points = take(std::move(mesh.linear.points));
        for (Vec<D>& p : points) p[D - 1] *= 1e-4;
        mesh.linear.points = std::move(points);
        return quadratic(std::move(mesh.linear));
    };
    const auto a = quadratic(rough_box<D>(4, 1)), b = quadratic(rough_box<D>(5, 2));
    const auto from = map(thin(a)), to = map(thin(b));
    const auto u = polynomial<D>(2, dice);
    for (const auto& method : words(TransferMethod{})) {
        const auto out = transferred<D>(from, {field_of(a, 2, {u})}, to, {.method = method.value});
        CHECK(out.statistics.lost == 0);
        CHECK(out.statistics.largest_distance < 1e-14);
        CHECK(largest_difference(out.fields[0], field_of(b, 2, {u})) < 1e-8);
    }
}

template <int D>
void check_threads() {
    Dice dice(9);
    const auto from = bent_inside(quadratic(rough_box<D>(5, 1)), 0.03, dice);
    const auto to = bent_inside(quadratic(rough_box<D>(6, 2)), 0.05, dice);
    const std::vector fields{rough_field(node_count_of(from, 2), 2, 2, dice),
                             rough_field(node_count_of(from, 1), 1, 1, dice)};
    for (const auto bounds : {TransferBounds::none, TransferBounds::local}) {
        auto options = conserving;
        options.bounds = bounds;
        const auto serial = transferred<D>(from, fields, to, options);
        for (const int threads : {2, 7}) {
            const auto out = transferred<D>(from, fields, to, options, threads);
            CHECK(out.fields == serial.fields);
            CHECK(out.statistics.integrals[0][0].after == serial.statistics.integrals[0][0].after);
            CHECK(out.statistics.largest_distance == serial.statistics.largest_distance);
        }
    }
}

}  // namespace

TEST_CASE("projection reproduces fields of the new space, 2D") { check_reproduction<2>(); }
TEST_CASE("projection reproduces fields of the new space, 3D") { check_reproduction<3>(); }
TEST_CASE("projection conserves integrals, 2D") { check_integrals<2>(); }
TEST_CASE("projection conserves integrals, 3D") { check_integrals<3>(); }
TEST_CASE("projection changes only nodes of changed patches") {
    SUBCASE("2D") { check_separate_patches<2>(); }
    SUBCASE("3D") { check_separate_patches<3>(); }
}
TEST_CASE("a patch without free nodes keeps the values on its boundary") {
    // The swapped diagonal of a square. In degree 1 no node belongs only to changed elements.
    const Buffer<Vec<2>> points{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}, {{2, 0.5}}, {{-1, 0.5}}};
    const auto triangle = [](std::size_t a, std::size_t b, std::size_t c) {
        return SimplexVertices<2>{VertexId(a), VertexId(b), VertexId(c)};
    };
    const auto with = [&](const SimplexVertices<2>& a, const SimplexVertices<2>& b) {
        return quadratic(mesh_of<2>(points, {a, b, triangle(1, 4, 2), triangle(0, 3, 5)}));
    };
    const auto from = with(triangle(0, 1, 2), triangle(0, 2, 3)), to = with(triangle(0, 1, 3), triangle(1, 2, 3));
    Dice dice(1);
    const std::vector fields{rough_field(6, 1, 1, dice), rough_field(node_count_of(from, 2), 2, 1, dice)};
    const auto out = transferred<2>(from, fields, to, conserving);
    CHECK(out.statistics.changed_elements == 2);
    CHECK(out.statistics.patches == 1);
    CHECK(out.statistics.projected == 3);  // in degree 2: the nodes of the diagonal and of two sides
    CHECK(out.fields[0] == fields[0]);
    CHECK(out.statistics.spread == 1);
    CHECK(out.statistics.unconserved_materials == 1);
    const auto &linear = out.statistics.integrals[0][0], &quadratic_one = out.statistics.integrals[1][0];
    CHECK(std::abs(linear.after[0] - linear.before[0]) > 1e-3);
    CHECK(quadratic_one.after[0] == doctest::Approx(quadratic_one.before[0]).epsilon(1e-13));
}
TEST_CASE("twenty conservative transfers lose less than interpolations") {
    CHECK(drift_of_front<2>(TransferMethod::conserve, 8) < 0.6 * drift_of_front<2>(TransferMethod::interpolate, 8));
    CHECK(drift_of_front<3>(TransferMethod::conserve, 3) < 0.8 * drift_of_front<3>(TransferMethod::interpolate, 3));
}
TEST_CASE("limited projection stays within the old values and conserves integrals") {
    check_local_bounds<2>();
    check_local_bounds<3>();
}
TEST_CASE("transfer is accurate for thin layers far from the origin") {
    check_extreme_layers<2>(1e-6, 0);
    check_extreme_layers<3>(1e-6, 0);
    check_extreme_layers<2>(1e-3, 1e6);
    check_extreme_layers<3>(1e-3, 1e6);
    check_extreme_layers<2>(1e-6, 1e6);
    check_extreme_layers<3>(1e-6, 1e6);
    check_extreme_layers<3>(1e6, 0);
}
TEST_CASE("transfer is accurate for thin curved layers") {
    check_bent_layers<2>();
    check_bent_layers<3>();
}
TEST_CASE("projection is exact for meshes larger than one batch of elements") {
    // More elements than one batch.
    Dice dice(2);
    const auto from = quadratic(rough_box<2>(10, 1)), to = quadratic(rough_box<2>(less_if_sanitized(185, 95), 2));
    const std::vector<Function<2>> functions{polynomial<2>(2, dice), polynomial<2>(2, dice)};
    const auto out = transferred<2>(from, {field_of(from, 2, functions)}, to, conserving, 2);
    CHECK(largest_difference(out.fields[0], field_of(to, 2, functions)) < 1e-12);
    const auto back = transferred<2>(to, {rough_field(node_count_of(to, 2), 2, 1, dice)}, from, conserving, 2);
    CHECK(conserves_integrals(back));
}
TEST_CASE("projection does not depend on the number of threads") {
    check_threads<2>();
    check_threads<3>();
}
