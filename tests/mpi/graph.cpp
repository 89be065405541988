// Partitions a square lattice that ranks store by rows with PT-Scotch: `mpirun -n N test_mpi_graph`.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

import camber.core;
import camber.distributed;
import camber.mpi;

namespace {

using namespace camber;

constexpr std::uint64_t side = 40;
constexpr std::size_t parts = 5;

void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", what);
    std::abort();
}

std::vector<std::uint64_t> neighbours_of(std::uint64_t point) {
    const std::uint64_t x = point % side, y = point / side;
    std::vector<std::uint64_t> all;
    if (y > 0) all.push_back(point - side);
    if (x > 0) all.push_back(point - 1);
    if (x + 1 < side) all.push_back(point + 1);
    if (y + 1 < side) all.push_back(point + side);
    return all;
}

GraphRun run_of(const Ranks& ranks) {
    GraphRun run;
    const std::uint64_t all = side * side;
    for (std::uint64_t p = all * ranks.rank() / ranks.size(); p < all * (ranks.rank() + 1) / ranks.size(); ++p) {
        for (const std::uint64_t q : neighbours_of(p)) run.neighbours.push_back(q);
        run.starts.push_back(run.neighbours.size());
    }
    return run;
}

}  // namespace

int main(int argc, char** argv) {
    const auto ranks = mpi_ranks(argc, argv);
    const GraphRun run = run_of(*ranks);
    const auto own = parts_of_graph(*ranks, run, parts);
    if (!own && own.error().kind == ErrorKind::unsupported) return EXIT_SUCCESS;
    require(own.has_value() && own->size() == run.size(), "each row of a rank has a part");
    const auto again = parts_of_graph(*ranks, run, parts);
    require(again && *again == *own, "the same parts come again");
    const auto all = gather_all<std::int32_t>(*ranks, std::vector<std::int32_t>(own->begin(), own->end()));
    require(all && all->size() == side * side, "all rows have parts");
    for (std::size_t part = 0; part < parts; ++part) {
        const auto size = std::ranges::count(*all, static_cast<std::int32_t>(part));
        require(size > 280 && size < 360, "parts are of about the same size");  // the mean size is 320
    }
    std::size_t between = 0;
    for (std::uint64_t p = 0; p < side * side; ++p)
        for (const std::uint64_t q : neighbours_of(p)) between += (*all)[p] != (*all)[q] ? 1 : 0;
    require(between < 600, "few arcs are between parts");  // of 6240 arcs
    return EXIT_SUCCESS;
}
