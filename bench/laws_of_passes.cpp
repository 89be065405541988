// What passes keep, counted: domains of two and three dimensions, twenty rounds of collapse, split, swap and smooth to
// metrics that are coarser and finer in turn, and after each round all that must hold (tests/support/many_rounds.hpp).
// Exit code 1: something was not kept. A program with arguments, not a timed test:
//
//     laws_of_passes [--cells 12] [--rounds 20] [--seed 1] [--threads 0]
//
// cells: along each axis, a multiple of 4; in two dimensions four times as many.
//
// Of a round: the size asked for, by that of the first mesh; what each pass did; the largest relative deviation of
// sizes (volumes of materials, areas, lengths): of what is flat, from the beginning, and of what is curved, from its
// formula; vertices that are not on their surface, since they went a part of their way only.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "many_rounds.hpp"
#include "named_domains.hpp"

import camber.core;
import camber.dynamic;
import camber.remesh;

using namespace camber;
using namespace camber::testing;

namespace {

struct Arguments {
    int cells = 12, rounds = 20, threads = 0;
    std::uint64_t seed = 1;
};

template <int D>
bool holds(NamedDomain<D> domain, const Arguments& a) {
    std::printf("%dD, %s\n%5s %5s %8s %8s |%8s %8s %8s %8s |%8s %8s %5s |%6s %7s\n", D, domain.name.c_str(), "round",
                "size", "vertices", "elements", "collapse", "split", "swap", "smooth", "flat", "curved", "off", "unit",
                "worst");
    ManyRounds<D> rounds(std::move(domain), a.seed, {.threads = a.threads});
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
    const std::span<char*> given(argv, static_cast<std::size_t>(argc));
    for (std::size_t i = 1; i < given.size(); i += 2) {
        const std::string_view word = given[i];
        const int number = static_cast<int>(i + 1 < given.size() ? std::strtod(given[i + 1], nullptr) : 0.0);
        if (word == "--cells" && number > 0 && number % 4 == 0) {
            a.cells = number;
        } else if (word == "--rounds") {
            a.rounds = number;
        } else if (word == "--seed") {
            a.seed = static_cast<std::uint64_t>(number);
        } else if (word == "--threads") {
            a.threads = number;
        } else {
            std::fprintf(stderr,
                         "laws_of_passes [--cells N] [--rounds N] [--seed N] [--threads N], cells a multiple of 4\n");
            return 2;
        }
    }
    bool all = true;
    try {
        for (NamedDomain<2>& domain : named_domains<2>(4 * a.cells)) all = holds(std::move(domain), a) && all;
        for (NamedDomain<3>& domain : named_domains<3>(a.cells)) all = holds(std::move(domain), a) && all;
    } catch (const std::exception& e) {
        std::printf("not kept: %s\n", e.what());
        return 1;
    }
    return all ? 0 : 1;
}
