// High-order log-Euclidean interpolation (paper §2.1) at several degrees and dimensions.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "back.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

template <int N, int K, int D>
LagrangeLogs<N, K, D> random_nodes(Dice& dice, double size = 2) {
    LagrangeLogs<N, K, D> nodes;
    for (auto& m : nodes.logs) m.l = dice.symmetric<D>(size);
    return nodes;
}

template <int N, int K>
Barycentric<K> node_place(std::size_t a) {
    Barycentric<K> xi{};
    for (std::size_t i = 0; i <= K; ++i) xi[i] = static_cast<double>(multi_indices<N, K>[a][i]) / N;
    return xi;
}

/// Nodes whose log-metrics interpolate those of the vertices linearly.
template <int N, int K, int D>
LagrangeLogs<N, K, D> linear_nodes(const std::array<LogMetric<D>, K + 1>& vertices) {
    LagrangeLogs<N, K, D> nodes;
    for (std::size_t a = 0; a < nodes.logs.size(); ++a)
        for (std::size_t i = 0; i <= K; ++i) nodes.logs[a].l += node_place<N, K>(a)[i] * vertices[i].l;
    return nodes;
}

template <int N, int K, int D>
void check_identities() {
    property("(3) equals (4) and interpolates the nodes; (2) of the same numbers differs", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto nodes = random_nodes<N, K, D>(dice);
        const auto field = virtual_logs(nodes);
        const auto xi = dice.barycentric<K>();
        RC_ASSERT(norm(interpolated(nodes, xi).l - interpolated(field, xi).l) <= 1e-13);
        for (std::size_t a = 0; a < nodes.logs.size(); ++a)
            RC_ASSERT(norm(interpolated(field, node_place<N, K>(a)).l - nodes.logs[a].l) <= 1e-13);
        Barycentric<K> middle{};
        middle.fill(1.0 / (K + 1));
        if (N > 1)
            RC_ASSERT(norm(interpolated(BezierLogs<N, K, D>{nodes.logs}, middle).l - interpolated(field, middle).l) >
                      1e-6);
    });
    property("the metric is positive and det M(ξ) = ∏ det(M_α)^{B_α(ξ)} (5)", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto field = virtual_logs(random_nodes<N, K, D>(dice));
        const auto xi = dice.barycentric<K>();
        const SpectralMetric<D> m(interpolated(field, xi));
        double log_det = 0;
        double expected = 0;
        for (int i = 0; i < D; ++i) {
            RC_ASSERT(m.values[i] > 0);
            log_det += std::log(m.values[i]);
        }
        for (std::size_t a = 0; a < field.logs.size(); ++a)
            expected += bernstein<K>(multi_indices<N, K>[a], xi) * trace(field.logs[a].l);
        RC_ASSERT(std::abs(log_det - expected) <= 1e-13 * (1 + std::abs(expected)) * 10);
    });
    property("linear log-metrics at regular nodes give the linear scheme in all three forms", [](std::uint64_t seed) {
        Dice dice(seed);
        std::array<LogMetric<D>, K + 1> vertices;
        for (auto& m : vertices) m.l = dice.symmetric<D>(3);
        const auto nodes = linear_nodes<N, K, D>(vertices);
        const auto xi = dice.barycentric<K>();
        Sym<D> linear;
        for (std::size_t i = 0; i <= K; ++i) linear += xi[i] * vertices[i].l;
        RC_ASSERT(norm(interpolated(nodes, xi).l - linear) <= 1e-13);
        RC_ASSERT(norm(interpolated(virtual_logs(nodes), xi).l - linear) <= 1e-13);
        // On a straight regular element control points and nodes coincide, so (2) has the same metrics.
        RC_ASSERT(norm(interpolated(BezierLogs<N, K, D>{nodes.logs}, xi).l - linear) <= 1e-13);
    });
    property("rotation M → RᵀMR and scaling M → cM commute with interpolation", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto nodes = random_nodes<N, K, D>(dice);
        const auto rotation = dice.rotation<D>();
        const double shift = dice.uniform(-5, 5);  // log c
        const auto xi = dice.barycentric<K>();
        auto moved = nodes;
        for (auto& m : moved.logs) m.l = congruence(rotation, m.l) + shift * Sym<D>::identity();
        const Sym<D> expected =
            congruence(rotation, interpolated(virtual_logs(nodes), xi).l) + shift * Sym<D>::identity();
        RC_ASSERT(norm(interpolated(virtual_logs(moved), xi).l - expected) <= 1e-12);
    });
    property("derivatives of log M and of M equal central differences", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto field = virtual_logs(random_nodes<N, K, D>(dice, 1));
        const auto xi = dice.barycentric<K>();
        const double h = 1e-5;
        const auto log_slopes = log_gradient(field, xi);
        const auto slopes = metric_gradient(field, xi);
        for (std::size_t i = 1; i <= K; ++i) {
            auto forth = xi;
            auto back = xi;
            forth[i] += h;
            forth[0] -= h;
            back[i] -= h;
            back[0] += h;
            const Sym<D> log_difference = (interpolated(field, forth).l - interpolated(field, back).l) * (1 / (2 * h));
            const Sym<D> difference =
                (exp(interpolated(field, forth)).m - exp(interpolated(field, back)).m) * (1 / (2 * h));
            RC_ASSERT(norm(log_slopes[i - 1] - log_difference) <= 1e-7 * (1 + norm(log_difference)));
            RC_ASSERT(norm(slopes[i - 1] - difference) <= 1e-5 * (1 + norm(difference)));
        }
    });
}

/// Two K-simplices that share a face. The second has the vertices of the first in random order and new metrics at nodes
/// off the shared face.
template <int N, int K, int D>
void check_continuity() {
    property("interpolation is continuous across shared faces, edges and vertices", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto first = random_nodes<N, K, D>(dice);
        std::array<std::size_t, K + 1> order{};
        for (std::size_t i = 0; i <= K; ++i) order[i] = i;
        std::shuffle(order.begin(), order.end(), dice.engine());
        const std::size_t shared = 1 + dice.below(K);  // vertices 0 … shared − 1 are common: vertex, edge, face
        LagrangeLogs<N, K, D> second = random_nodes<N, K, D>(dice);
        for (std::size_t a = 0; a < first.logs.size(); ++a) {
            const auto& alpha = multi_indices<N, K>[a];
            MultiIndex<K> there{};
            bool common = true;
            for (std::size_t i = 0; i <= K; ++i) {
                there[order[i]] = alpha[i];
                common = common && (i < shared || alpha[i] == 0);
            }
            if (common) second.logs[static_cast<std::size_t>(position<N, K>(there))] = first.logs[a];
        }
        Barycentric<K> here{};
        double sum = 0;
        for (std::size_t i = 0; i < shared; ++i) sum += here[i] = dice.uniform(0.01, 1);
        for (double& x : here) x /= sum;
        Barycentric<K> there{};
        for (std::size_t i = 0; i <= K; ++i) there[order[i]] = here[i];
        RC_ASSERT(norm(interpolated(virtual_logs(first), here).l - interpolated(virtual_logs(second), there).l) <=
                  1e-13);
    });
}

}  // namespace

TEST_CASE("high-order interpolation satisfies the identities of the paper on edges") {
    check_identities<2, 1, 2>();
    check_identities<3, 1, 3>();
    check_identities<4, 1, 2>();
}
TEST_CASE("high-order interpolation satisfies the identities of the paper on triangles") {
    check_identities<2, 2, 2>();
    check_identities<3, 2, 3>();
}
TEST_CASE("high-order interpolation satisfies the identities of the paper on tetrahedra") {
    check_identities<1, 3, 3>();
    check_identities<2, 3, 3>();
    check_identities<3, 3, 3>();
}
TEST_CASE("high-order interpolation is continuous across shared faces") {
    check_continuity<2, 1, 2>();
    check_continuity<2, 2, 2>();
    check_continuity<3, 2, 2>();
    check_continuity<2, 3, 3>();
    check_continuity<3, 3, 3>();
}

TEST_CASE("log-determinants 0, 1, 1 along a P2 edge overshoot to 1.125 at t = 3/4") {
    LagrangeLogs<2, 1, 2> nodes;  // in the order 20, 11, 02
    nodes.logs[1].l = nodes.logs[2].l = 0.5 * Sym<2>::identity();
    double most = 0;
    for (int i = 0; i <= 1000; ++i) {
        const double t = i / 1000.0;
        most = std::max(most, trace(interpolated(nodes, {1 - t, t}).l));
    }
    CHECK(most == doctest::Approx(1.125).epsilon(1e-14));
    CHECK(trace(interpolated(nodes, {0.25, 0.75}).l) == doctest::Approx(1.125).epsilon(1e-14));
    // The bound is the virtual metric: log-det of the middle one is (4·1 − 0 − 1)/2.
    CHECK(trace(virtual_logs(nodes).logs[1].l) == doctest::Approx(1.5).epsilon(1e-14));
}

TEST_CASE("EdgeField equals high-order interpolation along a P2 edge") {
    Dice dice(11);
    const auto nodes = random_nodes<2, 1, 3>(dice);
    const EdgeField<3> edge{nodes.logs[0], nodes.logs[1], nodes.logs[2]};
    for (const double t : {0.0, 0.13, 0.5, 0.77, 1.0})
        CHECK(norm(interpolated(virtual_logs(nodes), {1 - t, t}).l - edge.at(t).l) < 1e-14);
    CHECK(norm(virtual_logs(nodes).logs[1].l - edge.virtual_mid().l) < 1e-14);
}
