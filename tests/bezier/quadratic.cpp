// P2 edges and simplices.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
QuadraticEdge<D> random_edge(Dice& dice) {
    return {dice.vector<D>(), {dice.vector<D>()}, dice.vector<D>()};
}

template <int D>
void check_edge_maps() {
    property("points and derivatives of an edge equal those of its Bernstein form", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto edge = random_edge<D>(dice);
        const Vec<D> p11 = control_point(edge.p20, edge.mid, edge.p02).point;
        const double t = dice.uniform(0, 1);
        const double s = 1 - t;
        RC_ASSERT(norm(edge.point(t) - (s * s * edge.p20 + 2 * s * t * p11 + t * t * edge.p02)) < 1e-14);
        RC_ASSERT(norm(edge.derivative(t) - 2 * (s * (p11 - edge.p20) + t * (edge.p02 - p11))) < 1e-14);
        // Theory, section 3: the Lagrange form and its derivative.
        const Vec<D> l = s * (1 - 2 * t) * edge.p20 + 4 * t * s * edge.mid.point + t * (2 * t - 1) * edge.p02;
        const Vec<D> dl = (4 * t - 3) * edge.p20 + 4 * (1 - 2 * t) * edge.mid.point + (4 * t - 1) * edge.p02;
        RC_ASSERT(norm(edge.point(t) - l) < 1e-14);
        RC_ASSERT(norm(edge.derivative(t) - dl) < 2e-14);
        const double h = 1e-4;  // central differences are exact for parabolas
        RC_ASSERT(norm((edge.point(t + h) - edge.point(t - h)) / (2 * h) - edge.derivative(t)) < 1e-10);
    });
    property("an edge starts and ends at its vertices and passes through its node", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto edge = random_edge<D>(dice);
        RC_ASSERT(edge.point(0) == edge.p20);
        RC_ASSERT(edge.point(1) == edge.p02);
        RC_ASSERT(norm(edge.point(0.5) - edge.mid.point) < 1e-15);
        RC_ASSERT(edge.chord() == edge.p02 - edge.p20);
    });
    property("control point and Lagrange node are inverse to each other", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto edge = random_edge<D>(dice);
        const auto p11 = control_point(edge.p20, edge.mid, edge.p02);
        RC_ASSERT(norm(lagrange_node(edge.p20, p11, edge.p02).point - edge.mid.point) < 1e-15);
        const auto mid = lagrange_node(edge.p20, ControlPoint<D>{edge.mid.point}, edge.p02);
        RC_ASSERT(norm(control_point(edge.p20, mid, edge.p02).point - edge.mid.point) < 1e-15);
    });
    property("a straight edge has no offset, no curvature and a constant derivative", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto a = dice.vector<D>(-1e6, 1e6);
        const auto b = a + dice.vector<D>();
        const auto edge = QuadraticEdge<D>::straight(a, b);
        RC_ASSERT(edge.offset() == Vec<D>{});
        RC_ASSERT(curvature(edge) == 0);
        RC_ASSERT(edge.derivative(dice.uniform(0, 1)) == b - a);
        RC_ASSERT(control_point(a, edge.mid, b).point == edge.mid.point);
    });
}

template <int K, int D>
void check_simplex_maps() {
    property("F equals its Bernstein form, its derivatives the differences, its edges P2 edges",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 QuadraticSimplex<K, D> s;
                 for (auto& p : s.control) p = dice.vector<D>();
                 const auto xi = dice.barycentric<K>();
                 Vec<D> expected;
                 for (const auto& alpha : multi_indices<2, K>) {
                     int i = -1, j = -1;
                     for (int k = 0; k <= K; ++k)
                         for (int m = 0; m < alpha[k]; ++m) (i < 0 ? i : j) = k;
                     expected += bernstein<K>(alpha, xi) * s.at(i, j);
                     RC_ASSERT(s.at(i, j) == s.at(j, i));
                 }
                 RC_ASSERT(norm(s.point(xi) - expected) < 1e-14);
                 const auto columns = s.derivatives(xi);
                 for (int a = 0; a < K; ++a) {
                     const double h = 1e-4;
                     auto forward = xi, backward = xi;
                     forward[a + 1] += h;
                     forward[0] -= h;
                     backward[a + 1] -= h;
                     backward[0] += h;
                     RC_ASSERT(norm((s.point(forward) - s.point(backward)) / (2 * h) - columns[a]) < 1e-10);
                 }
                 // The edges are the P2 edges of the control points.
                 for (int e = 0; e < edges_per_simplex<K>; ++e) {
                     const auto [i, j] = local_edges<K>[e];
                     const auto mid = lagrange_node(s.control[i], ControlPoint<D>{s.control[K + 1 + e]}, s.control[j]);
                     const QuadraticEdge<D> edge{s.control[i], mid, s.control[j]};
                     Barycentric<K> at{};
                     const double t = dice.uniform(0, 1);
                     at[i] = 1 - t;
                     at[j] = t;
                     RC_ASSERT(norm(s.point(at) - edge.point(t)) < 1e-14);
                 }
             });
    property("a simplex with nodes at the edge midpoints maps linearly", [](std::uint64_t seed) {
        Dice dice(seed);
        QuadraticSimplex<K, D> s;
        for (int i = 0; i <= K; ++i) s.control[i] = dice.vector<D>();
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            s.control[K + 1 + e] = midpoint(s.control[i], s.control[j]);
        }
        const auto xi = dice.barycentric<K>();
        Vec<D> linear;
        for (int i = 0; i <= K; ++i) linear += xi[i] * s.control[i];
        RC_ASSERT(norm(s.point(xi) - linear) < 1e-14);
        const auto columns = s.derivatives(xi);
        for (int a = 0; a < K; ++a) RC_ASSERT(norm(columns[a] - (s.control[a + 1] - s.control[0])) < 1e-14);
    });
}

}  // namespace

TEST_CASE("P2 edges in the plane match their Bernstein and Lagrange forms") { check_edge_maps<2>(); }
TEST_CASE("P2 edges in space match their Bernstein and Lagrange forms") { check_edge_maps<3>(); }
TEST_CASE("P2 maps of edges match their Bernstein form and derivatives") { check_simplex_maps<1, 2>(); }
TEST_CASE("P2 maps of triangles in the plane match their Bernstein form and derivatives") {
    check_simplex_maps<2, 2>();
}
TEST_CASE("P2 maps of triangles in space match their Bernstein form and derivatives") { check_simplex_maps<2, 3>(); }
TEST_CASE("P2 maps of tetrahedra match their Bernstein form and derivatives") { check_simplex_maps<3, 3>(); }
