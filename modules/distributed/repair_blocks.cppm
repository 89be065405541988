module;
#include <cstddef>
#include <vector>
module camber.distributed:repair_blocks;
import camber.core;
import camber.curving;
import camber.repair;
import :part_state;
import :ringed_parts;
import :ranks;
import :whole_surface;

namespace camber {

/// What is known of parts whose elements are to be repaired.
template <int D>
struct RepairedBlocks {
    RingedParts<D>& parts;
    std::vector<PartState<D>>& states;  ///< with the nodes that are wanted
    const WholeSurface<D>& surface;
    CurvingAim aim;
};

/// Elements that are not valid, and all within some rings around them, are brought together on one rank, which repairs
/// them as `curve_mesh` would; nodes and vertices that moved go back to all who have them. So many rings: as far as
/// repair ever looks. Errors: those of `repair`, of any rank.
template <int D>
[[nodiscard]] Outcome<RepairStatistics> repair_blocks(const RepairedBlocks<D>& of,
                                                      const std::vector<GlobalNumber>& not_valid,
                                                      const RepairOptions& options, Ranks& ranks,
                                                      const Execution& execution);

}  // namespace camber
