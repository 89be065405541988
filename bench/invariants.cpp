// The laws of a mesh that changes, whole: random operations on random domains, until each kind was accepted so many
// times, with all that holds of a mesh looked at along the way (tests/support/mesh_laws.hpp), and a table of what
// became of them; then the same by topology alone, where elements may be inverted. Exit code 1: a law broke, by the
// seed and step that are told, or a kind stayed rare. A program with arguments, not a timed test:
//
//     laws [--operations 100000] [--accepted 10000] [--seed 1] [--check 16]
//
// operations, accepted: in all, and of each kind, in each dimension; check: steps from one look at the whole mesh to
// the next.
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

/// False where a law breaks or a kind stays rare.
template <int D, class Run>
bool holds(const Arguments& a, const char* what, RunOptions options, Run&& run) {
    const auto begin = std::chrono::steady_clock::now();
    options.steps_a_check = a.check;
    Tally<D> tally;
    std::size_t domains = 0;
    // A kind of which one try in a hundred goes is not rare.
    const std::size_t most = 100 * (a.operations + a.accepted * kinds<D>().size()) / options.steps;
    for (; domains <= most && (tally.least() < a.accepted || domains * options.steps < a.operations); ++domains)
        if (const std::string broken = run(a.seed + domains, options, tally); !broken.empty()) {
            std::printf("%dD, %s: a law is broken: %s\n", D, what, broken.c_str());
            return false;
        }
    print(tally, what);
    std::printf("%zu operations on %zu domains, seeds from %llu on, in %.1f s\n\n", domains * options.steps, domains,
                static_cast<unsigned long long>(a.seed),
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (tally.least() >= a.accepted) return true;
    std::printf("%dD, %s: a kind was accepted %zu times only\n", D, what, tally.least());
    return false;
}
template <int D>
bool all_hold(const Arguments& a) {
    const RunOptions small{.steps = 200, .max_elements = 300};
    const bool of_domains = holds<D>(a, "of the domain", {.max_elements = D == 2 ? 200 : 600}, run_operations<D>);
    return holds<D>(a, "topology alone", small, run_topology<D>) && of_domains;
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
        std::printf("a law is broken: %s\n", e.what());
        return 1;
    }
}
