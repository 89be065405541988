module;
#include <cstddef>
#include <memory>
export module camber.mpi:ranks;
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

}  // namespace camber
