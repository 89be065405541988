module;
#include <cstddef>
#include <limits>
module camber.operation:curved_star;
import camber.core;
import camber.cavity;
import :operate;
import :state;
import :request;

/// The cavity operator of degree 2 (paper §3.2).
namespace camber {

inline constexpr std::size_t no_face = std::numeric_limits<std::size_t>::max();

/// What is wrong with a star, and at which joined face; no_face: at none of them.
struct StarFault {
    RejectionReason reason = RejectionReason::none;
    std::size_t joined = no_face;
};

/// Nodes for the edges of patch.star at its point, into patch.nodes, and what its elements are with them:
/// 1. Edges that elements or facets outside of the cavity have keep their nodes; those of the boundary have theirs on
///    the geometry; the others where the metric wants them (accurate_offsets).
/// 2. An element that is not valid to limits.min_jacobian, or no better than it may be, has its inner nodes drawn
///    towards the cavity's own curves as they were: the removed elements as a map from their straight shapes to their
///    curved ones, read at the middle of the new chord (THEORY: relaxing towards the extension). Half of the way, then
///    all of it. Where nothing bends and nothing else moves, an edge that is split has exactly its halves there.
/// 3. Where elements are still not valid: one inner edge of them after the other goes where the least Jacobian around
/// it
///    is largest, a linear programme (see highest_node), at most limits.programmes of them.
/// 4. Edges along their curves within the bounds of lengths.
/// `worst`: the least shape of the new elements, where there is no fault.
template <int D>
[[nodiscard]] StarFault curve_star(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                                   const PatchLimits& limits, OperationWorkspace<D>& workspace, Patch<D>& patch,
                                   double& worst);

}  // namespace camber
