// Optimal nodes of a single edge on generated shells, compared with samples of node positions.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

template <int D>
Vec<D> vector(std::mt19937_64& random, double most) {
    Vec<D> v;
    for (int c = 0; c < D; ++c) v[c] = uniform(random, -most, most);
    return v;
}

/// An element with these vertices in a random even order and nodes node(i, j). The edge of the shell is 0–1.
template <int D, class Node>
ShellElement<D> shell_element(std::mt19937_64& random, const std::array<int, D + 1>& vertices, Node&& node) {
    std::array<int, D + 1> order{};
    for (int i = 0; i <= D; ++i) order[i] = i;
    for (int turn = 0; turn < 4; ++turn) {
        const int first = static_cast<int>(random() % (D + 1));
        const int second = (first + 1) % (D + 1);
        const int third = (first + 2) % (D + 1);
        const int saved = order[first];
        order[first] = order[second], order[second] = order[third], order[third] = saved;
    }
    ShellElement<D> s;
    for (int i = 0; i <= D; ++i) s.element.nodes[i] = node(vertices[order[i]], vertices[order[i]]);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const int a = vertices[order[local_edges<D>[e][0]]];
        const int b = vertices[order[local_edges<D>[e][1]]];
        s.element.nodes[D + 1 + e] = node(a, b);
        if (a + b == 1) s.edge = e;
    }
    return s;
}

/// The elements around an edge: a ring of 3 to 7 tetrahedra (sometimes open), or two triangles. Nodes are displaced
/// from the middles by up to `amplitude`, and all points are mapped by `map`.
template <int D, class Map>
EdgeShell<D> shell(std::mt19937_64& random, double amplitude, Map&& map) {
    const int ring = D == 2 ? 2 : 3 + static_cast<int>(random() % 5);
    const bool open = D == 3 && random() % 4 == 0;
    std::vector<Vec<D>> points{{}, {}};
    points[0][D - 1] = -0.6;
    points[1][D - 1] = 0.6;
    for (int i = 0; i < ring; ++i) {
        const double angle = 2 * std::numbers::pi * i / ring;
        Vec<D> p;
        p[0] = std::cos(angle);
        if constexpr (D == 3) p[1] = std::sin(angle);
        points.push_back(p);
    }
    for (auto& p : points) p += vector<D>(random, 0.15);
    std::vector<std::vector<Vec<D>>> nodes(points.size(), std::vector<Vec<D>>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j)
            nodes[i][j] = nodes[j][i] =
                map(i == j ? points[i] : midpoint(points[i], points[j]) + vector<D>(random, amplitude));
    const auto node = [&](int i, int j) { return nodes[i][j]; };
    EdgeShell<D> s{{nodes[0][1]}, {}};
    for (int i = 0; i < ring - (open ? 1 : 0); ++i) {
        if constexpr (D == 2)
            s.elements.push_back(shell_element<2>(random, i == 0 ? std::array{0, 2, 1} : std::array{1, 3, 0}, node));
        else
            s.elements.push_back(shell_element<3>(random, {0, 1, 2 + i, 2 + (i + 1) % ring}, node));
    }
    return s;
}

template <int D>
EdgeShell<D> plain_shell(std::mt19937_64& random, double amplitude) {
    return shell<D>(random, amplitude, [](const Vec<D>& p) { return p; });
}

/// Compresses by 1e-6 in an oblique direction.
template <int D>
Vec<D> squeezed(const Vec<D>& p) {
    Vec<D> normal;
    for (int c = 0; c < D; ++c) normal[c] = 1 + 0.3 * c;
    normal = normalised(normal);
    return p - (1 - 1e-6) * dot(p, normal) * normal;
}

/// The minimum scaled coefficient: an upper limit for tests by coefficients.
template <int D>
double smallest_coefficient(const EdgeShell<D>& s, const LagrangeNode<D>& node) {
    double low = 1e300;
    for (const auto& e : s.elements) {
        const auto j = bounded_jacobian(with_node(e, node));
        for (const double c : j.coefficients) low = std::min(low, c / std::abs(j.straight));
    }
    return low;
}

/// An upper bound of the minimum of det J / |det straight| over the shell.
template <int D>
double sampled_minimum(const EdgeShell<D>& s, const LagrangeNode<D>& node) {
    double low = 1e300;
    for (const auto& e : s.elements) low = std::min(low, check_element(with_node(e, node), 0).min_scaled_jacobian);
    return low + scaled_jacobian_tolerance * std::max(1.0, std::abs(low));
}

/// A random pattern search for the maximum of value(node).
template <int D, class Value>
std::pair<LagrangeNode<D>, double> searched(std::mt19937_64& random, LagrangeNode<D> start, double size, int tries,
                                            Value&& value) {
    double best = value(start);
    for (int i = 0; i < tries; ++i) {
        const LagrangeNode<D> other{start.point + vector<D>(random, size)};
        const double v = value(other);
        if (v > best)
            best = v, start = other, size *= 1.5;
        else
            size *= 0.97;
    }
    return {start, best};
}

template <int D>
QuadraticModel<D> model(std::mt19937_64& random, const Vec<D>& about, double distance) {
    QuadraticModel<D> q{about + vector<D>(random, distance), Sym<D>::identity(), 1};
    const Vec<D> v = vector<D>(random, 3);
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) q.hessian(i, j) += v[i] * v[j];
    return q;
}

template <int D>
std::vector<double> sorted(const std::array<double, jacobian_coefficients<D>>& c, double scale) {
    std::vector<double> s;
    s.reserve(c.size());
    for (const double x : c) s.push_back(x / scale);
    std::sort(s.begin(), s.end());
    return s;
}

template <int D>
void check_edge_programs() {
    property("affine_jacobian gives the coefficients for any position of the node",
             [] {
                 auto random = random_source();
                 const auto s = plain_shell<D>(random, 0.3);
                 const Vec<D> x = vector<D>(random, 2);
                 for (const auto& e : s.elements) {
                     const auto affine = affine_jacobian(e.element, e.edge);
                     const auto direct = bounded_jacobian(with_node(e, {s.node.point + x}));
                     std::array<double, jacobian_coefficients<D>> values{};
                     int without = 0;
                     for (std::size_t k = 0; k < values.size(); ++k) {
                         values[k] = affine.coefficients[k](x);
                         without += affine.coefficients[k].gradient == Vec<D>{};
                     }
                     RC_ASSERT(without == (D == 2 ? 1 : 4));
                     RC_ASSERT(std::abs(affine.scale - std::abs(direct.straight)) <= 1e-14);
                     const auto a = sorted<D>(values, 1);
                     const auto b = sorted<D>(direct.coefficients, affine.scale);
                     for (std::size_t k = 0; k < a.size(); ++k) RC_ASSERT(std::abs(a[k] - b[k]) <= 1e-11);
                 }
             },
             {100});
    property("highest_node: no other node has a higher minimum coefficient",
             [] {
                 auto random = random_source();
                 const auto s = plain_shell<D>(random, uniform(random, 0, 0.5));
                 const auto highest = max_min_node(s, {.max_cuts = 0});
                 RC_ASSERT(highest.has_value());
                 RC_ASSERT(highest->upper - highest->lower <= 1e-9 * (1 + std::abs(highest->upper)));
                 RC_ASSERT(std::abs(smallest_coefficient(s, highest->node) - highest->lower) <= 1e-10);
                 const auto value = [&](const LagrangeNode<D>& n) { return smallest_coefficient(s, n); };
                 for (const auto& start : {s.node, highest->node})
                     RC_ASSERT(searched<D>(random, start, 0.3, 300, value).second <= highest->lower + 1e-9);
             },
             {60});
    property("highest_node with a required minimum returns the same node or none",
             [] {
                 auto random = random_source();
                 const auto s = plain_shell<D>(random, uniform(random, 0, 0.5));
                 const auto highest = max_min_node(s, {.max_cuts = 0});
                 const double off = 1e-6 * (1 + std::abs(highest->upper));
                 const auto same = max_min_node(s, {.max_cuts = 0, .least = highest->lower - off});
                 RC_ASSERT(same.has_value());
                 RC_ASSERT(same->node == highest->node);
                 RC_ASSERT(!max_min_node(s, {.max_cuts = 0, .least = highest->upper + off}).has_value());
             },
             {60});
    property("highest_node: cuts bracket the attainable minimum and never lower it",
             [] {
                 auto random = random_source();
                 const auto s = plain_shell<D>(random, uniform(random, 0.1, 0.5));
                 const auto weak = max_min_node(s, {.max_cuts = 0});
                 const auto highest = max_min_node(s);
                 RC_ASSERT(highest.has_value());
                 RC_ASSERT(highest->lower >= weak->lower - 1e-9);
                 for (const auto& e : s.elements)
                     RC_ASSERT(check_element(with_node(e, highest->node), 0).min_scaled_jacobian >=
                               highest->lower - 2 * scaled_jacobian_tolerance * (1 + std::abs(highest->lower)));
                 const auto value = [&](const LagrangeNode<D>& n) { return sampled_minimum(s, n); };
                 const double slack = scaled_jacobian_tolerance * (1 + std::abs(highest->upper)) + 1e-9;
                 RC_ASSERT(searched<D>(random, highest->node, 0.3, 60, value).second <= highest->upper + slack);
             },
             {60});
    property("nearest_node is valid, and no sampled valid node is nearer",
             [] {
                 auto random = random_source();
                 const auto s = plain_shell<D>(random, uniform(random, 0, 0.35));
                 const auto q = model(random, s.node.point, 0.6);
                 const double bound = uniform(random, 0, 0.3);
                 const auto nearest = nearest_node(s, q, bound);
                 if (!nearest) {
                     const auto highest = max_min_node(s);
                     RC_ASSERT(highest->lower <= bound + 2e-2);
                     return;
                 }
                 RC_ASSERT(holds(s, nearest->node, bound));
                 RC_ASSERT(nearest->cost == q(nearest->node.point));
                 const auto value = [&](const LagrangeNode<D>& n) {
                     return smallest_coefficient(s, n) >= bound ? -q(n.point) : -1e300;
                 };
                 const double best = -searched<D>(random, nearest->node, 0.3, 200, value).second;
                 RC_ASSERT(best >= nearest->cost * (1 - 1e-9));
                 // Among all valid nodes it is nearest up to the tolerance of the cuts.
                 const auto valid = [&](const LagrangeNode<D>& n) { return holds(s, n, bound) ? -q(n.point) : -1e300; };
                 const double nearer = -searched<D>(random, nearest->node, 0.3, 60, valid).second;
                 RC_ASSERT(nearest->cuts >= 50 || nearest->cost - nearer <= 1.01e-3 * nearest->cost);
             },
             {60});
    property("the values do not change at an anisotropy of 1e6 or far from the origin",
             [] {
                 auto random = random_source();
                 auto again = random;
                 auto far = random;
                 const double amplitude = uniform(random, 0, 0.3);
                 (void)uniform(again, 0, 1), (void)uniform(far, 0, 1);
                 const auto s = plain_shell<D>(random, amplitude);
                 const auto thin = shell<D>(again, amplitude, squeezed<D>);
                 const auto remote = shell<D>(far, amplitude, [](Vec<D> p) {
                     for (int c = 0; c < D; ++c) p[c] += 1e6;
                     return p;
                 });
                 const auto a = max_min_node(s);
                 const auto b = max_min_node(thin);
                 const auto c = max_min_node(remote);
                 RC_ASSERT(a.has_value() && b.has_value() && c.has_value());
                 RC_ASSERT(b->lower <= a->upper + 1e-4 && a->lower <= b->upper + 1e-4);
                 RC_ASSERT(std::abs(a->lower - b->lower) <= 5e-3 * (1 + std::abs(a->lower)));
                 RC_ASSERT(std::abs(a->lower - c->lower) <= 5e-3 * (1 + std::abs(a->lower)));
                 if (a->lower < 0.05) return;
                 // The energy of the squeezed shell in the metric in which it is not thin.
                 QuadraticModel<D> q{thin.node.point, 1e-12 * Sym<D>::identity(), 1};
                 Vec<D> normal;
                 for (int i = 0; i < D; ++i) normal[i] = 1 + 0.3 * i;
                 normal = normalised(normal);
                 for (int i = 0; i < D; ++i)
                     for (int j = 0; j <= i; ++j) q.hessian(i, j) += normal[i] * normal[j];
                 q.hessian *= 1e12;
                 const double bound = 0.5 * a->lower;
                 const auto nearest = nearest_node(thin, q, bound);
                 RC_ASSERT(nearest.has_value() && holds(thin, nearest->node, bound));
                 QuadraticModel<D> p{remote.node.point, Sym<D>::identity(), 1};
                 const auto other = nearest_node(remote, p, bound);
                 RC_ASSERT(other.has_value() && holds(remote, other->node, bound));
             },
             {60});
    property(
        "elements with a required minimum keep it while the others are raised",
        [] {
            auto random = random_source();
            auto s = plain_shell<D>(random, 0.15);
            const double now = smallest_scaled_jacobian(s, s.node, 1e300);
            RC_PRE(now > 0.01);
            auto constrained = s;
            constrained.elements.front().required_jacobian = 0.9 * now;
            const auto all = max_min_node(s);
            const auto some = max_min_node(constrained);
            RC_ASSERT(some.has_value());
            RC_ASSERT(some->upper >= all->lower - 1e-9);
            RC_ASSERT(decide(with_node(constrained.elements.front(), some->node), 0.9 * now - 1e-6) == Verdict::valid);
            const auto nearest = nearest_node(constrained, QuadraticModel<D>{s.node.point}, now / 2);
            RC_ASSERT(nearest && holds(constrained, nearest->node, now / 2));
        },
        {60, 100, 30});
}

}  // namespace

TEST_CASE_TEMPLATE("optimal nodes of edge shells agree with samples", Dimension, std::integral_constant<int, 2>,
                   std::integral_constant<int, 3>) {
    check_edge_programs<Dimension::value>();
}

TEST_CASE("cuts reach bounds that coefficients alone do not") {
    std::mt19937_64 random(5);
    int more = 0;
    int reached = 0;
    for (int i = 0; i < 100; ++i) {
        const auto s = plain_shell<3>(random, 0.2);
        const auto weak = max_min_node(s, {.max_cuts = 0});
        const auto sharp = max_min_node(s);
        if (sharp->lower < weak->lower + 0.02) continue;
        ++more;
        CHECK(sharp->cuts > 0);
        const double bound = 0.5 * (sharp->lower + weak->lower);
        if (bound < 0) continue;
        ++reached;
        const QuadraticModel<3> q{s.node.point};
        CHECK_FALSE(nearest_node(s, q, bound, {.max_cuts = 0}).has_value());
        const auto by_cuts = nearest_node(s, q, bound);
        REQUIRE(by_cuts.has_value());
        CHECK(holds(s, by_cuts->node, bound));
    }
    INFO(more << " raised by cuts, " << reached << " valid by cuts alone");
    CHECK(more > 0);
    CHECK(reached > 0);
}
