module;
#include <cstddef>
module camber.distributed:row_runs;

namespace camber {

/// Some rows, one after the other: of those of a kind what a rank reads, or a chunk of it.
struct Run {
    std::size_t begin = 0, end = 0;
    [[nodiscard]] std::size_t size() const { return end - begin; }
};
[[nodiscard]] inline Run part_of(Run run, std::size_t part, std::size_t parts) {
    return {run.begin + run.size() * part / parts, run.begin + run.size() * (part + 1) / parts};
}

/// Rows are read in chunks, so that what is on its way is little beside what is there.
inline constexpr std::size_t chunk_rows = std::size_t{1} << 20U;

}  // namespace camber
