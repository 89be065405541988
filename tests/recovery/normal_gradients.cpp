// Derivatives along facet normals: linear fields, weights, units, interfaces and errors.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "domains.hpp"
#include "fields.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
std::vector<NormalGradients> gradients_of(const QuadraticMesh<D>& mesh, const std::vector<Column<double>>& fields,
                                          const std::vector<double>& weights) {
    const auto around = must(balls(mesh.linear, one_thread));
    return must(normal_gradients<D>(mesh, around, recovered<D>(mesh, fields), weights, one_thread));
}

template <int D>
std::vector<NormalGradients> gradients_of(const QuadraticMesh<D>& mesh, const Column<double>& field) {
    return gradients_of<D>(mesh, {field}, {1});
}

constexpr Reference interface_reference = 20;

/// A box of unit cells of two materials, which meet in the middle plane of the first axis. Facets have references.
template <int D>
QuadraticMesh<D> box(int cells) {
    LatticeOptions<D> options;
    options.cells = cells_of<D>(cells);
    return must(elevate(with_references<D>(lattice_mesh<D>(options), options.cells, false), one_thread));
}
/// The axis of the facet normals of a reference.
int axis_of(Reference reference) {
    return reference == interface_reference ? 0 : static_cast<int>((reference - 1) / 2);
}

template <int D>
void check_linear() {
    property("linear fields have their gradient along the normal of each reference", [](std::uint64_t seed) {
        Dice dice(seed);
        const int cells = 4;
        const auto mesh = box<D>(cells);
        const Vec<D> g = dice.vector<D>(-3, 3), h = dice.vector<D>(-3, 3);
        const double weight = dice.uniform(0.1, 5);
        for (const int degree : {1, 2}) {
            const auto u = values_of<D>(mesh, degree, [&](const Vec<D>& x) { return dot(g, x); });
            const auto v = values_of<D>(mesh, degree, [&](const Vec<D>& x) { return dot(h, x); });
            const auto found = gradients_of<D>(mesh, {u, v}, {1, weight});
            REQUIRE(found.size() == 2 * D + 1);
            for (const NormalGradients& of : found) {
                const int axis = axis_of(of.reference);
                const double expected = std::hypot(g[axis], weight * h[axis]), area = std::pow(cells, D - 1);
                CHECK(of.area == doctest::Approx(area));
                CHECK(of.integral == doctest::Approx(area * expected));
                CHECK(of.squares == doctest::Approx(area * expected * expected));
            }
        }
    });
}

template <int D>
void check_units() {
    property("integrals scale with the units of the field and of length", [](std::uint64_t seed) {
        Dice dice(seed);
        const double unit = std::pow(10.0, dice.uniform(-9, 9)), length = std::pow(10.0, dice.uniform(-3, 3));
        Frame<D> larger;
        for (int i = 0; i < D; ++i) larger.stretch[i] = length;
        const auto mesh = box<D>(4);
        const auto scaled = mapped<D>(box<D>(4), [&](const Vec<D>& z) { return larger.outside(z); });
        const RandomPolynomial<D> p(2, dice);
        const auto before = gradients_of<D>(mesh, values_of<D>(mesh, 2, [&](const Vec<D>& x) { return p(x); }));
        const auto after = gradients_of<D>(
            scaled, values_of<D>(scaled, 2, [&](const Vec<D>& x) { return unit * p(larger.inside(x)); }));
        REQUIRE(before.size() == 2 * D + 1);
        REQUIRE(before.size() == after.size());
        for (std::size_t i = 0; i < before.size(); ++i) {
            const double area = std::pow(length, D - 1), slope = unit / length;
            CHECK(after[i].area == doctest::Approx(area * before[i].area));
            CHECK(after[i].integral == doctest::Approx(area * slope * before[i].integral).epsilon(1e-6));
            CHECK(after[i].squares == doctest::Approx(area * slope * slope * before[i].squares).epsilon(1e-6));
        }
    });
}

}  // namespace

TEST_CASE("normal derivatives of linear fields are exact") {
    check_linear<2>();
    check_linear<3>();
}

TEST_CASE("integrals of normal derivatives scale with the units of field and length") {
    check_units<2>();
    check_units<3>();
}

TEST_CASE("constant fields have no normal derivative") {
    const auto mesh = box<2>(3);
    for (const NormalGradients& of : gradients_of<2>(mesh, values_of<2>(mesh, 2, [](const Vec<2>&) { return 7.0; }))) {
        CHECK(of.integral == doctest::Approx(0).epsilon(1e-10));
        CHECK(of.squares == doctest::Approx(0).epsilon(1e-10));
    }
}

TEST_CASE("normal_gradients rejects weights whose number differs from that of the fields") {
    const auto mesh = box<2>(3);
    const auto field = values_of<2>(mesh, 1, [](const Vec<2>& x) { return x[0]; });
    const auto around = must(balls(mesh.linear, one_thread));
    const auto found =
        normal_gradients<2>(mesh, around, recovered<2>(mesh, {field}), std::vector<double>{1, 1}, one_thread);
    REQUIRE(!found);
    CHECK(found.error().kind == ErrorKind::usage);
}

TEST_CASE("the normal derivative at an interface is the larger of both sides") {
    const auto mesh = box<2>(4);
    for (const double slope : {0.5, 4.0}) {
        const auto kink = [&](const Vec<2>& x) { return x[0] < 2 ? x[0] - 2 : slope * (x[0] - 2); };
        const auto found = gradients_of<2>(mesh, values_of<2>(mesh, 2, kink));
        REQUIRE(found.back().reference == interface_reference);
        CHECK(found.back().area == doctest::Approx(4));
        CHECK(found.back().integral == doctest::Approx(4 * std::max(1.0, slope)));
    }
}
