// What passes keep, counted: domains of two and three dimensions, twenty rounds of collapse, split, swap and smooth to
// metrics that are coarser and finer in turn, and after each round all that must hold (tests/support/many_rounds.hpp).
// Exit code 1: something was not kept. A program with arguments, not a timed test:
//
//     laws_of_passes [--cells 12] [--rounds 20] [--seed 1] [--threads 0]
//
// cells: along each axis, down to a multiple of 4; in two dimensions four times as many.
//
// Of a round: the size asked for, by that of the first mesh; what each pass did; the largest relative deviation of
// sizes (volumes of materials, areas, lengths): of what is flat, from the beginning, and of what is curved, from its
// formula; vertices that are not on their surface, since they went a part of their way only.
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
        const std::string broken = rounds.run(size_of_round(k), round);
        const auto& [size, vertices, elements, passes, flat, curved, off, unit, worst] = round;
        std::printf("%5d %5.2f %8zu %8zu |%8zu %8zu %8zu %8zu |%8.1e %8.1e %5zu |%5.1f%% %7.1e\n", k + 1, size,
                    vertices, elements, passes[0].accepted, passes[1].accepted, passes[2].accepted, passes[3].accepted,
                    flat, curved, off, 100 * unit, worst);
        if (broken.empty()) continue;
        std::printf("not kept: %s\n\n", broken.c_str());
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
        std::printf("not kept: %s\n", e.what());
        return 1;
    }
    return all ? 0 : 1;
}
