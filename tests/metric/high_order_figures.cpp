// Differences between the paper's three forms of high-order interpolation, on curved elements in a curved metric. To
// print the figures:
//     CAMBER_FIGURES=1 build/bin/test_metric -tc="the three forms*"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include <doctest/doctest.h>

#include "back.hpp"
#include "dice.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

struct Distances {
    double pure_bezier_mean = 0, pure_bezier_largest = 0;  ///< |log M (2) − log M (4)|
    double lagrange_largest = 0;                           ///< |log M (3) − log M (4)|
    double error_bezier = 0, error_refactored = 0;         ///< mean distance to the true field of (2) and of (4)
};

/// Curved P2 simplices of size h near the unit circle or sphere, with mid nodes on concentric circles or spheres. The
/// polar metric has size `thin` along the radius and ten times that across it.
template <int D>
Distances measured(double h, double thin) {
    constexpr int K = D;
    Dice dice(5);
    Distances out;
    const auto field = [&](const Vec<D>& x) { return polar<D>(x, thin * norm(x), 10 * thin); };
    constexpr int elements = 200;
    constexpr int samples = 20;
    for (int e = 0; e < elements; ++e) {
        const Vec<D> centre = dice.uniform(1, 1.5) * dice.direction<D>();
        std::array<Vec<D>, K + 1> corner;
        do
            for (auto& p : corner) p = centre + h * dice.vector<D>();
        while (std::abs(orientation(corner)) < 0.2 * std::pow(h, D));
        constexpr int n = node_count<2, K>;
        std::array<Vec<D>, n> nodes;
        for (std::size_t a = 0; a < n; ++a) {
            Vec<D> chord;
            double radius = 0;
            for (std::size_t i = 0; i <= K; ++i) {
                chord += 0.5 * multi_indices<2, K>[a][i] * corner[i];
                radius += 0.5 * multi_indices<2, K>[a][i] * norm(corner[i]);
            }
            nodes[a] = radius * normalised(chord);
        }
        const auto control = transformed(lagrange_to_bezier<2, K>, nodes);
        LagrangeLogs<2, K, D> lagrange;
        BezierLogs<2, K, D> bezier;
        for (std::size_t a = 0; a < n; ++a) {
            lagrange.logs[a] = field(nodes[a]);
            bezier.logs[a] = field(control[a]);
        }
        const auto refactored = virtual_logs(lagrange);
        for (int s = 0; s < samples; ++s) {
            const auto xi = dice.barycentric<K>();
            Vec<D> x;
            for (std::size_t a = 0; a < n; ++a) x += bernstein<K>(multi_indices<2, K>[a], xi) * control[a];
            const Sym<D> l2 = interpolated(bezier, xi).l;
            const Sym<D> l3 = interpolated(lagrange, xi).l;
            const Sym<D> l4 = interpolated(refactored, xi).l;
            const double apart = norm(l2 - l4);
            out.pure_bezier_mean += apart / (elements * samples);
            out.pure_bezier_largest = std::max(out.pure_bezier_largest, apart);
            out.lagrange_largest = std::max(out.lagrange_largest, norm(l3 - l4));
            out.error_bezier += norm(l2 - field(x).l) / (elements * samples);
            out.error_refactored += norm(l4 - field(x).l) / (elements * samples);
        }
    }
    return out;
}

template <int D>
void print(double h, const Distances& d) {
    if (std::getenv("CAMBER_FIGURES") == nullptr) return;
    std::printf(
        "  %dD  h %-6g  |(2)-(4)| mean %.3e largest %.3e  |(3)-(4)| largest %.1e  error of (2) %.3e of (4) %.3e\n", D,
        h, d.pure_bezier_mean, d.pure_bezier_largest, d.lagrange_largest, d.error_bezier, d.error_refactored);
}

template <int D>
void figures() {
    Distances last;
    for (const double h : {0.4, 0.2, 0.1}) {
        const Distances d = measured<D>(h, 0.01);
        print<D>(h, d);
        CHECK(d.lagrange_largest < 1e-13);
        CHECK(d.pure_bezier_mean > 1e-5);
        CHECK(d.error_refactored < d.error_bezier);
        if (last.error_bezier > 0) {
            CHECK(last.error_refactored / d.error_refactored > 6);  // third order
            CHECK(last.error_bezier / d.error_bezier < 6);          // second order
        }
        last = d;
    }
}

}  // namespace

TEST_CASE("the three forms of high-order interpolation converge with their orders in 2D") { figures<2>(); }
TEST_CASE("the three forms of high-order interpolation converge with their orders in 3D") { figures<3>(); }
