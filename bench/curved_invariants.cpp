// The laws of the cavity operator of degree 2, whole: random operations through `plan` on random bowed domains that are
// stretched by up to 10^6, until each kind was accepted so many times where the cavity was bowed, with all that holds
// looked at along the way (tests/support/curved_laws.hpp), and a table of what became of them. Exit code 1: a law
// broke, by the seed and step that are told, or a kind stayed rare. A program with arguments, not a timed test:
//
//     curved_laws [--operations 100000] [--accepted 10000] [--seed 1] [--check 16] [--threads 0]
//
// operations, accepted: in all, and of each kind, in each dimension; check: steps from one look at the whole mesh to
// the next. Threads have no say in the table.
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
                    row.accepted + rejected + row.nowhere, row.accepted, row.bowed, row.straight_inverted,
                    row.drawn_back, row.nowhere);
        for (const R reason : reasons) {
            const std::size_t n = row.rejected[static_cast<std::size_t>(reason)];
            std::printf(" %8zu", n);
            rejected -= n;
        }
        std::printf(" %8zu\n", rejected);
    }
}

/// One domain.
template <int D>
struct Ran {
    CurvedTally<D> tally;
    std::string broken;
};
template <int D>
Ran<D> ran(std::uint64_t seed, const CurvedRunOptions& options) {
    Ran<D> out;
    try {
        out.broken = CurvedRun<D>(seed, options).run(out.tally);
    } catch (const std::exception& e) {
        out.broken = "seed " + std::to_string(seed) + ": " + e.what();
    }
    return out;
}

/// False where a law breaks or a kind stays rare.
template <int D>
bool holds(const Arguments& a) {
    const auto begin = std::chrono::steady_clock::now();
    const CurvedRunOptions options{.steps_a_check = static_cast<std::size_t>(a.check)};
    constexpr std::size_t together = 32;
    CurvedTally<D> tally;
    std::size_t domains = 0;
    const Execution execution{.threads = static_cast<int>(a.threads)};
    const auto count = [&] { return static_cast<double>(domains * options.steps); };
    const auto is_rare = [&] { return static_cast<double>(tally.least()) < a.accepted; };
    // A kind of which one try in a hundred goes is not rare.
    const double most = 100 * (a.operations + a.accepted * static_cast<double>(tally.rows.size()));
    for (; count() < a.operations || (is_rare() && count() < most); domains += together) {
        const auto batch = must(map_each(
            execution, together,
            [&](std::size_t i) { return ran<D>(static_cast<std::uint64_t>(a.seed) + domains + i, options); }, 1));
        for (const Ran<D>& one : batch) {
            tally += one.tally;
            if (one.broken.empty()) continue;
            std::printf("%dD: a law is broken: %s\n", D, one.broken.c_str());
            return false;
        }
    }
    print(tally);
    std::printf("%zu operations on %zu domains, seeds from %.0f on, in %.1f s\n\n", domains * options.steps, domains,
                a.seed, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (!is_rare()) return true;
    std::printf("%dD: a kind was accepted %zu times only\n", D, tally.least());
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
        std::printf("a law is broken: %s\n", e.what());
        return 1;
    }
}
