module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>
module camber.operation:curved_nodes;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.optimisation;
import :geometry;
import :operate;
import :state;

namespace camber {

inline constexpr std::size_t no_face = std::numeric_limits<std::size_t>::max();

/// A fault of a star, and the index in `Star::joined` of the faulty element's face, or `no_face`.
struct StarDefect {
    RejectionReason reason = RejectionReason::none;
    std::size_t joined = no_face;
    double worst_shape = std::numeric_limits<double>::infinity();  ///< lowest quality of an element, if there is no
                                                                   ///< fault
};

struct ElementState {
    bool is_valid = false, is_flat = false;
    double shape = 0;           ///< quality of a valid element
    bool is_tolerated = false;  ///< the element may be invalid, like the removed one
};

/// True if the lengths of edges that the request creates or moves are within the limits, as far as their nodes are
/// placed.
template <class ToPoint, class Nodes>
[[nodiscard]] bool lengths_fit(std::span<const ToPoint> to_point, bool point_moves, const PatchLimits& limits,
                               const Nodes& nodes) {
    for (std::size_t s = 0; s < to_point.size(); ++s) {
        if (to_point[s].is_present && !point_moves) continue;  // the edge exists and does not change
        if (!nodes.is_placed(s)) continue;
        const double length = nodes.length_to(s);
        if (!(length >= limits.shortest && length <= limits.longest)) return false;
    }
    return true;
}

/// Returns the element's first fault in the order `volume`, `height`, `quality`, or `none`.
template <int D>
[[nodiscard]] RejectionReason rejection_of(const ElementState& e, QualityCriterion<D>& bar) {
    if (e.is_tolerated) return RejectionReason::none;
    if (!e.is_valid) return RejectionReason::volume;
    if (e.is_flat) return RejectionReason::height;
    return bar.is_met(e.shape) ? RejectionReason::none : RejectionReason::quality;
}

/// Returns the most serious defect, or the first if `is_judged_by_element`. `defective`: indices of checked elements
/// with this defect. `shapes`: qualities of the elements, complete only without a defect.
template <int D, class Nodes>
[[nodiscard]] StarDefect find_defects(std::size_t elements, const Nodes& nodes, QualityCriterion<D>& bar,
                                      std::vector<std::size_t>& defective, std::vector<double>& shapes) {
    shapes.clear();
    defective.clear();
    StarDefect found;
    const auto rank = [](RejectionReason reason) {
        return reason == RejectionReason::volume ? 0 : reason == RejectionReason::height ? 1 : 2;
    };
    const auto add = [&](RejectionReason reason, std::size_t j) {
        if (found.reason == RejectionReason::none || rank(reason) < rank(found.reason)) {
            found = {reason, j};
            defective.clear();
        }
        if (rank(reason) == rank(found.reason)) defective.push_back(j);
    };
    if constexpr (!Nodes::is_judged_by_element) {  // validity is checked first: it needs no qualities
        for (std::size_t j = 0; j < elements; ++j)
            if (nodes.is_broken(j)) add(RejectionReason::volume, j);
        if (!defective.empty()) return found;
    }
    for (std::size_t j = 0; j < elements; ++j) {
        const ElementState element = nodes.element(j);
        if (const RejectionReason reason = rejection_of(element, bar); reason != RejectionReason::none) {
            add(reason, j);
            if (Nodes::is_judged_by_element) return found;
            continue;
        }
        shapes.push_back(element.shape);
        if (found.reason == RejectionReason::none) found.worst_shape = std::min(found.worst_shape, element.shape);
    }
    return found;
}

template <int D>
struct JudgedRequest {
    const Adaptation<D>& mesh;
    const AdaptationGoal<D>& goal;
    const CavityRequest<D>& request;
    const PatchLimits& limits;
};

// Nodes of a quadratic star (paper §3.2).

/// Computes the nodes of the edges from the point of `patch.star` to its boundary (`patch.nodes`) in steps:
/// 1. Edges shared with elements or facets outside of the cavity keep their nodes. Boundary nodes lie on the geometry.
///    The metric determines the other nodes (`accurate_offsets`).
/// 2. Elements below `limits.min_jacobian` or of too low quality have their inner nodes relaxed to the old curves, half
///    of the way, then fully. The removed elements map the middle of the new chord to the old curves, from straight to
///    curved shapes. If nothing else bends or moves, the halves of a split edge reproduce it.
/// 3. If elements are still invalid, their inner nodes move one by one to maximise the smallest Jacobian around the
///    edge, by at most `limits.optimisation_problems` linear programs (`max_min_node`).
/// 4. If that fails, one problem moves all inner nodes. A second one also moves at most `limits.bend_around` nodes on
///    the invalid elements' outer faces, and checks the elements outside with these edges.
/// 5. Lengths along the curves must be within the limits.
template <int D>
class CurvedNodes {
  public:
    CurvedNodes(const JudgedRequest<D>& judged, OperationWorkspace<D>& workspace, Patch<D>& patch,
                QualityCriterion<D>& bar)
        : r_(judged.mesh),
          goal_(judged.goal),
          request_(judged.request),
          limits_(judged.limits),
          star_(workspace.star),
          w_(workspace.curved),
          out_(patch),
          bar_(bar) {}

    static constexpr int degree = 2;
    /// False: all elements are checked, for validity first.
    static constexpr bool is_judged_by_element = false;

    /// Computes the nodes of inner edges, which is cheap.
    void place_inner();
    /// Computes the nodes of all other edges. Returns true if there are any.
    bool place_others();
    [[nodiscard]] bool is_placed(std::size_t spoke) const { return are_all_placed_ || is_free(spoke); }
    [[nodiscard]] double length_to(std::size_t spoke) const;
    void begin_elements();
    void judge_elements();
    [[nodiscard]] bool is_broken(std::size_t joined) const;
    [[nodiscard]] ElementState element(std::size_t joined) const;
    /// Moves nodes to correct a fault; false if no node moved.
    [[nodiscard]] bool correct(RejectionReason reason);
    /// Moves relaxed nodes together towards their targets if the elements stay valid and good enough.
    void approach();
    void set_edges(Patch<D>& patch) const;
    [[nodiscard]] int optimisation_problems() const { return w_.optimisation_problems; }
    [[nodiscard]] bool has_relaxed() const {
        return std::ranges::any_of(w_.spokes, [](const Spoke<D>& s) { return s.share < 1; });
    }

  private:
    [[nodiscard]] VertexId vertex(std::size_t spoke) const { return out_.star.boundary[spoke]; }
    [[nodiscard]] const Vec<D>& end(std::size_t spoke) const { return r_.mesh.points[vertex(spoke)]; }
    [[nodiscard]] Vec<D> middle(std::size_t spoke) const { return midpoint(request_.place, end(spoke)); }

    void begin_spokes();
    /// Maps `p`, the origin or a point between the origin and `v`, to the old curves. Uses the largest removed element
    /// at the point with vertex `v` (if valid), since smaller elements may be almost flat. If there is none, uses the
    /// nearest element.
    [[nodiscard]] Vec<D> old_place_of(const Vec<D>& p, VertexId v) const;
    /// The cavity's edge to `v`; invalid if there is none.
    [[nodiscard]] EdgeId target_edge(VertexId v) const;
    /// The node of the cavity's edge to `v`, if the point does not move.
    [[nodiscard]] std::optional<Vec<D>> old_edge_node(const Vec<D>& origin, VertexId v) const;
    /// Computes the spoke's `extended`: a position on the old curves plus half of the point's offset from them.
    void extend(std::size_t spoke);
    /// Maps `p` by removed facets (on a line: edges). Maps of elements would leave the surface where straight elements
    /// are inverted.
    [[nodiscard]] Vec<D> old_place_on_sides(std::size_t s, const Vec<D>& p) const;
    void put_on_geometry();
    /// Empty if the spoke has no surface and is not on an embedded line.
    [[nodiscard]] std::optional<Vec<D>> target_on_geometry(std::size_t s) const;
    void place_targets();
    void take_targets();
    /// Reuses edges that are bent already: their nodes do not depend on the cavity.
    void take_bent(const std::vector<BentSpoke<D>>& bent);
    void put_bent(std::size_t spoke, const Vec<D>& offset, double length);
    void bend_free();
    void search_free();

    void begin_cones();
    void put_nodes(Cone<D>& cone) const;
    void refresh_stale();
    void decide_cone(Cone<D>& cone, const JacobianSummary& jacobian) const;
    [[nodiscard]] double shape_of_cone(Cone<D>& cone) const;
    [[nodiscard]] bool replaces_worse_where_invalid() const;
    /// True if det J may fall below `rounding_floor`, the limit for linear elements.
    [[nodiscard]] bool is_flat(const NodalSimplex<D>& element, const JacobianSummary& jacobian) const;
    /// True if the limits allow invalid elements to stay, and the removed element with the same vertices is invalid.
    [[nodiscard]] bool may_stay_invalid(std::size_t joined) const;
    [[nodiscard]] bool is_good(Cone<D>& cone);
    [[nodiscard]] bool replaces_worse() const;
    /// Relaxes the nodes of faulty elements by one step; false if none can relax further.
    [[nodiscard]] bool draw_back(RejectionReason reason);
    void mark_stale();
    /// True for inner edges, except the halves of a split edge: they preserve the curve.
    [[nodiscard]] bool is_free(std::size_t s) const {
        return w_.spokes[s].kind == EdgeKind::volume && vertex(s) != request_.halves[0] &&
               vertex(s) != request_.halves[1];
    }
    /// True if the removed element may leave the cavity, which is cheaper than a linear program.
    [[nodiscard]] bool may_leave(std::ptrdiff_t joined) const;
    /// Solves linear programs; true if all elements become valid.
    [[nodiscard]] bool raise();
    /// Moves all inner nodes together, and at most `rim` nodes of outer faces; false if that fails.
    [[nodiscard]] bool bend_together();
    [[nodiscard]] bool bend_together(int rim);
    void gather_rim(int rim);
    /// Adds an element outside; false if it violates `lowest_jacobian`.
    [[nodiscard]] bool gather_outside(ElementId e);
    [[nodiscard]] Vec<D> target_node_of(EdgeId edge) const;
    [[nodiscard]] JointProblem<D> bending_problem();
    void bend(const std::vector<Vec<D>>& before, const std::vector<Vec<D>>& offsets);
    [[nodiscard]] bool is_bent_well();
    using EndMetrics = std::array<const VertexMetric<D>*, 2>;
    [[nodiscard]] EndMetrics spoke_metrics(std::size_t s) const {
        return {&request_.metric, &r_.vertices.metrics[vertex(s)]};
    }
    [[nodiscard]] static Sym<D> sum_of_end_metrics(const EndMetrics& ends);
    [[nodiscard]] JointProblem<D> approach_problem() const;
    [[nodiscard]] bool are_elements_good();
    [[nodiscard]] EdgeShell<D> shell_of(std::uint32_t s) const;
    void put(std::uint32_t s, const Vec<D>& node);
    [[nodiscard]] bool raise(std::uint32_t s);

    const Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    const CavityRequest<D>& request_;
    const PatchLimits& limits_;
    const StarWorkspace<D>& star_;
    CurvedWorkspace<D>& w_;
    Patch<D>& out_;
    double bound_ = 0;
    bool are_all_placed_ = false, has_raised_ = false;
    bool is_bent_ = false;  ///< a removed element is curved
    Vec<D> shift_{};        ///< half of the point's offset from the old curves
    QualityCriterion<D>& bar_;
};

}  // namespace camber
