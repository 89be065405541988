// Property tests: RapidCheck inside a doctest case.
//
//     TEST_CASE("vec") {
//         camber::testing::property("addition commutes", [] {
//             const auto a = *rc::gen::arbitrary<double>(), b = *rc::gen::arbitrary<double>();
//             RC_ASSERT(a + b == b + a);
//         });
//     }
//
// Inside a property use RapidCheck's RC_ASSERT, RC_PRE and so on: a doctest CHECK there would also count what fails
// while a counterexample is shrunk.
//
// A run is repeatable: the seed is a hash of the name. Other runs, and more of them:
//     RC_PARAMS="max_success=100000" build/bin/test_core -tc=vec        (with a seed of its own at every run)
//     RC_PARAMS="seed=42" …
// A counterexample is printed with the `reproduce=…` that RC_PARAMS takes to see it again.
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

/// Under the sanitizers a trial costs tenfold, and what they look for shows in few: an eighth of the trials, of the
/// same range of sizes. The release build tries all.
inline int successes_here(int count) { return less_if_sanitized(count, std::max(count / 8, std::min(count, 2))); }

struct Trials {
    int count = 100;         // successes that are enough
    int max_size = 100;      // RapidCheck's size: how large generated values and containers may get
    int max_discarded = 10;  // draws that RC_PRE may refuse, for each success
};

/// A law of nothing, which draws what it needs by `*rc::gen::…`, and one of a number drawn for it.
using Law = std::function<void()>;
using SeededLaw = std::function<void(std::uint64_t)>;

/// Compiled once (property.cpp): what RapidCheck instantiates for a law takes longer to compile than most laws.
void check_law(const std::string& name, const Law& law, const Trials& trials);
void check_law(const std::string& name, const SeededLaw& law, const Trials& trials);

template <class Testable>
void property(const std::string& name, const Testable& testable, const Trials& trials = {}) {
    const std::function erased = testable;
    static_assert(std::is_same_v<decltype(erased), const Law> || std::is_same_v<decltype(erased), const SeededLaw>,
                  "a law takes nothing or a std::uint64_t, returns nothing, and draws what else it needs");
    check_law(name, erased, trials);
}

}  // namespace camber::testing
