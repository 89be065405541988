// Checks the invariants of remeshing passes on 2D and 3D domains: twenty rounds of collapse, split, swap and smooth to
// alternately coarser and finer metrics, with a check after each round (tests/support/many_rounds.hpp). Exit code 1: an
// invariant is violated. The program takes arguments and is not a timed test:
//
//     pass_invariants [--cells 12] [--rounds 20] [--seed 1] [--threads 0]
//
// cells: number of cells along each axis, rounded down to a multiple of 4; in 2D four times as many.
//
// Columns of a round:
// - the requested size relative to that of the first mesh;
// - the number of operations of each pass;
// - the maximum relative deviation of measures (volumes of materials, areas, lengths): of flat entities from the first
//   mesh, of curved ones from their formula;
// - the number of vertices off their surface, which moved only a part of the way to their target.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "many_rounds.hpp"
#include "named_domains.hpp"
#include "program_arguments.hpp"

import camber.core;
import camber.cavity;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

struct Arguments {
    double cells = 12, rounds = 20, seed = 1, threads = 0;
};

template <int D>
bool holds(NamedDomain<D> domain, const Arguments& a) {
    std::printf("%dD, %s\n%5s %5s %8s %8s |%8s %8s %8s %8s |%8s %8s %5s |%6s %7s\n", D, domain.name.c_str(), "round",
                "size", "vertices", "elements", "collapse", "split", "swap", "smooth", "flat", "curved", "off", "unit",
                "worst");
    ManyRounds<D> rounds(std::move(domain), static_cast<std::uint64_t>(a.seed),
                         {.threads = static_cast<int>(a.threads)});
    for (int k = 0; k < a.rounds; ++k) {
        Round round;
        const std::string violation = rounds.run(size_of_round(k), round);
        const auto& [size, vertices, elements, passes, flat, curved, off, unit, worst] = round;
        std::printf("%5d %5.2f %8zu %8zu |%8zu %8zu %8zu %8zu |%8.1e %8.1e %5zu |%5.1f%% %7.1e\n", k + 1, size,
                    vertices, elements, passes[0].accepted, passes[1].accepted, passes[2].accepted, passes[3].accepted,
                    flat, curved, off, 100 * unit, worst);
        if (violation.empty()) continue;
        std::printf("an invariant is violated: %s\n\n", violation.c_str());
        return false;
    }
    std::printf("\n");
    return true;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments a;
    if (!read_numbers(
            argc, argv,
            {{"--cells", &a.cells, 4}, {"--rounds", &a.rounds}, {"--seed", &a.seed}, {"--threads", &a.threads}}))
        return 2;
    const int cells = 4 * static_cast<int>(a.cells / 4);
    bool all = true;
    try {
        for (NamedDomain<2>& domain : named_domains<2>(4 * cells)) all = holds(std::move(domain), a) && all;
        for (NamedDomain<3>& domain : named_domains<3>(cells)) all = holds(std::move(domain), a) && all;
    } catch (const std::exception& e) {
        std::printf("an invariant is violated: %s\n", e.what());
        return 1;
    }
    return all ? 0 : 1;
}
