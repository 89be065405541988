module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.distributed:dual_graph_rows;
import camber.core;
import :graph_run;
import :ranks;
import :runs_of_rank;

namespace camber {

/// Of n rows that ranks share in runs (`part_of`): whose a row is.
[[nodiscard]] inline std::size_t rank_of_row(std::uint64_t row, std::size_t n, std::size_t ranks) {
    std::size_t r = row * ranks / n;
    while (r + 1 < ranks && n * (r + 1) / ranks <= row) ++r;
    while (n * r / ranks > row) --r;
    return r;
}

/// A facet on its way: its row, and the lowest element that it bounds (none: `no_element`).
inline constexpr std::uint64_t no_element = ~std::uint64_t{0};
template <int D>
struct FacetRow {
    std::uint64_t row = 0;
    SimplexVertices<D - 1> vertices{};
    Reference reference = 0;
    std::uint32_t padding = 0;
    std::uint64_t element = no_element;
};

/// The rank's run of the graph of elements across faces, and the facets whose lowest vertex is of its run of vertices.
template <int D>
struct DualRows {
    GraphRun graph;
    std::vector<FacetRow<D>> facets;
};

/// Of what a rank has runs of, its first element being row `first`. Errors, of any rank: input (more than two elements
/// on a face).
template <int D>
[[nodiscard]] Outcome<DualRows<D>> dual_rows(const RunsOfRank<D>& runs, std::size_t first, Ranks& ranks);

}  // namespace camber
