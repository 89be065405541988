module;
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.distributed:region;
import camber.core;
import camber.metric;
import :part_state;
import :ringed_parts;
import :ranks;

namespace camber {

/// Some elements of a mesh in blocks with all within some rings around them, on one rank.
template <int D>
struct Region {
    QuadraticMesh<D> mesh;  ///< without facets; nodes as the parts have them
    std::vector<GlobalNumber> vertices, elements;
    Buffer<std::uint8_t> outer;  ///< vertices not all of whose elements are here
    Buffer<LogMetric<D>> log_metrics;
    Column<EdgeKind> kinds;
    Buffer<LagrangeNode<D>> extended, back_nodes;  ///< empty where the parts have none
};

/// Around these elements, of all ranks: regions that have no vertex in common, each on the rank that has the lowest of
/// its elements among these. Which regions there are does not depend on the ranks. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<std::vector<Region<D>>> regions_around(const RingedParts<D>& parts,
                                                             const std::vector<PartState<D>>& states,
                                                             const std::vector<GlobalNumber>& elements, int rings,
                                                             Ranks& ranks, const Execution& execution);

}  // namespace camber
