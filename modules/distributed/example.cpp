// A single process is the only rank, and receives its own messages.
#include <cstdio>
#include <cstdlib>
#include <vector>

import camber.core;
import camber.distributed;

int main() {
    const auto ranks = camber::one_rank();
    const auto all = camber::gather_all(*ranks, camber::Outcome<std::vector<int>>({1, 2, 3}));
    if (!all || all->size() != 3) return EXIT_FAILURE;
    std::printf("%zu of %zu ranks, %zu values\n", ranks->rank() + 1, ranks->size(), all->size());
    return EXIT_SUCCESS;
}
