module;
#include <cstddef>
module camber.distributed:parts_of_runs;
import camber.core;
import :graph_run;
import :partition_rows;
import :ranks;
import :rows;
import :runs_of_rank;

namespace camber {

/// What this rank reads of rows.
template <int D>
[[nodiscard]] Outcome<RunsOfRank<D>> runs_of(const MeshRows<D>& rows, const Ranks& ranks);

/// Parts of what ranks have runs of, see parts_of_rows; what a rank could not read is the error of all.
template <int D>
[[nodiscard]] Outcome<PartsOfRank<LinearMesh<D>>> parts_of_runs(const Outcome<RunsOfRank<D>>& runs,
                                                                const PointsAt<D>& points_at, std::size_t parts,
                                                                const GraphPartitioner& partition, Ranks& ranks);

}  // namespace camber
