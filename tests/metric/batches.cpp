// Batched metric functions equal the scalar ones, with the same bytes for any instruction set and batch.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
#include <rapidcheck.h>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr std::array every_set{Instructions::baseline, Instructions::avx2, Instructions::avx512};

template <int D>
LogMetric<D> random_log(Dice& dice, double range) {
    Vec<D> values = dice.vector<D>(-range, range);
    if (dice.below(4) == 0) values[1] = values[0];
    return {congruence(dice.rotation<D>(), Sym<D>::diagonal(values))};
}

/// Checks that `batch(first, count, set)` returns the same for all items at once and one by one.
template <class Out>
void check_same_in_batches(std::size_t n, const auto& batch) {
    std::vector<Out> single;
    single.reserve(n);
    for (std::size_t i = 0; i < n; ++i) single.push_back(batch(i, std::size_t{1}, Instructions::baseline)[0]);
    for (const Instructions set : every_set)
        if (has(set)) RC_ASSERT(batch(0, n, set) == single);
}

template <int D>
void check_batches() {
    property("batched norms equal those of the decomposed metric", [](std::uint64_t seed) {
        Dice dice(seed);
        const std::size_t n = 1 + dice.below(20);
        std::vector<LogMetric<D>> metrics;
        std::vector<Vec<D>> vectors;
        for (std::size_t i = 0; i < n; ++i) {
            metrics.push_back(random_log<D>(dice, 28));
            vectors.push_back(dice.vector<D>(-1, 1));
        }
        const auto norms = [&](std::size_t first, std::size_t count, Instructions set) {
            std::vector<double> out(count);
            metric_norms<D>(std::span(metrics).subspan(first, count), std::span(vectors).subspan(first, count), out,
                            set);
            return out;
        };
        check_same_in_batches<double>(n, norms);
        const auto all = norms(0, n, Instructions::baseline);
        for (std::size_t i = 0; i < n; ++i) {
            const double expected = std::sqrt(SpectralMetric<D>(metrics[i]).length_squared(vectors[i]));
            RC_ASSERT(std::abs(all[i] - expected) <= 1e-11 * expected);
        }
    });
    property("batched natural metrics equal those of single simplices, also of thin ones", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<std::array<Vec<D>, D + 1>> simplices(1 + dice.below(20));
        for (auto& p : simplices) {
            const Mat<D> turn = dice.rotation<D>();
            for (Vec<D>& corner : p) {
                corner = dice.vector<D>(-1, 1);
                corner[0] *= 1e-6;
                corner = turn * corner;
            }
        }
        const auto naturals = [&](std::size_t first, std::size_t count, Instructions set) {
            std::vector<LogMetric<D>> out(count);
            natural_log_metrics<D>(std::span(simplices).subspan(first, count), out, set);
            return out;
        };
        check_same_in_batches<LogMetric<D>>(simplices.size(), naturals);
        const auto all = naturals(0, simplices.size(), Instructions::baseline);
        for (std::size_t i = 0; i < simplices.size(); ++i) {
            const LogMetric<D> expected = natural_log_metric<D>(simplices[i]);
            const auto logs = eigen_system(expected.l).values.c;
            const double condition = std::exp((*std::ranges::max_element(logs) - *std::ranges::min_element(logs)) / 2);
            // |δ log M| ≤ 2 |δB| / σ_min for B of `natural_log_metric`, and rounding makes |δB| ≈ 8 ε σ_max.
            const double bound = 16 * std::numeric_limits<double>::epsilon() * condition;
            RC_ASSERT(norm(all[i].l - expected.l) <= bound + 1e-14 * norm(expected.l));
        }
    });
    property("M̂ measures v as M measures F v, and O maps one root to the other", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<LogMetric<D>> metrics(1 + dice.below(20));
        std::vector<Mat<D>> jacobians(metrics.size());
        for (std::size_t i = 0; i < metrics.size(); ++i) {
            metrics[i] = random_log<D>(dice, 14);
            jacobians[i] = Mat<D>::identity();
            for (Vec<D>& column : jacobians[i].column) column += dice.vector<D>(-0.3, 0.3);
        }
        const auto mapped = [&](std::size_t first, std::size_t count, Instructions set) {
            std::vector<PulledBackMetric<D>> out(count);
            pull_back_metrics<D>(std::span(metrics).subspan(first, count), std::span(jacobians).subspan(first, count),
                                 out, set);
            return out;
        };
        check_same_in_batches<PulledBackMetric<D>>(metrics.size(), mapped);
        const auto all = mapped(0, metrics.size(), Instructions::baseline);
        const Vec<D> v = dice.vector<D>(-1, 1);
        for (std::size_t i = 0; i < metrics.size(); ++i) {
            const SpectralMetric<D> metric(metrics[i]), through(all[i].log_metric);
            const double expected = metric.length_squared(jacobians[i] * v);
            RC_ASSERT(std::abs(through.length_squared(v) - expected) <= 1e-6 * expected);
            const Mat<D> turned = all[i].axes * transposed(all[i].axes);
            for (int a = 0; a < D; ++a)
                for (int b = 0; b < D; ++b) RC_ASSERT(std::abs(turned(a, b) - (a == b)) <= 1e-12);
        }
    });
    property("a metric mapped by a singular matrix is unchanged", [](std::uint64_t seed) {
        Dice dice(seed);
        const LogMetric<D> metric = random_log<D>(dice, 10);
        const Mat<D> flat{};
        PulledBackMetric<D> mapped;
        pull_back_metrics<D>({&metric, 1}, {&flat, 1}, {&mapped, 1});
        RC_ASSERT(mapped == (PulledBackMetric<D>{metric}));
    });
}

}  // namespace

TEST_CASE("batched metric functions equal the scalar ones in 2D") { check_batches<2>(); }
TEST_CASE("batched metric functions equal the scalar ones in 3D") { check_batches<3>(); }
