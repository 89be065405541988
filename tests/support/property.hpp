// Property tests: RapidCheck inside a doctest case.
//
//     TEST_CASE("addition of vectors is commutative") {
//         camber::testing::property("the sum of two numbers does not depend on their order", [] {
//             const auto a = *rc::gen::arbitrary<double>(), b = *rc::gen::arbitrary<double>();
//             RC_ASSERT(a + b == b + a);
//         });
//     }
//
// Inside a property use RapidCheck's RC_ASSERT, RC_PRE and so on: a doctest CHECK would also count failures while
// RapidCheck shrinks a counterexample.
//
// A run is repeatable: the seed is a hash of the name of the property, so that a new name draws other values. Other
// seeds and numbers of trials (RC_PARAMS without a seed: a new seed at every run):
//     RC_PARAMS="max_success=100000" build/bin/test_core -tc="addition*"
//     RC_PARAMS="seed=42" …
// RapidCheck prints a counterexample with the value `reproduce=…` for RC_PARAMS that repeats it.
#pragma once

#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>

#include "sanitized.hpp"

namespace camber::testing {

/// Number of successes in this build: an eighth under the sanitizers, which make a trial ten times slower. The range of
/// sizes is the same.
inline int successes_here(int count) { return less_if_sanitized(count, std::max(count / 8, std::min(count, 2))); }

struct Trials {
    int count = 100;         // required successes
    int max_size = 100;      // RapidCheck's size: upper limit of generated values and containers
    int max_discarded = 10;  // maximum number of draws rejected by RC_PRE per success
};

/// A property without arguments, which draws values by `*rc::gen::…`, and one with a random seed.
using Property = std::function<void()>;
using SeededProperty = std::function<void(std::uint64_t)>;

/// Compiled once in property.cpp, since the templates of RapidCheck take longer to compile than most tests.
void check_property(const std::string& name, const Property& checked_property, const Trials& trials);
void check_property(const std::string& name, const SeededProperty& checked_property, const Trials& trials);

template <class Testable>
void property(const std::string& name, const Testable& testable, const Trials& trials = {}) {
    const std::function erased = testable;
    static_assert(
        std::is_same_v<decltype(erased), const Property> || std::is_same_v<decltype(erased), const SeededProperty>,
        "a property takes nothing or a std::uint64_t, returns nothing, and draws all other values");
    check_property(name, erased, trials);
}

}  // namespace camber::testing
