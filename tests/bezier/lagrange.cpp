// Lagrange functions on equispaced nodes, for shapes and degrees.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;

using namespace camber;
using namespace camber::testing;

namespace {

template <class F>
void each_shape(const F& f) {
    f.template operator()<Shape::line>();
    f.template operator()<Shape::triangle>();
    f.template operator()<Shape::quadrilateral>();
    f.template operator()<Shape::tetrahedron>();
    f.template operator()<Shape::prism>();
    f.template operator()<Shape::pyramid>();
    f.template operator()<Shape::hexahedron>();
}

template <Shape shape, class F>
void each_degree(const F& f) {
    f.template operator()<shape, 1>();
    f.template operator()<shape, 2>();
    f.template operator()<shape, 3>();
    f.template operator()<shape, 4>();
    f.template operator()<shape, 5>();
}

/// A random point of the unit cube. It need not be in the element, because the functions are polynomials.
template <Shape shape>
ReferencePoint random_point(Dice& dice) {
    ReferencePoint x{};
    for (int d = 0; d < shape_table<shape>.dimension; ++d) x[d] = dice.uniform(0, 1);
    return x;
}

/// A polynomial of the element's space and its gradient: a product of powers of linear functions.
struct Value {
    double value = 0;
    ReferencePoint gradient{};
};
template <Shape shape, int degree>
Value polynomial(const ReferencePoint& x) {
    const auto power = [](double t) { return std::pow(t, degree); };
    const auto slope = [](double t) { return degree * std::pow(t, degree - 1); };
    if constexpr (is_simplex(shape)) {
        const double t = 0.3 + x[0] - 0.7 * x[1] + 0.4 * x[2];
        return {power(t), {slope(t), -0.7 * slope(t), 0.4 * slope(t)}};
    } else if constexpr (shape == Shape::prism) {
        const double t = 0.3 + x[0] - 0.7 * x[1], s = 0.2 + x[2];
        return {power(t) * power(s), {slope(t) * power(s), -0.7 * slope(t) * power(s), power(t) * slope(s)}};
    } else {
        const double r = 0.3 + x[0], s = 0.8 - x[1], t = 0.5 + x[2];
        return {power(r) * power(s) * power(t),
                {slope(r) * power(s) * power(t), -power(r) * slope(s) * power(t), power(r) * power(s) * slope(t)}};
    }
}

template <Shape shape, int degree>
ReferencePoint reference_node(std::size_t n) {
    ReferencePoint x{};
    for (std::size_t d = 0; d < 3; ++d) x[d] = double(lagrange_nodes<shape, degree>[n][d]) / degree;
    return x;
}

}  // namespace

TEST_CASE("Lagrange nodes are distinct and ordered by corners, edges, faces and interior") {
    each_shape([]<Shape shape>() {
        each_degree<shape>([]<Shape, int degree>() {
            constexpr ShapeTable table = shape_table<shape>;
            const auto& nodes = lagrange_nodes<shape, degree>;
            CAPTURE(static_cast<int>(shape));
            CAPTURE(degree);
            CHECK(std::set(nodes.begin(), nodes.end()).size() == nodes.size());
            std::size_t n = table.corner_count;
            if (table.dimension > 1)
                for (int e = 0; e < table.edge_count; ++e)
                    for (int i = 1; i < degree; ++i, ++n)
                        for (std::size_t d = 0; d < 3; ++d)
                            CHECK(nodes[n][d] == (degree - i) * table.coordinates[table.edges[e][0]][d] +
                                                     i * table.coordinates[table.edges[e][1]][d]);
            // The inside of a face is an average of its corners with positive weights.
            for (int f = 0; f < table.face_count; ++f) {
                const auto& [face, corners] = table.faces[f];
                const auto at = [&](int c) { return table.coordinates[corners[c]]; };
                const int inner = inner_node_count(face, degree);
                for (int i = 0; i < inner; ++i, ++n)
                    for (std::size_t d = 0; d < 3; ++d) {
                        const int last = face == Shape::triangle ? 2 : 3;
                        const int low = std::min({at(0)[d], at(1)[d], at(last)[d]});
                        const int high = std::max({at(0)[d], at(1)[d], at(last)[d]});
                        CHECK((low == high ? nodes[n][d] == degree * low
                                           : nodes[n][d] > degree * low && nodes[n][d] < degree * high));
                    }
            }
            CHECK(n + inner_node_count(shape, degree) == nodes.size());
        });
    });
}

TEST_CASE("each Lagrange function is 1 at its node and 0 at the others") {
    each_shape([]<Shape shape>() {
        if constexpr (shape != Shape::pyramid)
            each_degree<shape>([]<Shape, int degree>() {
                for (std::size_t n = 0; n < lagrange_nodes<shape, degree>.size(); ++n) {
                    const auto functions = lagrange_functions<shape, degree>(reference_node<shape, degree>(n));
                    for (std::size_t m = 0; m < functions.values.size(); ++m)
                        CHECK(std::abs(functions.values[m] - (m == n ? 1 : 0)) < 1e-12);
                }
            });
    });
}

TEST_CASE("Lagrange functions reproduce polynomials and their gradients") {
    property("Lagrange functions of all shapes and degrees reproduce polynomials",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 each_shape([&]<Shape shape>() {
                     if constexpr (shape != Shape::pyramid)
                         each_degree<shape>([&]<Shape, int degree>() {
                             const ReferencePoint x = random_point<shape>(dice);
                             const auto functions = lagrange_functions<shape, degree>(x);
                             Value sum;
                             for (std::size_t n = 0; n < functions.values.size(); ++n) {
                                 const double at_node =
                                     polynomial<shape, degree>(reference_node<shape, degree>(n)).value;
                                 sum.value += at_node * functions.values[n];
                                 for (int d = 0; d < shape_table<shape>.dimension; ++d)
                                     sum.gradient[d] += at_node * functions.gradients[n][d];
                             }
                             const Value expected = polynomial<shape, degree>(x);
                             const double scale = 1e-9 * std::pow(2.0, 3 * degree);
                             RC_ASSERT(std::abs(sum.value - expected.value) < scale);
                             for (int d = 0; d < shape_table<shape>.dimension; ++d)
                                 RC_ASSERT(std::abs(sum.gradient[d] - expected.gradient[d]) < scale);
                         });
                 });
             },
             {.count = 20});
}

TEST_CASE("Lagrange functions of simplices equal those by multi-indices") {
    Dice dice(3);
    const auto xi = dice.barycentric<3>();
    const auto functions = lagrange_functions<Shape::tetrahedron, 4>({xi[1], xi[2], xi[3]});
    for (std::size_t n = 0; n < functions.values.size(); ++n) {
        const auto& node = lagrange_nodes<Shape::tetrahedron, 4>[n];
        const MultiIndex<3> alpha{4 - node[0] - node[1] - node[2], node[0], node[1], node[2]};
        CHECK(std::abs(functions.values[n] - lagrange<3>(alpha, xi)) < 1e-13);
    }
}
