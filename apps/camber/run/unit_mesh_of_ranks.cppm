module;
#include <string>
#include <vector>
module camber.run:unit_mesh_of_ranks;
import camber.core;
import camber.distributed;
import :histogram;
import :report;

namespace camber::run {

/// Of a mesh that ranks share: as of one as a whole, but for the last digits of means, which are summed rank by rank.
struct UnitMeshOfRanks {
    UnitMeshReport report;
    std::vector<Histogram> histograms;
};
/// Errors: of any rank.
[[nodiscard]] Outcome<UnitMeshOfRanks> unit_mesh_of_ranks(std::string metric, const MeasuredRows& own, Ranks& ranks);

}  // namespace camber::run
