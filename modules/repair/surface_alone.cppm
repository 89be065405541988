module;
#include <vector>
module camber.repair:surface_alone;
import camber.core;
import camber.validity;
import :guide;
import :options;
import :repaired;
import :remaining;

namespace camber {

/// Whether nodes may leave the geometry, and how far they may go from where they are.
struct SurfaceLeave {
    bool may_leave = true;
    double most = 0;  ///< 0: a share of the chord alone
};

/// The triangles of a surface alone that are not good enough corrected, by the least change that helps, one after the
/// other, in turns:
///
/// 1. the node of one edge slides on the geometry (`guide.onto`): the coefficients of N · n are affine in one node, so
///    the least displacement in its tangent plane is a quadratic programme over those of the triangles beside it; then
///    the foot, and from there again;
/// 2. a node goes to the foot of its chord's middle;
/// 3. it leaves the geometry, by the least displacement in space;
/// 4. all nodes of the triangle go towards their chords by theta, until it holds; they return as far as they may.
///
/// No triangle that holds the bound ceases to. 3 and 4 leave the geometry, and are not for a recommended bound: where
/// none was asked for they are done for N · n > 0 alone. By `segment` and `relax` there is only 4.
[[nodiscard]] Outcome<Repaired<3>> repair_surface(const JudgedProposal<3>& wanted, const RepairGuide<3>& guide,
                                                  const RepairOptions& options, const SurfaceLeave& leave,
                                                  const Execution& execution);

/// The triangles that are not certified valid, and why, as far as that can be told.
[[nodiscard]] std::vector<RemainingElement> remaining_triangles(const Repaired<3>& repaired);

}  // namespace camber
