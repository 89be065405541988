module;
#include <cstddef>
#include <cstdint>
#include <memory>
/// MPI processes as ranks, and libraries on them. The interface has no MPI types.
export module camber.mpi;
import camber.core;
import camber.distributed;

export namespace camber {

struct MpiOptions {
    /// Bytes, which MPI counts in 31 bits; larger messages are divided.
    std::size_t largest_message = std::size_t{1} << 30U;
};

/// Initialises MPI; the result's destructor ends it. Once for each process, on the thread of the exchanges. After a
/// failed exchange every later one fails at once with the same error, which stops the other ranks.
[[nodiscard]] std::unique_ptr<Ranks> mpi_ranks(int& argc, char**& argv, MpiOptions options = {});

/// Part (from 0) of each row of this rank by PT-Scotch: equal parts, few arcs between them. All ranks must call it;
/// their number affects the result. Errors, the same on all ranks: unsupported (built without PT-Scotch, or it numbers
/// too few), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts);

}  // namespace camber
