// Property tests of MPI ranks: `mpirun -n N test_mpi_ranks`.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.distributed;
import camber.mpi;

namespace {

using camber::Bytes;
using camber::Outcome;

/// Ends all ranks with the sentence that does not hold.
void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", what);
    std::abort();
}

/// The values that rank `from` sends to rank `to`: none, few, or more than one message holds.
std::vector<std::uint32_t> values_of(std::size_t from, std::size_t to) {
    std::vector<std::uint32_t> values((from * 7 + to * 3) % 4 * 500);
    std::iota(values.begin(), values.end(), static_cast<std::uint32_t>(100000 * from + 1000 * to));
    return values;
}

std::vector<Bytes> messages(const camber::Ranks& ranks) {
    std::vector<Bytes> to;
    for (std::size_t r = 0; r < ranks.size(); ++r)
        to.push_back(camber::bytes_of<std::uint32_t>(values_of(ranks.rank(), r)));
    return to;
}

void each_gets_what_the_others_gave(camber::Ranks& ranks) {
    for (int round = 0; round < 3; ++round) {
        const auto from = ranks.exchange(messages(ranks));
        require(from.has_value(), "an exchange succeeds");
        require(from->size() == ranks.size(), "there is a message of each rank");
        for (std::size_t r = 0; r < ranks.size(); ++r)
            require((*from)[r] == camber::bytes_of<std::uint32_t>(values_of(r, ranks.rank())),
                    "it is what that one gave");
    }
    std::size_t bytes = 0;
    for (std::size_t r = 0; r < ranks.size(); ++r)
        if (r != ranks.rank()) bytes += 3 * 4 * values_of(ranks.rank(), r).size();
    require(ranks.traffic().bytes == bytes, "bytes to others are counted, and none to itself");
    require(ranks.traffic().rounds == 3, "rounds are counted");
}

void all_have_the_values_of_all(camber::Ranks& ranks) {
    const std::vector<std::uint64_t> own(ranks.rank() + 1, ranks.rank());
    const auto all = camber::gather_all<std::uint64_t>(ranks, own);
    require(all && all->size() == ranks.size() * (ranks.size() + 1) / 2, "all ranks' values are there");
    require(std::ranges::is_sorted(*all), "in the order of the ranks");
}

/// Must be last: an error ends all exchanges.
void all_get_the_error_of_the_lowest_rank(camber::Ranks& ranks) {
    const std::size_t lowest = ranks.size() / 2;
    Outcome<std::vector<Bytes>> to = messages(ranks);
    if (ranks.rank() >= lowest)
        to = camber::fail(camber::ErrorKind::input, "is damaged", "rank " + std::to_string(ranks.rank()),
                          camber::Entity{"tetrahedron", std::uint64_t{1} << 40U}, "write it again");
    for (int again = 0; again < 2; ++again) {
        const auto from = ranks.exchange(to);
        require(!from, "an exchange with a failing rank fails on all");
        require(camber::describe(from.error()) ==
                    "rank " + std::to_string(lowest) + ": tetrahedron 1099511627776: is damaged (write it again)",
                "with that rank's error, whole; and so do those after it");
        require(from.error().kind == camber::ErrorKind::input, "and its kind");
        to = messages(ranks);
    }
}

}  // namespace

int main(int argc, char** argv) {
    const auto ranks = camber::mpi_ranks(argc, argv, {.largest_message = 1000});
    each_gets_what_the_others_gave(*ranks);
    all_have_the_values_of_all(*ranks);
    all_get_the_error_of_the_lowest_rank(*ranks);
    return EXIT_SUCCESS;
}
