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

/// Elements that are not valid, and all within some rings around them, are brought together by places, each on the rank
/// that has the lowest of its elements, which repairs it as `curve_mesh` would a mesh of its own; nodes and vertices
/// that moved go back to all who have them. So many rings: as far as repair ever looks. What this rank has repaired.
/// Errors: those of `repair`, of any rank.
template <int D>
[[nodiscard]] Outcome<RepairStatistics> repair_blocks(const RepairedBlocks<D>& of,
                                                      const std::vector<GlobalNumber>& not_valid,
                                                      const RepairOptions& options, Ranks& ranks,
                                                      const Execution& execution);

/// Of several places, all of whose elements are others.
inline void add_up(RepairStatistics& sum, const RepairStatistics& place) {
    sum.corrected_elements += place.corrected_elements;
    sum.moved_volume_nodes += place.moved_volume_nodes;
    sum.moved_surface_nodes += place.moved_surface_nodes;
    sum.moved_vertices += place.moved_vertices;
    sum.work += place.work;
    sum.by_edges += place.by_edges;
    sum.by_cavities += place.by_cavities;
    sum.by_extension += place.by_extension;
    sum.by_vertices += place.by_vertices;
    sum.by_slides += place.by_slides;
    sum.by_surface += place.by_surface;
}

}  // namespace camber
