module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
export module camber.remesh:plan;
import camber.core;
import camber.metric;
import camber.dynamic;
import camber.surface;
import :curved_workspace;
import :state;
import :wish;

export namespace camber {

/// The cavity operator, of degree 1 (paper §1.3) and 2 (§3.2): a cavity and a point, joined, judged, corrected where
/// that helps.

template <int D>
struct PlanWorkspace {
    StarWorkspace<D> star;
    CavityParts<D> cavity;
    std::vector<std::size_t> pieces;  ///< of the cavity's facets
    CurvedWorkspace<D> curved;
};

/// What came of a wish.
struct PlanResult {
    RejectionReason rejected = RejectionReason::none;
    double worst_shape = 0;  ///< of the new elements, where nothing is rejected
    int corrections = 0;
    /// Of degree 2: what the test of degree 1 says of the same star: that an element has no volume, or that all have
    /// one. And whether nodes were drawn back from where the metric has them.
    int programmes = 0;  ///< spent
    bool straight_inverted = false, straight_positive = false, drawn_back = false;
};

/// Joins and judges: the signs of volumes are exact. In a mesh of degree 2 the star is curved too (see curve_star), and
/// its straight elements may be as they like. `out` means something only where nothing is rejected; the mesh is
/// as it was in any case. Where an element would be inverted or bad, the one that it comes of leaves the cavity if it
/// may (see `holders`), otherwise the one across its outer face joins it: up to `corrections` times.
template <int D>
[[nodiscard]] PlanResult plan(const Remeshing<D>& r, const RemeshingGoal<D>& goal, const CavityWish<D>& wish,
                              const PatchLimits& limits, PlanWorkspace<D>& workspace, TopologyPatch<D>& out);

}  // namespace camber
