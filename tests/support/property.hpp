// Property tests: RapidCheck inside a doctest case.
//
//     TEST_CASE("vec") {
//         camber::testing::property("addition commutes", [](double a, double b) { RC_ASSERT(a + b == b + a); });
//     }
//
// Inside a property use RapidCheck's RC_ASSERT, RC_PRE and so on: a doctest CHECK there would also count what fails
// while a counterexample is shrunk. Use `*rc::gen::…` for values with a law of their own.
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
#include <cstdlib>
#include <sstream>
#include <string>
#include <utility>

#include "sanitized.hpp"

namespace camber::testing {

/// Under the sanitizers a trial costs tenfold, and what they look for shows in few: a quarter of the trials, of the
/// same range of sizes. The release build tries all.
inline int successes_here(int count) { return less_if_sanitized(count, std::max(count / 4, std::min(count, 5))); }

struct Trials {
    int count = 100;         // successes that are enough
    int max_size = 100;      // RapidCheck's size: how large generated values and containers may get
    int max_discarded = 10;  // draws that RC_PRE may refuse, for each success
};

template <class Testable>
void property(const std::string& name, Testable&& testable, Trials trials = {}) {
    rc::detail::TestMetadata metadata;
    metadata.id = name;
    metadata.description = name;

    const bool configured = std::getenv("RC_PARAMS") != nullptr;
    const auto result = [&] {
        if (configured) return rc::detail::checkTestable(std::forward<Testable>(testable), metadata);
        rc::detail::TestParams params;
        std::uint64_t hash = 14695981039346656037U;  // FNV-1a
        for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211U;
        params.seed = hash;
        params.maxSuccess = successes_here(trials.count);
        params.maxSize = trials.max_size;
        params.maxDiscardRatio = trials.max_discarded;
        return rc::detail::checkTestable(std::forward<Testable>(testable), metadata, params);
    }();

    std::ostringstream text;
    rc::detail::printResultMessage(result, text);
    const bool holds = result.template is<rc::detail::SuccessResult>();
    INFO(name << ": " << text.str());
    CHECK(holds);
}

}  // namespace camber::testing
