module;
#include <cstddef>
#include <cstdint>
#include <memory>
/// Ranks as MPI processes, and partitioning with PT-Scotch on them. The interface has no MPI types.
export module camber.mpi;
import camber.core;
import camber.distributed;

export namespace camber {

struct MpiOptions {
    /// Maximum size of a message in bytes, at most 2^31 − 1 in MPI. Larger data is sent in several messages.
    std::size_t largest_message = std::size_t{1} << 30U;
};

/// Initialises MPI; the destructor of the result finalises it. Call this function once in a process, on the thread that
/// exchanges messages. After a failed exchange, all later exchanges fail at once with the same error, so that the other
/// ranks stop too.
[[nodiscard]] std::unique_ptr<Ranks> mpi_ranks(int& argc, char**& argv, MpiOptions options = {});

/// Divides a graph with PT-Scotch into parts of equal size with few arcs between them, and returns the part (from 0) of
/// each vertex of this rank. All ranks must call it; the number of ranks affects the result. Errors, the same on all
/// ranks: unsupported (built without PT-Scotch, or its integers are too small), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts);

}  // namespace camber
