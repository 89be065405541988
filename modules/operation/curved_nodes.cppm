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

/// What the edges and elements of a star must be: the one judge of them, for straight ones and curved ones.
namespace camber {

inline constexpr std::size_t no_face = std::numeric_limits<std::size_t>::max();

/// What is wrong with a star, and at which joined face; no_face: at none of them.
struct StarFault {
    RejectionReason reason = RejectionReason::none;
    std::size_t joined = no_face;
    double worst_shape = std::numeric_limits<double>::infinity();  ///< of the elements, where there is none
};

/// What an element of a star comes to.
struct ElementState {
    bool is_valid = false, is_flat = false;
    double shape = 0;           ///< of a valid one
    bool is_tolerated = false;  ///< not valid, as before
};

/// Whether the edges at the point that a request makes, or moves, are within its limits, as far as they are placed.
template <class ToPoint, class Nodes>
[[nodiscard]] bool lengths_fit(std::span<const ToPoint> to_point, bool point_moves, const PatchLimits& limits,
                               const Nodes& nodes) {
    for (std::size_t s = 0; s < to_point.size(); ++s) {
        if (to_point[s].is_there && !point_moves) continue;  // no edge that is made
        if (!nodes.is_placed(s)) continue;
        const double length = nodes.length_to(s);
        if (!(length >= limits.shortest && length <= limits.longest)) return false;
    }
    return true;
}

/// volume, height, quality: the first that an element fails at.
template <int D>
[[nodiscard]] RejectionReason fault_of(const ElementState& e, QualityBar<D>& bar) {
    if (e.is_tolerated) return RejectionReason::none;
    if (!e.is_valid) return RejectionReason::volume;
    if (e.is_flat) return RejectionReason::height;
    return bar.is_met(e.shape) ? RejectionReason::none : RejectionReason::quality;
}

/// The gravest fault of a star's elements; or, of elements that are judged one by one, the first. `faulty`: which have
/// it, as far as they were judged. `shapes`: of the elements, where there is none.
template <int D, class Nodes>
[[nodiscard]] StarFault find_faults(std::size_t elements, const Nodes& nodes, QualityBar<D>& bar,
                                    std::vector<std::size_t>& faulty, std::vector<double>& shapes) {
    shapes.clear();
    faulty.clear();
    StarFault found;
    const auto rank = [](RejectionReason reason) {
        return reason == RejectionReason::volume ? 0 : reason == RejectionReason::height ? 1 : 2;
    };
    const auto add = [&](RejectionReason reason, std::size_t j) {
        if (found.reason == RejectionReason::none || rank(reason) < rank(found.reason)) {
            found = {reason, j};
            faulty.clear();
        }
        if (rank(reason) == rank(found.reason)) faulty.push_back(j);
    };
    if constexpr (!Nodes::is_judged_by_element) {  // what is not valid first: it needs no shapes
        for (std::size_t j = 0; j < elements; ++j)
            if (nodes.is_broken(j)) add(RejectionReason::volume, j);
        if (!faulty.empty()) return found;
    }
    for (std::size_t j = 0; j < elements; ++j) {
        const ElementState element = nodes.element(j);
        if (const RejectionReason reason = fault_of(element, bar); reason != RejectionReason::none) {
            add(reason, j);
            if (Nodes::is_judged_by_element) return found;
            continue;
        }
        shapes.push_back(element.shape);
        if (found.reason == RejectionReason::none) found.worst_shape = std::min(found.worst_shape, element.shape);
    }
    return found;
}

/// A request with the mesh, the goal and the limits by which its patch is judged.
template <int D>
struct JudgedRequest {
    const Adaptation<D>& mesh;
    const AdaptationGoal<D>& goal;
    const CavityRequest<D>& request;
    const PatchLimits& limits;
};

// The nodes of a star of degree 2 (paper §3.2).

/// Nodes for the edges of patch.star at its point, into patch.nodes, and what its elements are with them:
/// 1. Edges that elements or facets outside of the cavity have keep their nodes; those of the boundary have theirs on
///    the geometry; the others where the metric wants them (accurate_offsets).
/// 2. An element that is not valid to limits.min_jacobian, or no better than it may be, has its inner nodes drawn
///    towards the cavity's own curves as they were: the removed elements as a map from their straight shapes to their
///    curved ones, read at the middle of the new chord. Half of the way, then
///    all of it. Where nothing bends and nothing else moves, an edge that is split has exactly its halves there.
/// 3. Where elements are still not valid: one inner edge of them after the other goes where the least Jacobian around
/// it
///    is largest, a linear programme (see highest_node), at most limits.programmes of them.
/// 4. Where that is not enough: the inner edges together (a joint programme), then the nodes of edges of the broken
///    elements' outer faces along with them, at most limits.bend_around, whose elements outside are judged with the
///    star's.
/// 5. Edges along their curves within the bounds of lengths.
template <int D>
class CurvedNodes {
  public:
    CurvedNodes(const JudgedRequest<D>& judged, OperationWorkspace<D>& workspace, Patch<D>& patch, QualityBar<D>& bar)
        : r_(judged.mesh),
          goal_(judged.goal),
          request_(judged.request),
          limits_(judged.limits),
          star_(workspace.star),
          w_(workspace.curved),
          out_(patch),
          bar_(bar) {}

    static constexpr int degree = 2;
    /// Validity of all elements first, then heights, then shapes.
    static constexpr bool is_judged_by_element = false;

    /// The nodes of edges inside, which cost little; is_placed then.
    void place_inner();
    /// Those of the others; true where there are any.
    bool place_others();
    [[nodiscard]] bool is_placed(std::size_t spoke) const { return are_all_placed_ || is_free(spoke); }
    /// Of the edge from the point to that vertex of the star's boundary, in the metric.
    [[nodiscard]] double length_to(std::size_t spoke) const;
    void begin_elements();
    void judge_elements();
    [[nodiscard]] bool is_broken(std::size_t joined) const;
    [[nodiscard]] ElementState element(std::size_t joined) const;
    /// Whether nodes went where that may help.
    [[nodiscard]] bool correct(RejectionReason reason);
    /// Nodes that were drawn back go together as near to where they are wanted as their elements stay good: a joint
    /// programme.
    void approach();
    void give(Patch<D>& patch) const;
    [[nodiscard]] int programmes() const { return w_.programmes; }
    [[nodiscard]] bool has_drawn_back() const {
        return std::ranges::any_of(w_.spokes, [](const Spoke<D>& s) { return s.share < 1; });
    }

  private:
    [[nodiscard]] VertexId vertex(std::size_t spoke) const { return out_.star.boundary[spoke]; }
    [[nodiscard]] const Vec<D>& end(std::size_t spoke) const { return r_.mesh.points[vertex(spoke)]; }
    [[nodiscard]] Vec<D> middle(std::size_t spoke) const { return midpoint(request_.place, end(spoke)); }

    /// Which edges keep their nodes, and which are of the boundary.
    void begin_spokes();
    /// x(X) of a place between the origin and v, or of the origin: in an element that holds the point and has v, of
    /// which X is a part whatever else lies there too, as where straight shapes are inverted. The largest: the others
    /// may be all but flat. Where there is none, wherever X is.
    [[nodiscard]] Vec<D> old_place_of(const Vec<D>& p, VertexId v) const;
    /// The edge from the point to v that the cavity has already; invalid: none.
    [[nodiscard]] EdgeId edge_there(VertexId v) const;
    /// The node of the edge that a vertex which stays where it is has to v in the cavity already.
    [[nodiscard]] std::optional<Vec<D>> node_there(const Vec<D>& origin, VertexId v) const;
    /// Half of what the point is off the cavity's old curves goes along, as where it ends.
    void extend(std::size_t spoke);
    /// x(X) of a place on the boundary: by the removed facets of the spoke's surfaces, on a line by its removed edges.
    /// Elements would do where their straight shapes are sound, but a surface must not leave itself.
    [[nodiscard]] Vec<D> old_place_on_sides(std::size_t s, const Vec<D>& p) const;
    void put_on_geometry();
    /// Nothing where the geometry has no surface at the spoke, but for embedded lines: these have their curve.
    [[nodiscard]] std::optional<Vec<D>> target_on_geometry(std::size_t s) const;
    void put_wanted();
    void take_wanted();
    /// What has been bent already does not change with the cavity.
    void take_bent(const std::vector<BentSpoke<D>>& bent);
    void put_bent(std::size_t spoke, const Vec<D>& offset, double length);
    void bend_free();
    void search_free();

    void begin_cones();
    void put_nodes(Cone<D>& cone) const;
    /// Verdicts, and whether they are flat, where that is not known.
    void refresh_stale();
    void decide_cone(Cone<D>& cone, const LowJacobian& jacobian) const;
    [[nodiscard]] double shape_of_cone(Cone<D>& cone) const;
    [[nodiscard]] bool replaces_worse_where_invalid() const;
    /// As of degree 1: somewhere so low, det J by the largest face, that coordinates, which are known to their rounding
    /// only, do not tell on which side its vertices are.
    [[nodiscard]] bool is_flat(const NodalSimplex<D>& element, const LowJacobian& jacobian) const;
    /// Of the element with the same vertices, which the joined face is of.
    [[nodiscard]] bool may_stay_invalid(std::size_t joined) const;
    [[nodiscard]] bool is_good(Cone<D>& cone);
    /// Whether an element that is removed is below the bound itself.
    [[nodiscard]] bool replaces_worse() const;
    /// False where no node of a bad element has any way left.
    [[nodiscard]] bool draw_back(RejectionReason reason);
    void mark_stale();
    /// Halves of an edge that is split keep its curve.
    [[nodiscard]] bool is_free(std::size_t s) const {
        return w_.spokes[s].kind == EdgeKind::volume && vertex(s) != request_.halves[0] &&
               vertex(s) != request_.halves[1];
    }
    /// Whether the cavity may do without the element that a new one comes of: cheaper than a programme.
    [[nodiscard]] bool may_leave(std::ptrdiff_t joined) const;
    /// Whether all elements are valid in the end.
    [[nodiscard]] bool raise();
    /// The same by a joint programme: of the inner edges, and of at most so many edges of the rim.
    [[nodiscard]] bool bend_together();
    [[nodiscard]] bool bend_together(int rim);
    void gather_rim(int rim);
    /// False where the element must not change, or is not valid as it is.
    [[nodiscard]] bool gather_outside(ElementId e);
    [[nodiscard]] Vec<D> wanted_node_of(EdgeId edge) const;
    [[nodiscard]] JointProgramme<D> bending_programme();
    /// The nodes at these offsets from where they were.
    void bend(const std::vector<Vec<D>>& before, const std::vector<Vec<D>>& offsets);
    [[nodiscard]] bool is_bent_well();
    using EndMetrics = std::array<const VertexMetric<D>*, 2>;
    [[nodiscard]] EndMetrics spoke_metrics(std::size_t s) const {
        return {&request_.metric, &r_.vertices.metrics[vertex(s)]};
    }
    [[nodiscard]] static Sym<D> distance_seen_along(const EndMetrics& ends);
    [[nodiscard]] JointProgramme<D> approaching_programme() const;
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
    bool is_bent_ = false;  ///< anything of the cavity as it was
    Vec<D> shift_{};        ///< half of what the point is off its curves
    QualityBar<D>& bar_;
};

}  // namespace camber
