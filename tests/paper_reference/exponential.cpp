// The exponential by scaling and squaring against the spectral formula, and its derivative against differences.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "dice.hpp"
#include "exponential.hpp"
#include "matrix.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

double distance(const paper::Symmetric& a, const Sym<3>& b) {
    paper::Symmetric difference{b.c};
    paper::add(difference, -1, a);
    return paper::norm(difference);
}

/// Log-metric with a magnitude up to that of anisotropy 10^6, in some cases close to a multiple of the identity.
Sym<3> log_metric(Dice& dice) {
    const Sym<3> s = dice.symmetric<3>(std::pow(10, dice.uniform(-4, 1.2)));
    return s + dice.uniform(-5, 5) * Sym<3>::identity();
}

}  // namespace

TEST_CASE("paper_reference: the exponential and its derivatives match independent formulas") {
    property("the exponential equals that by eigenvectors", [](std::uint64_t seed) {
        Dice dice(seed);
        const Sym<3> log = log_metric(dice);
        const Sym<3> expected = camber::exp(LogMetric<3>{log}).m;
        const paper::Jet<0> found = paper::exponential(paper::Jet<0>{{log.c}});
        RC_ASSERT(distance(found.value, expected) <= 1e-11 * paper::norm({expected.c}));
    });
    property("the derivatives equal those of Daletskii and Krein", [](std::uint64_t seed) {
        Dice dice(seed);
        const Sym<3> log = log_metric(dice);
        std::array<Sym<3>, 3> slopes;
        paper::Jet<3> jet{{log.c}};
        for (std::size_t n = 0; n < 3; ++n) {
            slopes[n] = dice.symmetric<3>();
            jet.slope[n] = {slopes[n].c};
        }
        const paper::Jet<3> found = paper::exponential(jet);
        const SpectralMetric<3> metric(LogMetric<3>{log});
        const double size = paper::norm(found.value);
        for (std::size_t n = 0; n < 3; ++n)
            RC_ASSERT(distance(found.slope[n], exp_derivative(metric, slopes[n])) <= 1e-10 * size);
    });
    property("the derivatives equal central differences", [](std::uint64_t seed) {
        Dice dice(seed);
        const Sym<3> log = dice.symmetric<3>(4);
        const Sym<3> slope = dice.symmetric<3>();
        const double step = 1e-5;
        paper::Jet<3> jet{{log.c}};
        jet.slope[1] = {slope.c};
        paper::Symmetric difference = paper::exponential(paper::Jet<0>{{(log + step * slope).c}}).value;
        paper::add(difference, -1, paper::exponential(paper::Jet<0>{{(log - step * slope).c}}).value);
        const paper::Jet<3> found = paper::exponential(jet);
        const double size = paper::norm(found.value);
        paper::add(difference, -2 * step, found.slope[1]);
        RC_ASSERT(paper::norm(difference) <= 2 * step * 1e-7 * size);
        RC_ASSERT(paper::norm(found.slope[0]) == 0);
    });
}
