// Distortion of curved elements and lengths of curved edges in a metric.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"
#include "random_metric.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// x ↦ M^{-1/2} x: the regular simplex becomes unit.
template <int D>
Mat<D> stretch_of(const LogMetric<D>& metric) {
    return {[&] {
        Mat<D> m;
        const Sym<D> root = camber::exp(LogMetric<D>{-0.5 * metric.l}).m;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < D; ++j) m(i, j) = root(i, j);
        return m;
    }()};
}

template <int D>
QuadraticNodes<D> mapped(const Mat<D>& f, QuadraticNodes<D> nodes) {
    for (Vec<D>& x : nodes) x = f * x;
    return nodes;
}

/// Returns the nodes of a straight simplex.
template <int D>
QuadraticNodes<D> straight(const std::array<Vec<D>, D + 1>& corners) {
    QuadraticNodes<D> nodes;
    for (int i = 0; i <= D; ++i) nodes[i] = corners[i];
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        nodes[D + 1 + e] = midpoint(corners[local_edges<D>[e][0]], corners[local_edges<D>[e][1]]);
    return nodes;
}

/// Near the regular simplex: vertices moved by up to `moved`, mid nodes by up to `bent`.
template <int D>
QuadraticNodes<D> random_element(Dice& dice, double moved, double bent) {
    const Mat<D> w = regular_simplex<D>();
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = (i > 0 ? w.column[i - 1] : Vec<D>{}) + dice.vector<D>(-moved, moved);
    QuadraticNodes<D> nodes = straight<D>(corners);
    for (int e = 0; e < edges_per_simplex<D>; ++e) nodes[D + 1 + e] += dice.vector<D>(-bent, bent);
    return nodes;
}

template <int D>
VertexLogMetrics<D> constant(const LogMetric<D>& metric) {
    VertexLogMetrics<D> all;
    all.fill(metric);
    return all;
}
/// Adds symmetric matrices with entries up to `change` to log M at each vertex.
template <int D>
VertexLogMetrics<D> varying(Dice& dice, const LogMetric<D>& metric, double change) {
    VertexLogMetrics<D> all = constant<D>(metric);
    for (LogMetric<D>& m : all) m.l += dice.symmetric<D>(change);
    return all;
}

/// Barycentric coordinates of a lattice.
template <int D>
std::vector<Barycentric<D>> lattice_of(int n) {
    std::vector<Barycentric<D>> points;
    const auto add = [&](auto&& self, Barycentric<D> xi, int at, int left) -> void {
        if (at == D) {
            xi[D] = static_cast<double>(left) / n;
            points.push_back(xi);
            return;
        }
        for (int k = 0; k <= left; ++k) {
            xi[at] = static_cast<double>(k) / n;
            self(self, xi, at + 1, left - k);
        }
    };
    add(add, {}, 0, n);
    return points;
}

template <int D>
void check_straight(std::uint64_t seed) {
    Dice dice(seed);
    const LogMetric<D> metric = random_metric<D>(dice, dice.uniform(0, 6));
    std::array<Vec<D>, D + 1> corners;
    const Mat<D> stretch = stretch_of(metric);
    for (int i = 0; i <= D; ++i) corners[i] = stretch * dice.vector<D>();
    const MeasuringMetric<D> measure(metric);
    std::array<const MeasuringMetric<D>*, D + 1> measures{};
    measures.fill(&measure);
    const double expected = metric_quality<D>(corners, measures);
    const double rounding = 1e-13 + 1e-13 * anisotropy(metric);  // log M is interpolated and decomposed
    const QuadraticNodes<D> nodes = straight<D>(corners);
    const auto metrics = constant<D>(metric);
    const CurvedQuality found = curved_quality<D>(nodes, element_metric<D>(metrics));
    RC_ASSERT(std::abs(found.mean - expected) < rounding);
    RC_ASSERT(std::abs(found.least - expected) < rounding);
    RC_ASSERT(std::abs(quality_at<D>(nodes, metrics, dice.barycentric<D>()) - expected) < rounding);
    const QualityBound least = bound_quality<D>(nodes, metrics, {.bisections = 0});
    RC_ASSERT(std::abs(least.bound - (expected > 0 ? expected : -1)) < 10 * rounding);
}

template <int D>
void check_invariance(std::uint64_t seed) {
    Dice dice(seed);
    const QuadraticNodes<D> nodes = random_element<D>(dice, 0.1, 0.1);
    const auto metrics = varying<D>(dice, random_metric<D>(dice, 1), 1);
    const CurvedQuality quality = curved_quality<D>(nodes, element_metric<D>(metrics));
    const auto same = [&](const CurvedQuality& other) {
        RC_ASSERT(std::abs(other.mean - quality.mean) < 1e-12);
        RC_ASSERT(std::abs(other.least - quality.least) < 1e-12);
    };
    // A scaled metric, and an element that is moved and scaled.
    auto scaled = metrics;
    for (LogMetric<D>& m : scaled) m.l += dice.uniform(-9, 9) * Sym<D>::identity();
    same(curved_quality<D>(nodes, element_metric<D>(scaled)));
    QuadraticNodes<D> elsewhere = nodes;
    const Vec<D> shift = dice.vector<D>();
    const double size = std::pow(10.0, dice.uniform(-3, 3));
    for (Vec<D>& x : elsewhere) x = size * (x + shift);
    same(curved_quality<D>(elsewhere, element_metric<D>(metrics)));
    // Element and metric rotated.
    const Mat<D> turn = dice.rotation<D>();
    auto turned = metrics;
    for (LogMetric<D>& m : turned) m.l = congruence(turn, m.l);
    same(curved_quality<D>(mapped<D>(turn, nodes), element_metric<D>(turned)));
    // An affine map and its constant metric: quality equals that of the unmapped element in the identity.
    const LogMetric<D> one = random_metric<D>(dice, 2);
    const auto identity = element_metric<D>(constant<D>({}));
    const CurvedQuality unmapped = curved_quality<D>(nodes, identity);
    const CurvedQuality mapped_too =
        curved_quality<D>(mapped<D>(stretch_of(one), nodes), element_metric<D>(constant<D>(one)));
    RC_ASSERT(std::abs(unmapped.mean - mapped_too.mean) < 1e-11);
    RC_ASSERT(std::abs(unmapped.least - mapped_too.least) < 1e-11);
}

template <int D>
void check_packs(std::uint64_t seed) {
    Dice dice(seed);
    const QuadraticNodes<D> nodes = random_element<D>(dice, 0.2, 0.1);
    const auto metrics = varying<D>(dice, random_metric<D>(dice, 2), 1);
    const auto metric = element_metric<D>(metrics);
    const CurvedQuality quality = curved_quality<D>(nodes, metric);
    // The points of the rule one by one.
    double distortion = 0, least = 1;
    bool positive = true;
    for (int q = 0; q < pack_size; ++q) {
        Barycentric<D> xi;
        for (int i = 0; i <= D; ++i) xi[i] = distortion_rule<D>.xi[i][q];
        const double at = quality_at<D>(nodes, metrics, xi);
        positive = positive && at > 0;
        least = std::min(least, at);
        distortion += distortion_rule<D>.weights[q] / at;
    }
    RC_ASSERT(std::abs(quality.mean - (positive ? 1 / distortion : 0)) < 1e-12);
    RC_ASSERT(std::abs(quality.least - least) < 1e-12);
    const auto gradient = curved_quality_gradient<D>(nodes, metric);
    RC_ASSERT(gradient.mean == quality.mean);
    for (const Instructions set : {Instructions::baseline, Instructions::avx2, Instructions::avx512}) {
        if (!has(set)) continue;
        const auto with = element_metric<D>(metrics, set);
        RC_ASSERT((curved_quality<D>(nodes, with, set) == quality));
        RC_ASSERT((curved_quality_gradient<D>(nodes, with, set).by_node == gradient.by_node));
    }
}

/// Compares with fourth-order differences, with steps of constant length in the metric.
template <int D>
void check_derivative(std::uint64_t seed, double decades) {
    Dice dice(seed);
    const LogMetric<D> metric = random_metric<D>(dice, decades);
    const Mat<D> stretch = stretch_of(metric);
    const QuadraticNodes<D> nodes = mapped<D>(stretch, random_element<D>(dice, 0.1, 0.05));
    // Log M varies along the axes of the metric only, so that its axes do not turn within the element.
    auto metrics = constant<D>(metric);
    for (LogMetric<D>& m : metrics) m.l *= 1 + dice.uniform(-0.05, 0.05);
    const auto sampled = element_metric<D>(metrics);
    const auto gradient = curved_quality_gradient<D>(nodes, sampled);
    RC_PRE(gradient.mean > 0.05);
    for (int n = 0; n < quadratic_nodes<D>; ++n) {
        const Vec<D> way = stretch * dice.direction<D>();
        const double step = 1e-4;
        const auto at = [&](double t) {
            QuadraticNodes<D> moved = nodes;
            moved[n] += t * step * way;
            return curved_quality<D>(moved, sampled).mean;
        };
        const double difference = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step);
        // Rounding of the quality grows with anisotropy, because coordinates are rounded.
        RC_ASSERT(std::abs(dot(gradient.by_node[n], way) - difference) < 1e-7 + 1e-10 * anisotropy(metric));
    }
}

template <int D>
void check_bound(std::uint64_t seed) {
    Dice dice(seed);
    const double decades = dice.uniform(0, 3);
    const LogMetric<D> metric = random_metric<D>(dice, decades);
    const QuadraticNodes<D> nodes = mapped<D>(stretch_of(metric), random_element<D>(dice, 0.15, 0.08));
    auto metrics = constant<D>(metric);
    for (LogMetric<D>& m : metrics) {
        m.l *= 1 + dice.uniform(-0.1, 0.1);
        m.l += dice.symmetric<D>(std::pow(10.0, -decades) * 0.5);
    }
    double attained = 1;
    for (const auto& xi : lattice_of<D>(8)) attained = std::min(attained, quality_at<D>(nodes, metrics, xi));
    const double rounding = 1e-12 * std::pow(10.0, decades);
    double before = -1;
    for (const int bisections : {0, 4, 16, 64, 128}) {
        const QualityBound least =
            bound_quality<D>(nodes, metrics, {.enough = 1, .share = 1, .bisections = bisections});
        RC_ASSERT(least.bound <= attained + rounding);
        RC_ASSERT(least.bound >= before - rounding);
        RC_ASSERT(least.attained >= least.bound);
        before = least.bound;
    }
    if (attained > 0.2) RC_ASSERT(before > 0);
}

}  // namespace

TEST_CASE("a straight element in a constant metric has the degree-1 quality everywhere") {
    property("2D", [](std::uint64_t seed) { check_straight<2>(seed); });
    property("3D", [](std::uint64_t seed) { check_straight<3>(seed); });
}

TEST_CASE("a straight element in a slowly varying metric has about the vertex quality") {
    property("3D", [](std::uint64_t seed) {
        Dice dice(seed);
        const QuadraticNodes<3> nodes = random_element<3>(dice, 0.1, 0);
        const double change = dice.uniform(0, 0.2);
        const auto metrics = varying<3>(dice, random_metric<3>(dice, 0.3), change);
        std::array<Vec<3>, 4> corners;
        std::array<MeasuringMetric<3>, 4> measures;
        std::array<const MeasuringMetric<3>*, 4> at{};
        for (int i = 0; i < 4; ++i) {
            corners[i] = nodes[i];
            measures[i] = MeasuringMetric<3>(metrics[i]);
            at[i] = &measures[i];
        }
        const double mean = curved_quality<3>(nodes, element_metric<3>(metrics)).mean;
        RC_ASSERT(std::abs(mean - metric_quality<3>(corners, at)) < 0.01 + change);
    });
}

TEST_CASE("quality is invariant under scaling, rotation and matching affine maps") {
    property("2D", [](std::uint64_t seed) { check_invariance<2>(seed); });
    property("3D", [](std::uint64_t seed) { check_invariance<3>(seed); });
}

TEST_CASE("quality in packs equals pointwise quality for any instruction set") {
    property("2D", [](std::uint64_t seed) { check_packs<2>(seed); });
    property("3D", [](std::uint64_t seed) { check_packs<3>(seed); });
}

TEST_CASE("the distortion rule is exact for polynomials of degree 3") {
    const auto moment = [](const auto& rule, const auto& powers) {
        double sum = 0;
        for (int q = 0; q < pack_size; ++q) {
            double term = rule.weights[q];
            for (std::size_t i = 0; i < powers.size(); ++i)
                for (int k = 0; k < powers[i]; ++k) term *= rule.xi[i][q];
            sum += term;
        }
        return sum;
    };
    // ∫ ξ^α / ∫ 1 = α! D! / (|α| + D)!.
    const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
    for (const auto& alpha : multi_indices<3, 2>) {
        double exact = 2 / factorial(5);
        for (const int a : alpha) exact *= factorial(a);
        CHECK(std::abs(moment(distortion_rule<2>, alpha) - exact) < 1e-15);
    }
    for (const auto& alpha : multi_indices<3, 3>) {
        double exact = 6 / factorial(6);
        for (const int a : alpha) exact *= factorial(a);
        CHECK(std::abs(moment(distortion_rule<3>, alpha) - exact) < 1e-15);
    }
}

TEST_CASE("quality derivatives match finite differences up to anisotropy 10^6") {
    property("2D", [](std::uint64_t seed) { check_derivative<2>(seed, static_cast<double>(seed % 7)); });
    property("3D", [](std::uint64_t seed) { check_derivative<3>(seed, static_cast<double>(seed % 7)); });
}

TEST_CASE("bisection improves the lower bound of the minimum quality") {
    property("2D", [](std::uint64_t seed) { check_bound<2>(seed); });
    property("3D", [](std::uint64_t seed) { check_bound<3>(seed); });
}

TEST_CASE("inverted and degenerate elements have finite qualities") {
    const auto check = []<int D>(Dice& dice) {
        const auto metrics = varying<D>(dice, random_metric<D>(dice, 3), 1);
        const auto metric = element_metric<D>(metrics);
        const QuadraticNodes<D> nodes = random_element<D>(dice, 0.05, 0.02);
        // A mirrored element has the opposite sign.
        Mat<D> mirror = Mat<D>::identity();
        mirror(0, 0) = -1;
        const auto identity = element_metric<D>(constant<D>({}));
        const double good = curved_quality<D>(nodes, identity).mean;
        RC_ASSERT(std::abs(curved_quality<D>(mapped<D>(mirror, nodes), identity).mean + good) < 1e-13);
        RC_ASSERT(bound_quality<D>(mapped<D>(mirror, nodes), constant<D>({})).bound == -1);
        // A node beyond the opposite vertex gives det J of both signs.
        QuadraticNodes<D> folded = nodes;
        folded[D + 1] = nodes[D + 1] + 4.0 * (nodes[2] - nodes[D + 1]);
        const CurvedQuality at = curved_quality<D>(folded, metric);
        RC_ASSERT(at.mean == 0);
        RC_ASSERT(at.least < 0);
        RC_ASSERT(bound_quality<D>(folded, metrics).bound == -1);
        // Flat, collapsed to a point, and not finite.
        std::vector<QuadraticNodes<D>> bad(4, nodes);
        for (Vec<D>& x : bad[0]) x[D - 1] = 0;
        bad[1].fill(nodes[0]);
        bad[2][0][0] = std::nan("");
        bad[3][1][0] = HUGE_VAL;
        for (const auto& b : bad) {
            const auto quality = curved_quality_gradient<D>(b, metric);
            RC_ASSERT(std::abs(quality.mean) < 1e-7);
            for (const Vec<D>& g : quality.by_node) RC_ASSERT(is_finite(g));
            RC_ASSERT(std::abs(curved_quality<D>(b, metric).least) <= 1);
            const QualityBound least = bound_quality<D>(b, metrics);
            RC_ASSERT(least.bound < 1e-7);
            RC_ASSERT(least.attained < 1e-7);
        }
    };
    property("2D", [&](std::uint64_t seed) {
        Dice dice(seed);
        check.operator()<2>(dice);
    });
    property("3D", [&](std::uint64_t seed) {
        Dice dice(seed);
        check.operator()<3>(dice);
    });
}
