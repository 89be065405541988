module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
export module camber.operation:operate;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import :curved_workspace;
import :judged_patch;
import :state;
import :request;

export namespace camber {

/// The cavity operator, of degree 1 (paper §1.3) and 2 (§3.2): a cavity and a point, joined, judged, corrected where
/// that helps.

template <int D>
struct OperationWorkspace {
    StarWorkspace<D> star;
    Cavity<D> cavity;
    std::vector<std::size_t> pieces;                 ///< of the cavity's facets
    std::vector<double> shapes;                      ///< of the star's elements, as far as they were judged
    std::vector<std::size_t> faulty, faulty_before;  ///< of them, by the last fault, and before nodes were corrected
    CurvedWorkspace<D> curved;
};

/// What came of a request.
struct OperationResult {
    RejectionReason rejected = RejectionReason::none;
    bool is_planned = true;  ///< false: the candidate was rejected before
    double worst_shape = 0;  ///< of the new elements, where nothing is rejected
    int corrections = 0;
    /// Of degree 2: what the test of degree 1 says of the same star: that an element has no volume, or that all have
    /// one. And whether nodes were drawn back from where the metric has them.
    int programmes = 0;         ///< spent
    double farthest_facet = 0;  ///< see PassStatistics
    bool straight_inverted = false, straight_positive = false, drawn_back = false;
    bool bends_around = false;  ///< nodes around the cavity follow
};

/// The way of a request: its star, the star's nodes by the degree, the judge, corrections; what is good enough in the
/// end is `out`, which means something only where nothing is rejected. The state is as it was in any case. Signs of
/// volumes are exact; in a mesh of degree 2 straight elements may be as they like (see CurvedNodes). Where an element
/// would be inverted or bad, the one that it comes of leaves the cavity if it may (see `holders`), and of
/// degree 2, which looks at all, with it the others of which that is so: no other change would mend them; otherwise the
/// one across its outer face joins it: up to `corrections` times.
template <int D>
[[nodiscard]] OperationResult operate(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                      const CavityRequest<D>& request, const PatchLimits& limits,
                                      OperationWorkspace<D>& workspace, JudgedPatch<D>& out);

}  // namespace camber
