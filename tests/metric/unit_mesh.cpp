// Lengths and qualities of straight edges and elements in a metric.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.soundness;

using namespace camber;
using namespace camber::testing;

namespace {

/// A metric of sizes between 10^-3 and 1 along random axes.
template <int D>
LogMetric<D> random_metric(Dice& dice) {
    Vec<D> sizes;
    for (double& h : sizes.c) h = std::pow(10.0, dice.uniform(-3, 0));
    return log_metric_of_sizes<D>(sizes, dice.rotation<D>());
}

template <int D>
void check_constant_metric(std::uint64_t seed) {
    Dice dice(seed);
    const LogMetric<D> log_metric = random_metric<D>(dice);
    const MeasuringMetric<D> metric(log_metric);
    std::array<Vec<D>, D + 1> corners;
    std::array<const MeasuringMetric<D>*, D + 1> metrics{};
    std::array<Vec<D>, D + 1> mapped;  // mapped so that the metric is the identity
    for (int i = 0; i <= D; ++i) {
        corners[i] = dice.vector<D>();
        metrics[i] = &metric;
        for (int k = 0; k < D; ++k) mapped[i][k] = dot(metric.rows[k], corners[i]);
    }
    const double quality = metric_quality<D>(corners, metrics);
    // The map may be a reflection, so absolute values are compared.
    RC_ASSERT(std::abs(std::abs(quality) - std::abs(mean_ratio<D>(mapped))) < 1e-9);
    RC_ASSERT((quality < 0) == (orientation(corners) < 0));
    const Vec<D> edge = corners[1] - corners[0];
    const double length = edge_length(metric, metric, edge);
    RC_ASSERT(std::abs(length / distance(mapped[0], mapped[1]) - 1) < 1e-12);
    RC_ASSERT(std::abs(metric.length_squared(edge) / SpectralMetric<D>(log_metric).length_squared(edge) - 1) < 1e-12);
}

}  // namespace

TEST_CASE("in a constant metric lengths and qualities equal those of the mapped simplex") {
    property("2D", [](std::uint64_t seed) { check_constant_metric<2>(seed); });
    property("3D", [](std::uint64_t seed) { check_constant_metric<3>(seed); });
}

TEST_CASE("the length between two sizes is the integral of their interpolation") {
    property("the logarithmic mean equals Simpson's rule", [](std::uint64_t seed) {
        Dice dice(seed);
        const double a = std::pow(10.0, dice.uniform(-3, 3));
        const double b = a * std::pow(10.0, dice.uniform(-1, 1) * (seed % 2 == 0 ? 1 : 1e-5));
        double sum = 0;
        constexpr int n = 200;
        for (int i = 0; i <= n; ++i) {
            const double weight = i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2;
            sum += weight * a * std::pow(b / a, static_cast<double>(i) / n);
        }
        RC_ASSERT(std::abs(logarithmic_mean(a, b) / (sum / (3.0 * n)) - 1) < 1e-8);
        RC_ASSERT(std::abs(logarithmic_mean(a, b) / logarithmic_mean(b, a) - 1) < 1e-14);
    });
    CHECK(logarithmic_mean(2, 2) == 2);
}
