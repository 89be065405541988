// Elementary functions: errors relative to wider types, special values, exact cases, and hashes.
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>
#include <rapidcheck.h>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using namespace camber::testing;

namespace {

using Limits64 = std::numeric_limits<double>;
using Wide = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<40>, boost::multiprecision::et_off>;

constexpr double infinity = Limits64::infinity(), nan = Limits64::quiet_NaN();
constexpr double normal_bound = 0.6, subnormal_bound = 1;  // ulp

/// A function, that of the C library for a wider type, and the interval in which its results vary most.
struct Function {
    const char* name;
    double (*of)(double);
    long double (*wide)(long double);
    double low, high;
    std::uint64_t hash;  ///< of the bytes of its values at 20 000 fixed arguments
};

const std::array functions{
    Function{"exp", camber::exp, std::exp, -746, 711, 0xfbbe00d03629a69c},
    Function{"exp2", camber::exp2, std::exp2, -1076, 1025, 0x510ee60899969b48},
    Function{"expm1", camber::expm1, std::expm1, -40, 711, 0xd9c9cb7f906243b0},
    Function{"log", camber::log, std::log, 0, 4, 0x215478f5fc9011d4},
    Function{"log2", camber::log2, std::log2, 0, 4, 0x9301584a8b121925},
    Function{"log10", camber::log10, std::log10, 0, 4, 0x3211ce39102ed4ef},
    Function{"log1p", camber::log1p, std::log1p, -1, 4, 0x6b5db03d8514a5c8},
    Function{"cbrt", camber::cbrt, std::cbrt, -10, 10, 0xac4bd64b03942e9d},
    Function{"sinh", camber::sinh, std::sinh, -712, 712, 0x4247b661af4b2ac4},
    Function{"cosh", camber::cosh, std::cosh, -712, 712, 0xdfeb2b8d991d2cc2},
    Function{"tanh", camber::tanh, std::tanh, -22, 22, 0xa0af29f77e6e228f},
    Function{"asinh", camber::asinh, std::asinh, -10, 10, 0x5e57123a95659ab3},
    Function{"acosh", camber::acosh, std::acosh, 1, 10, 0x1e0c74f87bf1b1f0},
    Function{"atanh", camber::atanh, std::atanh, -1, 1, 0xf5bbd7ca8c6af131},
    Function{"sin", camber::sin, std::sin, -10, 10, 0x7a172509f114a3e7},
    Function{"cos", camber::cos, std::cos, -10, 10, 0xaa9ed754673c68e1},
    Function{"tan", camber::tan, std::tan, -10, 10, 0x6fc9d166e9ea23d9},
    Function{"asin", camber::asin, std::asin, -1, 1, 0x7e31b10ae3017900},
    Function{"acos", camber::acos, std::acos, -1, 1, 0x537491227c6ea6a7},
    Function{"atan", camber::atan, std::atan, -10, 10, 0x55d57162c0ca1d8c},
};

struct FunctionOfTwo {
    const char* name;
    double (*of)(double, double);
    long double (*wide)(long double, long double);
};
const std::array functions_of_two{
    FunctionOfTwo{"pow", camber::pow, std::pow},
    FunctionOfTwo{"atan2", camber::atan2, std::atan2},
    FunctionOfTwo{"hypot", camber::hypot, std::hypot},
};

const std::vector<double> special{0.0,
                                  Limits64::denorm_min(),
                                  0x1.8p-1040,
                                  Limits64::min(),
                                  1e-300,
                                  1e-17,
                                  0.5,
                                  1 - Limits64::epsilon() / 2,
                                  1,
                                  1 + Limits64::epsilon(),
                                  std::numbers::pi / 2,
                                  2,
                                  3,
                                  710,
                                  745.2,
                                  1024,
                                  0x1p53,
                                  0x1p53 + 2,
                                  1e22,
                                  1e300,
                                  Limits64::max(),
                                  infinity,
                                  nan};

/// A random finite number of any magnitude.
double any_number(Dice& dice) {
    for (;;) {
        const double x = std::bit_cast<double>(dice.engine()());
        if (std::isfinite(x)) return x;
    }
}

/// A random argument: in the interval, small, near 1, or of any magnitude.
double argument(Dice& dice, double low, double high) {
    switch (dice.below(4)) {
        case 0: return dice.uniform(low, high);
        case 1: return dice.uniform(low, high) * std::exp2(dice.uniform(-60, 0));
        case 2: return 1 + dice.uniform(-1, 1) * std::exp2(dice.uniform(-52, 0));
        default: return any_number(dice);
    }
}

/// |value − expected| in units in the last place of `expected`; 0 if both are NaN or overflow alike.
template <class Reference>
double ulps(double value, const Reference& expected) {
    const auto nearest = static_cast<double>(expected);
    if (std::isnan(value) || std::isnan(nearest)) return std::isnan(value) && std::isnan(nearest) ? 0 : infinity;
    if (std::isinf(value) || std::isinf(nearest)) return value == nearest ? 0 : infinity;
    const double unit = nearest == 0 ? 0 : std::ldexp(1.0, std::ilogb(nearest) - 52);
    const Reference off = Reference(value) - expected;
    return std::abs(static_cast<double>(off / Reference(std::fmax(unit, Limits64::denorm_min()))));
}

double bound(double value) { return std::abs(value) < 2 * Limits64::min() ? subnormal_bound : normal_bound; }

bool same_bits(double a, double b) {
    return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// Values without rounding must agree exactly: infinities, signed zeros and NaN.
bool is_special(double x) { return !std::isfinite(x) || x == 0; }

}  // namespace

TEST_CASE("elementary functions are within 0.6 ulp") {
    for (const Function& f : functions)
        property(f.name, [&f](std::uint64_t seed) {
            Dice dice(seed);
            for (int i = 0; i < 100; ++i) {
                const double x = argument(dice, f.low, f.high), value = f.of(x);
                if (ulps(value, f.wide(x)) > bound(value)) RC_FAIL(std::string(f.name) + " of " + std::to_string(x));
            }
        });
    for (const FunctionOfTwo& f : functions_of_two) {
        if (std::string(f.name) == "pow") continue;  // the C library's long double has no spare digits
        property(f.name, [&f](std::uint64_t seed) {
            Dice dice(seed);
            for (int i = 0; i < 100; ++i) {
                const double x = argument(dice, -3, 3),
                             y = dice.below(2) == 0 ? argument(dice, -3, 3) : x * dice.uniform(-2, 2);
                const double value = f.of(x, y);
                RC_ASSERT(ulps(value, f.wide(x, y)) <= bound(value));
            }
        });
    }
}

TEST_CASE("powers are within 0.6 ulp") {
    property("x^y is within 0.6 ulp", [](std::uint64_t seed) {
        Dice dice(seed);
        for (int i = 0; i < 4; ++i) {
            const double x = i % 2 == 0 ? std::exp2(dice.uniform(-1000, 1000)) : argument(dice, 0, 10);
            if (!(x > 0) || x == 1) continue;
            const double most = 744 / std::abs(std::log(x));
            const double y = i % 3 == 0 ? std::round(dice.uniform(-20, 20)) : dice.uniform(-most, most);
            const double value = camber::pow(x, y);
            if (std::isinf(value) || value == 0) continue;  // covered by the special values
            RC_ASSERT(ulps(value, Wide(boost::multiprecision::pow(Wide(x), Wide(y)))) <= bound(value));
            RC_ASSERT(same_bits(camber::pow(-x, std::round(y)),
                                camber::pow(x, std::round(y)) * (std::fmod(std::round(y), 2) == 0 ? 1 : -1)));
        }
    });
}

TEST_CASE("special values of elementary functions equal those of C") {
    const auto check = [](const std::string& name, double value, long double wide) {
        const auto expected = static_cast<double>(wide);
        const bool is_accurate = is_special(expected) ? same_bits(value, expected) : ulps(value, wide) <= bound(value);
        CHECK_MESSAGE(is_accurate, name << " is " << value << ", expected " << expected);
    };
    for (const double magnitude : special)
        for (const double x : {magnitude, -magnitude}) {
            for (const Function& f : functions) check(f.name + ("(" + std::to_string(x) + ")"), f.of(x), f.wide(x));
            for (const double other : special)
                for (const double y : {other, -other})
                    for (const FunctionOfTwo& f : functions_of_two)
                        check(f.name + ("(" + std::to_string(x) + ", " + std::to_string(y) + ")"), f.of(x, y),
                              f.wide(x, y));
        }
}

TEST_CASE("elementary functions are exact where the result is representable") {
    CHECK(camber::exp(0) == 1);
    CHECK(camber::cos(0) == 1);
    CHECK(camber::cosh(0) == 1);
    CHECK(camber::log(1) == 0);
    CHECK(same_bits(camber::acos(1), 0.0));
    for (int k = -1074; k < 1024; ++k) {
        REQUIRE(camber::exp2(k) == std::ldexp(1.0, k));
        REQUIRE(camber::pow(2, k) == std::ldexp(1.0, k));
        REQUIRE(camber::log2(std::ldexp(1.0, k)) == k);
    }
    double ten = 1;
    for (int k = 0; k <= 22; ++k, ten *= 10) {
        CHECK(camber::pow(10, k) == ten);
        CHECK(camber::log10(ten) == k);
    }
    for (int k = 1; k < 2000; ++k) {
        const double x = k;
        REQUIRE(camber::cbrt(x * x * x) == x);
        REQUIRE(camber::hypot(3 * x, -4 * x) == 5 * x);
        REQUIRE(camber::pow(x, 3) == x * x * x);
        REQUIRE(camber::pow(x * x, 0.5) == x);
    }
    const double quarter = std::numbers::pi / 4;
    CHECK(camber::atan2(2, 2) == quarter);
    CHECK(camber::atan2(2, -2) == 3 * quarter);
    CHECK(camber::atan2(-2, -2) == -3 * quarter);
    CHECK(camber::atan2(-2, 2) == -quarter);
    CHECK(camber::atan2(0, -1) == std::numbers::pi);
    CHECK(camber::atan2(-0.0, -1) == -std::numbers::pi);
    CHECK(camber::asin(1) == 2 * quarter);
}

TEST_CASE("symmetries of elementary functions hold to the last bit") {
    property("odd and even functions are symmetric and x^2 is x x, to the last bit", [](std::uint64_t seed) {
        Dice dice(seed);
        for (int i = 0; i < 100; ++i) {
            const double x = argument(dice, -3, 3), y = argument(dice, -3, 3);
            RC_ASSERT(same_bits(camber::pow(x, 2), x * x));
            for (const auto odd : {camber::sin, camber::tan, camber::atan, camber::sinh, camber::tanh, camber::asinh})
                RC_ASSERT(same_bits(odd(-x), -odd(x)));
            RC_ASSERT(same_bits(camber::cos(-x), camber::cos(x)));
            RC_ASSERT(same_bits(camber::cosh(-x), camber::cosh(x)));
            RC_ASSERT(same_bits(camber::hypot(x, y), camber::hypot(-y, x)));
            RC_ASSERT(same_bits(camber::atan2(-y, x), -camber::atan2(y, x)));
        }
    });
}

// The hashes are the same for every processor, compiler and build.
TEST_CASE("elementary functions have the recorded hashes") {
    const auto add = [](std::uint64_t& hash, double value) {
        hash = (hash ^ (std::isnan(value) ? 0 : std::bit_cast<std::uint64_t>(value))) * 0x100000001b3U;
    };
    const auto place = [](std::uint64_t& state, double low, double high) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        const double x = std::bit_cast<double>(state ^ (state >> 32U));
        return state % 4 == 0 && std::isfinite(x) ? x
                                                  : low + (high - low) * static_cast<double>(state >> 11U) * 0x1p-53;
    };
    for (const Function& f : functions) {
        std::uint64_t hash = 0xcbf29ce484222325U, state = 1;
        for (int i = 0; i < 20000; ++i) add(hash, f.of(place(state, f.low, f.high)));
        CHECK_MESSAGE(hash == f.hash, std::string(f.name) << " has the hash " << hash);
    }
    constexpr std::array<std::uint64_t, 3> of_two{0x8945567848f5575e, 0xab2d9f710a7c2cb3, 0x500b03f214681be9};
    for (std::size_t k = 0; k < of_two.size(); ++k) {
        std::uint64_t hash = 0xcbf29ce484222325U, state = 1;
        for (int i = 0; i < 20000; ++i) {
            const double x = place(state, 0, 3), y = place(state, -3, 3);
            add(hash, functions_of_two.at(k).of(x, y));
        }
        CHECK_MESSAGE(hash == of_two.at(k), std::string(functions_of_two.at(k).name) << " has the hash " << hash);
    }
}
