// Checks the invariants of the quadratic cavity operator with random operations on random bowed domains that are
// stretched by up to 10^6. The run continues until each kind was accepted a given number of times on bowed cavities
// (tests/support/curved_invariants.hpp), and prints a table of the results. Exit code 1: an invariant is violated (the
// seed and the step are printed), or a kind is too rare. The program takes arguments and is not a timed test:
//
//     curved_invariants [--operations 100000] [--accepted 10000] [--seed 1] [--check 16] [--threads 0]
//
// operations: total number of operations per dimension.
// accepted: number of accepted operations of each kind per dimension.
// check: number of steps between two checks of the whole mesh.
// The table does not depend on the number of threads.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.validity;
import camber.operation;
import camber.adapt;

#include "curved_runs.hpp"
#include "operation_names.hpp"
#include "program_arguments.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

struct Arguments {
    double operations = 100000, accepted = 10000, seed = 1, check = 16, threads = 0;
};

std::string name_of(const CurvedKind& kind) {
    return kind.splits ? "split" + camber::testing::name_of(kind.kind).substr(std::string("insertion").size())
                       : camber::testing::name_of(kind.kind);
}

template <int D>
void print(const CurvedTally<D>& tally) {
    using R = RejectionReason;
    constexpr std::array reasons{R::required, R::surface, R::line,    R::ball,
                                 R::exists,   R::volume,  R::quality, R::geometry};
    std::printf("%dD %-20s %8s %8s %8s %8s %8s %8s", D, "", "tried", "accepted", "bowed", "inverted", "drawn",
                "nowhere");
    for (const R reason : reasons) std::printf(" %8s", std::string(word_of(reason)).c_str());
    std::printf(" %8s\n", "other");
    for (std::size_t k = 0; k < tally.rows.size(); ++k) {
        const auto& row = tally.rows[k];
        std::size_t rejected = 0;
        for (const std::size_t n : row.rejected) rejected += n;
        std::printf("%-23s %8zu %8zu %8zu %8zu %8zu %8zu", name_of(curved_kinds<D>()[k]).c_str(),
                    row.accepted + rejected + row.nowhere, row.accepted, row.bowed, row.straight_inverted, row.relaxed,
                    row.nowhere);
        for (const R reason : reasons) {
            const std::size_t n = row.rejected[static_cast<std::size_t>(reason)];
            std::printf(" %8zu", n);
            rejected -= n;
        }
        std::printf(" %8zu\n", rejected);
    }
}

/// Result of one domain.
template <int D>
struct DomainResult {
    CurvedTally<D> tally;
    std::string violation;
};
template <int D>
DomainResult<D> run_domain(std::uint64_t seed, const CurvedRunOptions& options) {
    DomainResult<D> out;
    try {
        out.violation = CurvedRun<D>(seed, options).run(out.tally);
    } catch (const std::exception& e) {
        out.violation = "seed " + std::to_string(seed) + ": " + e.what();
    }
    return out;
}

/// Returns false if an invariant is violated or a kind is too rare.
template <int D>
bool holds(const Arguments& a) {
    const auto begin = std::chrono::steady_clock::now();
    const CurvedRunOptions options{.steps_a_check = static_cast<std::size_t>(a.check)};
    constexpr std::size_t batch_size = 32;
    CurvedTally<D> tally;
    std::size_t domains = 0;
    const Execution execution{.threads = static_cast<int>(a.threads)};
    const auto count = [&] { return static_cast<double>(domains * options.steps); };
    const auto is_rare = [&] { return static_cast<double>(tally.least()) < a.accepted; };
    // A kind is rare if fewer than one in a hundred attempts is accepted.
    const double max_operations = 100 * (a.operations + a.accepted * static_cast<double>(tally.rows.size()));
    for (; count() < a.operations || (is_rare() && count() < max_operations); domains += batch_size) {
        const auto batch = must(map_each(
            execution, batch_size,
            [&](std::size_t i) { return run_domain<D>(static_cast<std::uint64_t>(a.seed) + domains + i, options); },
            1));
        for (const DomainResult<D>& one : batch) {
            tally += one.tally;
            if (one.violation.empty()) continue;
            std::printf("%dD: an invariant is violated: %s\n", D, one.violation.c_str());
            return false;
        }
    }
    print(tally);
    std::printf("%zu operations on %zu domains, first seed %.0f, in %.1f s\n\n", domains * options.steps, domains,
                a.seed, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (!is_rare()) return true;
    std::printf("%dD: a kind was accepted only %zu times\n", D, tally.least());
    return false;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments a;
    if (!read_numbers(argc, argv,
                      {{"--operations", &a.operations},
                       {"--accepted", &a.accepted},
                       {"--seed", &a.seed},
                       {"--check", &a.check, 1},
                       {"--threads", &a.threads}}))
        return 2;
    try {
        const bool flat = holds<2>(a);
        return holds<3>(a) && flat ? 0 : 1;
    } catch (const std::exception& e) {
        std::printf("an invariant is violated: %s\n", e.what());
        return 1;
    }
}
