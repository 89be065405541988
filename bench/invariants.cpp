// Checks the invariants of dynamic meshes with random operations on random domains, until each kind was accepted a
// given number of times (tests/support/mesh_invariants.hpp), and prints a table of the results. A second run checks
// topology only, where elements may be inverted. Exit code 1: an invariant is violated (the seed and the step are
// printed), or a kind is too rare. The program takes arguments and is not a timed test:
//
//     invariants [--operations 100000] [--accepted 10000] [--seed 1] [--check 16]
//
// operations: total number of operations per dimension.
// accepted: number of accepted operations of each kind per dimension.
// check: number of steps between two checks of the whole mesh.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>

#include "operation_names.hpp"
#include "operation_runs.hpp"
#include "program_arguments.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

struct Arguments {
    std::size_t operations = 100000, accepted = 10000;
    std::uint64_t seed = 1;
    std::size_t check = 16;
};

template <int D>
void print(const Tally<D>& tally, const char* what) {
    constexpr std::array reasons{"", "empty", "required", "surface", "line", "ball", "exists", "place", "volume"};
    std::printf("%dD, %-19s %9s %9s", D, what, "tried", "accepted");
    for (std::size_t i = 1; i < reasons.size(); ++i) std::printf(" %8s", reasons[i]);
    std::printf("\n");
    for (std::size_t k = 0; k < tally.rows.size(); ++k) {
        const auto& [accepted, refused] = tally.rows[k];
        std::size_t tried = accepted;
        for (const std::size_t count : refused) tried += count;
        std::printf("%-23s %9zu %9zu", name_of(kinds<D>()[k]).c_str(), tried, accepted);
        for (std::size_t i = 1; i < refused.size(); ++i) std::printf(" %8zu", refused[i]);
        std::printf("\n");
    }
}

/// Returns false if an invariant is violated or a kind is too rare.
template <int D, class Run>
bool holds(const Arguments& a, const char* what, RunOptions options, Run&& run) {
    const auto begin = std::chrono::steady_clock::now();
    options.steps_a_check = a.check;
    Tally<D> tally;
    std::size_t domains = 0;
    // A kind is rare if fewer than one in a hundred attempts is accepted.
    const std::size_t max_domains = 100 * (a.operations + a.accepted * kinds<D>().size()) / options.steps;
    for (; domains <= max_domains && (tally.least() < a.accepted || domains * options.steps < a.operations); ++domains)
        if (const std::string violation = run(a.seed + domains, options, tally); !violation.empty()) {
            std::printf("%dD, %s: an invariant is violated: %s\n", D, what, violation.c_str());
            return false;
        }
    print(tally, what);
    std::printf("%zu operations on %zu domains, first seed %llu, in %.1f s\n\n", domains * options.steps, domains,
                static_cast<unsigned long long>(a.seed),
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (tally.least() >= a.accepted) return true;
    std::printf("%dD, %s: a kind was accepted only %zu times\n", D, what, tally.least());
    return false;
}
template <int D>
bool all_hold(const Arguments& a) {
    const RunOptions small{.steps = 200, .max_elements = 300};
    const bool of_domains = holds<D>(a, "domain", {.max_elements = D == 2 ? 200 : 600}, run_operations<D>);
    return holds<D>(a, "topology only", small, run_topology<D>) && of_domains;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments a;
    double operations = 100000;
    double accepted = 10000;
    double seed = 1;
    double check = 16;
    if (!read_numbers(
            argc, argv,
            {{"--operations", &operations}, {"--accepted", &accepted}, {"--seed", &seed}, {"--check", &check, 1}}))
        return 2;
    a = {static_cast<std::size_t>(operations), static_cast<std::size_t>(accepted), static_cast<std::uint64_t>(seed),
         static_cast<std::size_t>(check)};
    try {
        const bool flat = all_hold<2>(a);
        return all_hold<3>(a) && flat ? 0 : 1;
    } catch (const std::exception& e) {
        std::printf("an invariant is violated: %s\n", e.what());
        return 1;
    }
}
