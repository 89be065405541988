module;
#include <cstddef>
#include <cstdint>
#include <memory>
/// Ranks that are MPI processes, and PT-Scotch on them. The interface has no MPI types.
export module camber.mpi;
import camber.core;
import camber.distributed;

export namespace camber {

struct MpiOptions {
    /// Maximum bytes of a message, at most 2^31 − 1 in MPI; larger data is sent in several messages.
    std::size_t largest_message = std::size_t{1} << 30U;
};

/// Initialises MPI; the destructor of the result finalises it. Call it once in a process, on the thread that exchanges
/// messages. After a failed exchange all later ones fail at once with the same error, which stops the other ranks.
[[nodiscard]] std::unique_ptr<Ranks> mpi_ranks(int& argc, char**& argv, MpiOptions options = {});

/// Computes with PT-Scotch the part (from 0) of each graph vertex of this rank: parts of equal size with few arcs
/// between them. All ranks must call it; the number of ranks affects the result. Errors, the same on all ranks:
/// unsupported (built without PT-Scotch, or its integers are too small), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts);

}  // namespace camber
