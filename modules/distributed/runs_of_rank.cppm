module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>
module camber.distributed:runs_of_rank;
import camber.core;
import :row_runs;
import :rows;

namespace camber {

/// What a rank begins with of a mesh that ranks bring into parts: its run (`part_of`) of the elements and of the
/// facets; all feature edges, which are few, and all lists.
template <int D>
struct RunsOfRank {
    RowCounts counts;
    SimplexRows<D> elements;
    SimplexRows<D - 1> facets;
    SimplexRows<1> edges;
    LinearMesh<D> lists;
};

/// The points of these numbers, which rise; all ranks ask at once.
template <int D>
using PointsAt = std::function<Outcome<PointRows<D>>(const std::vector<std::uint64_t>&)>;

/// A vertex as one rank tells it another.
template <int D>
struct PointRow {
    Vec<D> point;
    Reference reference = 0;
};
template <int D>
[[nodiscard]] PointRows<D> point_rows(const std::vector<PointRow<D>>& told) {
    PointRows<D> rows;
    for (const PointRow<D>& row : told) {
        rows.points.push_back(row.point);
        rows.references.push_back(row.reference);
    }
    return rows;
}

/// Rows of some numbers, which rise, read by runs that leave few out: take(i, rows, place of numbers[i] in them).
template <class Read, class Take>
[[nodiscard]] Outcome<Done> read_some(const std::vector<std::uint64_t>& numbers, const Read& read, const Take& take) {
    constexpr std::uint64_t gap = 64;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i + 1;
        while (end < numbers.size() && end - i < chunk_rows && numbers[end] < numbers[end - 1] + gap) ++end;
        const auto some = read(numbers[i], numbers[end - 1] + 1);
        if (!some) return fail(some.error());
        const std::uint64_t first = numbers[i];
        for (; i < end; ++i) take(i, *some, static_cast<std::size_t>(numbers[i] - first));
    }
    return Done{};
}

}  // namespace camber
