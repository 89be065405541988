module;
#include <cstdio>
// Needed by scotch.h and ptscotch.h, which use FILE.
#include <mpi.h>
#include <scotch.h>
// ptscotch.h requires that scotch.h is included before.
#include <ptscotch.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
module camber.mpi;
import camber.core;
import camber.distributed;

namespace camber {

namespace {

constexpr int done = 0;

/// A separate communicator, so that Scotch's messages are not mixed with others.
struct Communicator {
    Communicator() { MPI_Comm_dup(MPI_COMM_WORLD, &own); }
    Communicator(const Communicator&) = delete;
    Communicator(Communicator&&) = delete;
    Communicator& operator=(const Communicator&) = delete;
    Communicator& operator=(Communicator&&) = delete;
    ~Communicator() { MPI_Comm_free(&own); }
    MPI_Comm own = MPI_COMM_NULL;
};

struct Graph {
    explicit Graph(MPI_Comm ranks) : is_valid(SCOTCH_dgraphInit(&own, ranks) == done) {}
    Graph(const Graph&) = delete;
    Graph(Graph&&) = delete;
    Graph& operator=(const Graph&) = delete;
    Graph& operator=(Graph&&) = delete;
    ~Graph() {
        if (is_valid) SCOTCH_dgraphExit(&own);
    }
    SCOTCH_Dgraph own{};
    bool is_valid;
};

struct Strategy {
    Strategy() : is_valid(SCOTCH_stratInit(&own) == done) {}
    Strategy(const Strategy&) = delete;
    Strategy(Strategy&&) = delete;
    Strategy& operator=(const Strategy&) = delete;
    Strategy& operator=(Strategy&&) = delete;
    ~Strategy() {
        if (is_valid) SCOTCH_stratExit(&own);
    }
    SCOTCH_Strat own{};
    bool is_valid;
};

/// One thread and a fixed seed make the result reproducible.
struct Context {
    Context()
        : is_valid(SCOTCH_contextInit(&own) == done &&
                   SCOTCH_contextOptionSetNum(&own, SCOTCH_OPTIONNUMDETERMINISTIC, 1) == done &&
                   SCOTCH_contextOptionSetNum(&own, SCOTCH_OPTIONNUMRANDOMFIXEDSEED, 1) == done &&
                   SCOTCH_contextRandomClone(&own) == done && SCOTCH_contextThreadSpawn(&own, 1, nullptr) == done) {
        if (!is_valid) return;
        SCOTCH_contextRandomSeed(&own, 1);
        SCOTCH_contextRandomReset(&own);
    }
    Context(const Context&) = delete;
    Context(Context&&) = delete;
    Context& operator=(const Context&) = delete;
    Context& operator=(Context&&) = delete;
    ~Context() { SCOTCH_contextExit(&own); }
    SCOTCH_Context own{};
    bool is_valid;
};

struct Arrays {
    Buffer<SCOTCH_Num> starts, neighbours, part;
};

Outcome<Arrays> arrays_of(const GraphRun& run) {
    return guarded([&]() -> Outcome<Arrays> {
        constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<SCOTCH_Num>::max());
        const auto too_many = [](std::uint64_t n) { return n >= most; };
        if (too_many(run.size()) || too_many(run.neighbours.size()) || std::ranges::any_of(run.neighbours, too_many))
            return fail(ErrorKind::unsupported, "the mesh has more elements than PT-Scotch can number", {}, {},
                        "build with one of 64-bit integers");
        return Arrays{Buffer<SCOTCH_Num>(run.starts.begin(), run.starts.end()),
                      Buffer<SCOTCH_Num>(run.neighbours.begin(), run.neighbours.end()),
                      Buffer<SCOTCH_Num>(std::max<std::size_t>(run.size(), 1))};
    });
}

auto failed() { return fail(ErrorKind::internal, "PT-Scotch could not partition the mesh"); }

}  // namespace

Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts) {
    auto arrays = arrays_of(run);
    if (auto all = agreed(ranks, arrays ? Outcome<Done>(Done{}) : fail(arrays.error())); !all) return fail(all.error());
    const Communicator communicator;
    Context context;
    Graph graph(communicator.own), bound(communicator.own);
    Strategy strategy;
    const auto rows = static_cast<SCOTCH_Num>(run.size()), arcs = static_cast<SCOTCH_Num>(arrays->neighbours.size());
    const bool result = context.is_valid && graph.is_valid && bound.is_valid && strategy.is_valid &&
                        SCOTCH_dgraphBuild(&graph.own, 0, rows, rows, arrays->starts.data(), nullptr, nullptr, nullptr,
                                           arcs, arcs, arrays->neighbours.data(), nullptr, nullptr) == done &&
                        SCOTCH_contextBindDgraph(&context.own, &graph.own, &bound.own) == done;
    if (auto all = agreed(ranks, result ? Outcome<Done>(Done{}) : failed()); !all) return fail(all.error());
    const bool parted =
        SCOTCH_dgraphPart(&bound.own, static_cast<SCOTCH_Num>(parts), &strategy.own, arrays->part.data()) == done;
    if (auto all = agreed(ranks, parted ? Outcome<Done>(Done{}) : failed()); !all) return fail(all.error());
    return Buffer<std::int32_t>(arrays->part.begin(), arrays->part.begin() + static_cast<std::ptrdiff_t>(run.size()));
}

}  // namespace camber
