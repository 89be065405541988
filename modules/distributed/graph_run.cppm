module;
#include <cstddef>
#include <cstdint>
#include <functional>
export module camber.distributed:graph_run;
import camber.core;
import :ranks;

export namespace camber {

/// A rank's run of the rows of a graph, of elements and those across their faces say: the neighbours of its row i, by
/// their numbers in the whole, are neighbours[starts[i], starts[i + 1]). Runs follow each other in the order of the
/// ranks; whoever is a neighbour has a neighbour.
struct GraphRun {
    Buffer<std::uint64_t> starts = Buffer<std::uint64_t>(1, 0);
    Buffer<std::uint64_t> neighbours = {};

    [[nodiscard]] std::size_t size() const { return starts.size() - 1; }
};

/// The part, from 0, of each row of a rank, by a library that all ranks call.
using GraphPartitioner =
    std::function<Outcome<Buffer<std::int32_t>>(Ranks& ranks, const GraphRun& run, std::size_t parts)>;

}  // namespace camber
