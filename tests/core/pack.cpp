// Functions of packs: accuracy, and the same bytes with every instruction set.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>
#include <rapidcheck.h>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr std::array every_set{Instructions::baseline, Instructions::avx2, Instructions::avx512};
constexpr double ulp = std::numeric_limits<double>::epsilon();

/// Applies f to each lane.
template <class F>
std::vector<double> mapped(const std::vector<double>& in, Instructions set, const F& f) {
    std::vector<double> out(in.size());
    with_instructions(set, [&]() __attribute__((always_inline)) {
        for (std::size_t i = 0; i < in.size(); i += pack_size) {
            Pack x;
            for (std::size_t lane = 0; lane < pack_size; ++lane) x[lane] = in[i + lane];
            const Pack y = f(x);
            for (std::size_t lane = 0; lane < pack_size; ++lane) out[i + lane] = y[lane];
        }
    });
    return out;
}

const auto exponential = [](Pack x) __attribute__((always_inline)) { return exp(x); };
const auto logarithm = [](Pack x) __attribute__((always_inline)) { return log(x); };

void check_same_bytes(const std::vector<double>& in, const auto& f) {
    const auto expected = mapped(in, Instructions::baseline, f);
    for (const Instructions set : every_set)
        if (has(set)) RC_ASSERT(mapped(in, set, f) == expected);
}

}  // namespace

TEST_CASE("exp and log of packs are within 2 ulp for any instruction set") {
    property("e^x within 1.5 ulp", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<double> x(64);
        for (double& value : x) value = dice.uniform(-1, 1) * std::pow(10.0, dice.uniform(-3, 2.8));
        check_same_bytes(x, exponential);
        const auto y = mapped(x, widest_instructions(), exponential);
        for (std::size_t i = 0; i < x.size(); ++i) {
            const long double expected = std::exp(static_cast<long double>(x[i]));
            RC_ASSERT(std::abs(static_cast<double>((y[i] - expected) / expected)) <= 1.5 * ulp);
        }
    });
    property("ln x within 2 ulp", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<double> x(64);
        for (double& value : x) value = std::exp(dice.uniform(-1, 1) * std::pow(10.0, dice.uniform(-3, 2.8)));
        check_same_bytes(x, logarithm);
        const auto y = mapped(x, widest_instructions(), logarithm);
        for (std::size_t i = 0; i < x.size(); ++i) {
            const long double expected = std::log(static_cast<long double>(x[i]));
            RC_ASSERT(std::abs(static_cast<double>(y[i] - expected)) <=
                      2 * ulp * std::abs(static_cast<double>(expected)));
        }
    });
}

TEST_CASE("exp and log of packs accept zeros, infinities and NaN") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    const auto e = mapped({0, -0.0, 1e9, -1e9, infinity, -infinity, nan, 1}, widest_instructions(), exponential);
    CHECK(e[0] == 1);
    CHECK(e[1] == 1);
    CHECK(std::isfinite(e[2]));
    CHECK(e[3] > 0);
    CHECK(e[4] == e[2]);
    CHECK(e[5] == e[3]);
    CHECK(std::isnan(e[6]));
    const auto l = mapped({1, 0, -1, nan, 2, 0.5, 1e-300, 1e300}, widest_instructions(), logarithm);
    CHECK(l[0] == 0);
    CHECK(std::isnan(l[1]));
    CHECK(std::isnan(l[2]));
    CHECK(std::isnan(l[3]));
    CHECK(l[4] == -l[5]);
}

TEST_CASE("the widest instruction set is one that the processor has") {
    CHECK(has(Instructions::baseline));
    CHECK(has(widest_instructions()));
}
