// Fields within elements: polynomials are exact, use only nodes of their material, and do not depend on frame or
// threads. Functions are sampled in the curved elements.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>
#include <rapidcheck.h>

#include "fields.hpp"
#include "property.hpp"

import camber.bezier;
import camber.core;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
using Function = std::function<double(const Vec<D>&)>;

template <int D>
std::vector<Column<LatticeValues<D>>> values_within(const QuadraticMesh<D>& mesh,
                                                    const std::vector<Column<double>>& fields, int threads = 1) {
    return must(element_values<D>(mesh, fields, mesh, Execution{.threads = threads}));
}

/// Positions of the lattice of a curved element.
template <int D>
std::vector<Vec<D>> lattice_of(const QuadraticMesh<D>& mesh, ElementId e) {
    std::vector<Vec<D>> places;
    for (const auto& alpha : multi_indices<lattice_degree, D>) {
        std::array<double, D + 1> at{};
        for (std::size_t v = 0; v <= D; ++v) at[v] = static_cast<double>(alpha[v]) / lattice_degree;
        Vec<D> x;
        for (std::size_t v = 0; v <= D; ++v) x += at[v] * mesh.linear.points[mesh.linear.elements.vertices[e][v]];
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            x += edge_shape<D>(at, k) * edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
        places.push_back(x);
    }
    return places;
}

/// The largest difference from u over all elements, relative to the largest value in the element.
template <int D>
double largest_error(const QuadraticMesh<D>& mesh, const Column<LatticeValues<D>>& found, const Function<D>& u) {
    double largest = 0;
    for (std::size_t e = 0; e < found.size(); ++e) {
        const std::vector<Vec<D>> places = lattice_of(mesh, ElementId(e));
        double error = 0, size = 0;
        for (std::size_t q = 0; q < places.size(); ++q) {
            const double is = u(places[q]) - u(places[0]);
            error = std::max(error, std::abs(static_cast<double>(found[e][q]) - is));
            size = std::max(size, std::abs(is));
        }
        largest = std::max(largest, error / size);
    }
    return largest;
}

template <int D>
void check_exact() {
    for (const int degree : {1, 2})
        property("element values are exact for stretched polynomials of degree k + 3",
                 [degree](std::uint64_t seed) {
                     Dice dice(seed);
                     Frame<D> frame;
                     for (double& s : frame.stretch.c) s = std::pow(10.0, dice.uniform(-3, 3));
                     const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 7 : 5), seed, 0.12, 0.08, frame);
                     const RandomPolynomial<D> p(degree + 3, dice);
                     const Function<D> u = [&](const Vec<D>& x) { return p(frame.inside(x)); };
                     const auto found = values_within<D>(mesh, {values_of<D>(mesh, degree, u)});
                     RC_ASSERT(largest_error<D>(mesh, found[0], u) < 1e-5);
                 },
                 {.count = 3});
}

/// Target elements whose nodes differ from those of the values.
template <int D>
void check_curved() {
    property("values are those at the nodes of the curved target elements",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 7 : 5), seed, 0.1, 0.05);
                 auto curved = mesh;
                 Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
                 for (auto& node : nodes) node.point += 0.05 * dice.vector<D>(-1, 1);
                 curved.mid_nodes = std::move(nodes);
                 const RandomPolynomial<D> p(5, dice);
                 const Function<D> u = [&](const Vec<D>& x) { return p(x); };
                 const auto values = values_of<D>(mesh, 2, u);
                 const auto found = must(element_values<D>(mesh, std::array{values}, curved, Execution{}));
                 RC_ASSERT(largest_error<D>(curved, found[0], u) < 1e-5);
             },
             {.count = 3});
}

/// The mesh has 25 nodes: enough for degree 4, but not for degree 5.
void check_few() {
    property("few nodes give a polynomial of lower degree",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = bent_mesh<2>(cells_of<2>(2), seed, 0.1, 0.05);
                 const RandomPolynomial<2> p(4, dice);
                 const Function<2> u = [&](const Vec<2>& x) { return p(x); };
                 const auto found = values_within<2>(mesh, {values_of<2>(mesh, 2, u)});
                 RC_ASSERT(largest_error<2>(mesh, found[0], u) < 1e-4);
             },
             {.count = 3});
}

template <int D>
void check_materials() {
    property("a kink between materials does not affect the values within them",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 8 : 6), seed, 0, 0);
                 const double middle = D == 2 ? 4 : 3;
                 Buffer<Reference> materials(mesh.linear.elements.size());
                 for (std::size_t e = 0; e < materials.size(); ++e) {
                     double x = 0;
                     for (const VertexId v : mesh.linear.elements.vertices[e]) x += mesh.linear.points[v][0] / (D + 1);
                     materials[e] = x < middle ? 1 : 2;
                 }
                 mesh.linear.elements.references = std::move(materials);
                 const RandomPolynomial<D> p(3, dice);
                 const Function<D> u = [&](const Vec<D>& x) { return p(x) + 5 * std::max(x[0] - middle, 0.0); };
                 const auto found = values_within<D>(mesh, {values_of<D>(mesh, 2, u)});
                 RC_ASSERT(largest_error<D>(mesh, found[0], u) < 1e-5);
             },
             {.count = 3});
}

template <int D>
void check_functions() {
    property("function values are those on curved elements, in units of a power of two",
             [](std::uint64_t seed) {
                 const auto mesh = bent_mesh<D>(cells_of<D>(3), seed, 0.3, 0.2);
                 const Function<D> u = [](const Vec<D>& x) { return 1e6 * std::exp(-norm(x)) / (2 + x[0]); };
                 const FunctionOfPosition<D> function = [&] {
                     return [&](std::span<const Vec<D>> points, std::span<double> values) {
                         for (std::size_t i = 0; i < points.size(); ++i) values[i] = u(points[i]);
                     };
                 };
                 const auto [found, exponent] = must(element_values<D>(mesh, function, Execution{}));
                 const auto places = lattice_of(mesh, ElementId(0));
                 const double unit = (u(places[1]) - u(places[0])) / static_cast<double>(found[ElementId(0)][1]);
                 const double power = std::ldexp(1.0, exponent);
                 RC_ASSERT(std::abs(unit / power - 1) < 1e-5);
                 RC_ASSERT(largest_error<D>(mesh, found, [&](const Vec<D>& x) { return u(x) / power; }) < 1e-6);
             },
             {.count = 3});
}

template <int D>
void check_bytes() {
    const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 8 : 4), 3);
    Dice dice(4);
    const auto noise = values_of<D>(mesh, 2, [&](const Vec<D>&) { return dice.uniform(-1, 1); });
    const auto constant = values_of<D>(mesh, 2, [](const Vec<D>&) { return 0.1; });
    const auto one = values_within<D>(mesh, {noise}), both = values_within<D>(mesh, {constant, noise}, 3);
    CHECK(one[0] == both[1]);
    CHECK(std::ranges::all_of(both[0], [](const auto& values) { return values == LatticeValues<D>{}; }));
}

}  // namespace

TEST_CASE("element values are exact for polynomials of degree k + 3, 2D") { check_exact<2>(); }
TEST_CASE("element values follow the nodes of the target elements, 2D") { check_curved<2>(); }
TEST_CASE("element values are exact for polynomials of degree k + 3, 3D") { check_exact<3>(); }
TEST_CASE("element values follow the nodes of the target elements, 3D") { check_curved<3>(); }
TEST_CASE("element values have a lower degree where nodes are few") { check_few(); }
TEST_CASE("element values use only nodes of the material of the element, 2D") { check_materials<2>(); }
TEST_CASE("element values use only nodes of the material of the element, 3D") { check_materials<3>(); }
TEST_CASE("element values of a function are its values on the curved elements, 2D") { check_functions<2>(); }
TEST_CASE("element values of a function are its values on the curved elements, 3D") { check_functions<3>(); }
TEST_CASE("element values do not depend on other fields or the number of threads, 2D") { check_bytes<2>(); }
TEST_CASE("element values do not depend on other fields or the number of threads, 3D") { check_bytes<3>(); }
