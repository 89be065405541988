// Writes one of the domains of tests/support/named_domains.hpp to a file:
//
//     domain ball|quarter|baffle CELLS OUT
//
// ball: a ball of radius 1 in a box from -2 to 2, each with its material. CELLS: number of cells along each axis; for
// the ball a multiple of 4.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "named_domains.hpp"

import camber.core;
import camber.cavity;
import camber.io;
import camber.surface;

#include "mesh_files.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

NamedDomain<3> domain(std::string_view name, int cells) {
    if (name == "ball") return ball_in_box<3>(cells);
    if (name == "quarter") return quarter_shell<3>(cells);
    return baffle_in_box<3>(cells);
}

}  // namespace

int main(int count, char** words) {
    if (count != 4) return std::fprintf(stderr, "domain ball|quarter|baffle CELLS OUT\n"), 2;
    bench::write_mesh(words[3], as_mesh(domain(words[1], static_cast<int>(std::strtod(words[2], nullptr))).mesh));
    return 0;
}
