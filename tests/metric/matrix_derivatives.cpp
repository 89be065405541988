// D exp and D log of symmetric matrices: inverse to each other, equal to differences, also at equal eigenvalues and at
// high anisotropy.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// Log-eigenvalues within ± range, some of them equal or nearly equal.
template <int D>
SpectralMetric<D> random_metric(Dice& dice, double range) {
    constexpr std::array gaps{0.0, 1e-15, 1e-9, 1e-4};
    Vec<D> values = dice.vector<D>(-range, range);
    if (dice.below(2) == 0) values[1] = values[0] + gaps[dice.below(gaps.size())];
    return SpectralMetric<D>(EigenSystem<D>{values, dice.rotation<D>()});
}

template <int D>
void check_derivatives() {
    property("D log is the inverse of D exp", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto s = random_metric<D>(dice, dice.uniform(0, 3));
        const auto e = dice.symmetric<D>();
        RC_ASSERT(norm(log_derivative(s, exp_derivative(s, e)) - e) <= 1e-15 * 50 * std::exp(2 * 3.0));
        RC_ASSERT(norm(exp_derivative(s, log_derivative(s, e)) - e) <= 1e-15 * 50 * std::exp(2 * 3.0));
    });
    property("D log is exact to rounding in the eigenvector frame at log-eigenvalues of ±30", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto s = random_metric<D>(dice, 30);
        const auto e = dice.symmetric<D>();
        const auto there = exp_derivative_in_frame(s, e);
        const auto back = log_derivative_in_frame(s, there);
        for (std::size_t k = 0; k < e.c.size(); ++k)
            RC_ASSERT(std::abs(back.c[k] - e.c[k]) <= 1e-15 * std::abs(e.c[k]));
        // For M^{1/2} F M^{1/2}, D log has the size of F; compared in long double.
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) {
                Sym<D> unit;
                unit(i, j) = std::exp((s.log_values[i] + s.log_values[j]) / 2);
                const long double half = (static_cast<long double>(s.log_values[i]) - s.log_values[j]) / 2;
                const long double expected = half == 0 ? 1 : half / std::sinh(half);
                RC_ASSERT(std::abs(log_derivative_in_frame(s, unit)(i, j) - static_cast<double>(expected)) <=
                          1e-13 * static_cast<double>(expected));
            }
    });
    property("D log equals central differences", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto s = random_metric<D>(dice, dice.uniform(0, 1.5));
        const Metric<D> m{composed(EigenSystem<D>{s.values, s.vectors})};
        const auto e = dice.symmetric<D>();
        const double h = 1e-5 * *std::min_element(s.values.c.begin(), s.values.c.end());
        const Sym<D> differences = (log(Metric<D>{m.m + h * e}).l - log(Metric<D>{m.m - h * e}).l) * (1 / (2 * h));
        const Sym<D> derivative = log_derivative(m, e);
        RC_ASSERT(norm(derivative - differences) <= 1e-8 * (1 + norm(derivative)) * std::exp(1.5));
        RC_ASSERT(norm(derivative - log_derivative(s, e)) <= 1e-12 * (1 + norm(derivative)));
    });
    property("the error of D log at anisotropy 1e6 is the rounding of the entries", [](std::uint64_t seed) {
        Dice dice(seed);
        Vec<D> sizes;
        for (double& h : sizes.c) h = 1e-6;
        sizes[0] = dice.uniform(0.5, 2);
        const SpectralMetric<D> s(log_metric_of_sizes(sizes, dice.rotation<D>()));
        // A relative change of M by 1 along each axis changes log M by 1.
        const Sym<D> whole = composed(EigenSystem<D>{s.values, s.vectors});
        RC_ASSERT(norm(log_derivative(s, whole) - Sym<D>::identity()) <= 1e-15 * 1e12 * 20);
        const double lowest = *std::min_element(s.values.c.begin(), s.values.c.end());
        const auto e = dice.symmetric<D>();
        const Sym<D> in_frame = congruence(transposed(s.vectors), e);
        const Sym<D> derivative = congruence(transposed(s.vectors), log_derivative(s, e));
        for (int i = 0; i < D; ++i) {
            const double expected = in_frame(i, i) / s.values[i];
            RC_ASSERT(std::abs(derivative(i, i) - expected) <= 1e-14 * norm(e) / lowest);
        }
    });
}

}  // namespace

TEST_CASE("derivatives of exp and log are inverse and match differences in 2D") { check_derivatives<2>(); }
TEST_CASE("derivatives of exp and log are inverse and match differences in 3D") { check_derivatives<3>(); }
