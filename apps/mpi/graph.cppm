module;
#include <cstddef>
#include <cstdint>
export module camber.mpi:graph;
import camber.core;
import camber.distributed;

export namespace camber {

/// The part, from 0, of each row of this rank, by PT-Scotch: parts of about as many rows each, with few arcs between.
/// All ranks of `mpi_ranks` call it; another number of ranks may make other parts. Errors, on all ranks alike:
/// unsupported (Camber was built without PT-Scotch, or it numbers too few), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts);

}  // namespace camber
