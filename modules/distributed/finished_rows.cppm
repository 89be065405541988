module;
#include <cstddef>
#include <vector>
export module camber.distributed:finished_rows;
import camber.core;
import camber.io;
import :adaptation_rows;
import :ranks;
import :shared_rows;

export namespace camber {

/// What a mesh had of its maker, beside its rows: at vertices, by their numbers when all began.
template <int D>
struct GivenOfMesh {
    std::size_t vertices = 0;
    GivenGeometry<D> geometry;
    Column<Group> groups;
};

/// A mesh that was remeshed, shared among ranks, as the rows of its file: as `finished` has them of a mesh as a whole.
template <int D>
struct FinishedRows {
    FilePart<D, 1> part;  ///< this rank's rows
    PartTotals totals;
    LinearMesh<D> lists;  ///< what is said beside the rows: on all ranks
};
/// Errors: memory, of any rank.
template <int D>
[[nodiscard]] Outcome<FinishedRows<D>> finished_rows(SharedRows<D> shared, const GivenOfMesh<D>& given, Ranks& ranks);

/// Of a shared mesh the lengths of edges in the metric, each on one rank, and the qualities of elements there. Errors:
/// memory, stopped, of any rank.
struct MeasuredRows {
    std::vector<double> lengths, qualities;
};
template <int D>
[[nodiscard]] Outcome<MeasuredRows> measured_rows(const SharedRows<D>& shared, Ranks& ranks,
                                                  const Execution& execution);

}  // namespace camber
