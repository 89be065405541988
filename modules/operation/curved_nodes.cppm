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

/// A fault of a star. `joined`: index in `Star::joined` of the face with the faulty element, or `no_face`.
struct StarDefect {
    RejectionReason reason = RejectionReason::none;
    std::size_t joined = no_face;
    double worst_shape = std::numeric_limits<double>::infinity();
};

struct ElementState {
    bool is_valid = false, is_flat = false;
    double shape = 0;
    bool is_tolerated = false;  ///< the element may be invalid, because it replaces an invalid one
};

/// True if the edges at the point have permitted lengths. Ignores edges whose nodes are not computed yet.
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

template <int D>
[[nodiscard]] RejectionReason rejection_of(const ElementState& e, QualityCriterion<D>& bar) {
    if (e.is_tolerated) return RejectionReason::none;
    if (!e.is_valid) return RejectionReason::volume;
    if (e.is_flat) return RejectionReason::height;
    return bar.is_met(e.shape) ? RejectionReason::none : RejectionReason::quality;
}

/// Returns the most serious defect of the new elements or, if `is_judged_by_element`, the first defect. `defective`:
/// indices of the elements with this defect. `shapes`: qualities of all elements, if there is no defect.
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
    if constexpr (!Nodes::is_judged_by_element) {  // validity is checked before qualities are computed
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
/// 1. Edges that also belong to elements or facets outside the cavity keep their nodes. Nodes of boundary edges are
///    placed on the geometry. The metric determines the nodes of inner edges (`accurate_offsets`).
/// 2. Elements below `limits.min_jacobian` or of too low quality have their inner nodes relaxed: the nodes move half of
///    the way to the old curves, then all the way. The position of a node on the old curves is the image of the chord
///    middle in the maps of the removed elements from straight to curved shapes. Halves of a split edge reproduce its
///    curve, if no other edge is curved and the point stays on the curve.
/// 3. Inner nodes of elements that are still invalid move one by one. A linear program (`max_min_node`) maximises the
///    smallest Jacobian around the edge. At most `limits.optimisation_problems` programs are solved.
/// 4. If that fails, one problem moves all inner nodes together. If this fails too, a second problem also moves at most
///    `limits.bend_around` nodes on the outer faces of the invalid elements. It includes the elements outside the
///    cavity that have these nodes.
/// 5. Lengths of the curved edges must be within the limits.
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
    /// False: the validity of all elements is checked before qualities.
    static constexpr bool is_judged_by_element = false;

    void place_inner();
    /// Computes the nodes that `place_inner` leaves out: those of boundary edges and of halves of a split edge. Returns
    /// true if there are any.
    bool place_others();
    [[nodiscard]] bool is_placed(std::size_t spoke) const { return are_all_placed_ || is_free(spoke); }
    [[nodiscard]] double length_to(std::size_t spoke) const;
    void begin_elements();
    void judge_elements();
    [[nodiscard]] bool is_broken(std::size_t joined) const;
    [[nodiscard]] ElementState element(std::size_t joined) const;
    /// Moves nodes of elements with this fault. Returns false if no further correction is possible.
    [[nodiscard]] bool correct(RejectionReason reason);
    /// Moves relaxed nodes together towards their targets, if the elements stay valid and keep the required quality.
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
    /// Maps a point `p` of the straight cavity to the old curves. Uses the largest removed element that contains the
    /// star's point, because smaller ones may be almost flat. If `v` is valid, the element must also contain `v`. If
    /// there is no such element, uses the element nearest to `p`.
    [[nodiscard]] Vec<D> old_place_of(const Vec<D>& p, VertexId v) const;
    [[nodiscard]] EdgeId target_edge(VertexId v) const;
    [[nodiscard]] std::optional<Vec<D>> old_edge_node(const Vec<D>& origin, VertexId v) const;
    /// Computes the spoke's `extended`: a position on the old curves plus half of the star point's offset from these
    /// curves.
    void extend(std::size_t spoke);
    /// Maps `p` to the old curves by removed facets (for spokes on lines: by removed lines). Maps of elements would
    /// leave the surface where straight elements are inverted.
    [[nodiscard]] Vec<D> old_place_on_sides(std::size_t s, const Vec<D>& p) const;
    void put_on_geometry();
    [[nodiscard]] std::optional<Vec<D>> target_on_geometry(std::size_t s) const;
    void place_targets();
    void take_targets();
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
    [[nodiscard]] bool is_flat(const NodalSimplex<D>& element, const JacobianSummary& jacobian) const;
    [[nodiscard]] bool may_stay_invalid(std::size_t joined) const;
    [[nodiscard]] bool is_good(Cone<D>& cone);
    [[nodiscard]] bool replaces_worse() const;
    /// Relaxes the inner nodes of elements with this fault by one step. Returns false if all are fully relaxed.
    [[nodiscard]] bool draw_back(RejectionReason reason);
    void mark_stale();
    /// True for inner edges, except the halves of a split edge, which preserve its curve.
    [[nodiscard]] bool is_free(std::size_t s) const {
        return w_.spokes[s].kind == EdgeKind::volume && vertex(s) != request_.halves[0] &&
               vertex(s) != request_.halves[1];
    }
    [[nodiscard]] bool may_leave(std::ptrdiff_t joined) const;
    /// Moves single nodes by linear programs. Returns true if all elements become valid.
    [[nodiscard]] bool raise();
    [[nodiscard]] bool bend_together();
    [[nodiscard]] bool bend_together(int rim);
    void gather_rim(int rim);
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
    bool is_bent_ = false;
    Vec<D> shift_{};
    QualityCriterion<D>& bar_;
};

}  // namespace camber
