module;
#include <cstddef>
#include <cstdint>
export module camber.mpi:graph;
import camber.core;
import camber.distributed;

export namespace camber {

/// A rank's run of the rows of a graph, of elements and those across their faces say: the neighbours of its row i, by
/// their numbers in the whole, are neighbours[starts[i], starts[i + 1]). Runs follow each other in the order of the
/// ranks; whoever is a neighbour has a neighbour.
struct GraphRun {
    Buffer<std::uint64_t> starts = Buffer<std::uint64_t>(1, 0);
    Buffer<std::uint64_t> neighbours = {};

    [[nodiscard]] std::size_t size() const { return starts.size() - 1; }
};

/// The part, from 0, of each row of this rank, by PT-Scotch: parts of about as many rows each, with few arcs between.
/// All ranks of `mpi_ranks` call it; another number of ranks may make other parts. Errors, on all ranks alike:
/// unsupported (Camber was built without PT-Scotch, or it numbers too few), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& ranks, const GraphRun& run, std::size_t parts);

}  // namespace camber
