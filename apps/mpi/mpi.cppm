module;
#include <cstddef>
#include <cstdint>
#include <memory>
/// Ranks that are processes of MPI, and what they do together by libraries over it. No type of MPI is in this
/// interface.
export module camber.mpi;
import camber.core;
import camber.distributed;

export namespace camber {

struct MpiOptions {
    /// Bytes of a message; what is larger goes in several. MPI counts them in 31 bits.
    std::size_t largest_message = std::size_t{1} << 30U;
};

/// Begins MPI, which ends with what is given: once in a process, and from the thread that asks it for exchanges. After
/// an error that all have got from one exchange, every other one gives that error at once, so that a rank which comes
/// to its end early, with an error, ends the others wherever they are.
[[nodiscard]] std::unique_ptr<Ranks> mpi_ranks(int& argc, char**& argv, MpiOptions options = {});

/// The part, from 0, of each row of this rank, by PT-Scotch: parts of about as many rows each, with few arcs between.
/// All ranks of `mpi_ranks` call it; another number of ranks may make other parts. Errors, on all ranks alike:
/// unsupported (Camber was built without PT-Scotch, or it numbers too few), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts);

}  // namespace camber
