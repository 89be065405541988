// State of the optimisation passes: cavities, plans, vertex moves.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>
module camber.repair:state;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.soundness;
import :moved_mesh;
import :options;

namespace camber {

struct VertexSurroundings {
    Incidence<ElementId> balls;
    Column<VertexFreedom> freedom;
};

template <int D>
struct RepairState {
    MovedMesh<D> moved;
    const Incidence<ElementId>& shells;
    const std::function<LagrangeNode<D>(EdgeId)>& target_nodes;
    Memo<EdgeId, QuadraticModel<D>> models;
    const RepairOptions& options;
    Column<EdgeKind> kinds;
    Schedule& schedule;
    double work_left = 0;  ///< unit: `edge_work`
    double work = 0;       ///< used so far
    VertexSurroundings around_vertices = {};
    const FootOnGeometry<D>* onto = nullptr;
    const VertexOnGeometry<D>* vertices_onto = nullptr;

    [[nodiscard]] const QuadraticMesh<D>& mesh() const { return moved.mesh; }
    [[nodiscard]] bool exhausted() const { return work_left < 1; }
    [[nodiscard]] bool good(ElementId e) const { return moved.is_valid(e); }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const { return moved.element(e); }
    /// Target position of the edge's node, moved by the displacement of the chord midpoint.
    [[nodiscard]] Vec<D> target_position(EdgeId edge) const { return target_nodes(edge).point + moved.shift(edge); }
    [[nodiscard]] QuadraticModel<D> model(EdgeId edge) const {
        QuadraticModel<D> m = models[edge];
        m.centre += moved.shift(edge);
        return m;
    }
};

/// Returns `requested`, or the element's own scaled Jacobian if that is lower.
template <int D>
[[nodiscard]] inline double preserved_jacobian(const RepairState<D>& state, ElementId e, double requested) {
    const NodalSimplex<D> element = state.element(e);
    const double weak = smallest_scaled_coefficient(bounded_jacobian(element));
    if (weak >= requested) return requested;
    const double sharp = check_element(element, 0).min_scaled_jacobian;
    const double now = sharp > weak ? sharp : weak;
    return now < requested ? now : requested;
}

/// True if the change to `next` loses validity, or at least det J > 0.
template <int D>
[[nodiscard]] inline bool is_degraded(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next,
                                      Verdict verdict) {
    if (verdict == Verdict::valid) return false;
    return state.good(e) || (decide(state.element(e), 0) == Verdict::valid && decide(next, 0) != Verdict::valid);
}

template <int D>
struct Planned {
    std::optional<Moves<D>> plan;
    double work = 0;
};

/// Unit of work: the optimisation of one edge.
inline constexpr double edge_work = 1;

/// Plans the cheapest move of one volume node that makes the element `seed` valid without degrading an element.
template <int D>
[[nodiscard]] Planned<D> plan_edge_repair(const RepairState<D>& state, ElementId seed);

/// Plans a move of the node along the segment to its target, on which the coefficients are affine. No plan if the step
/// is short. The planning does not count as work.
template <int D>
[[nodiscard]] Planned<D> plan_return_on_segment(const RepairState<D>& state, EdgeId edge);

/// Minimum relative cost reduction that justifies a move towards the target.
inline constexpr double min_returned_share = 0.01;

/// Plans a move of the node towards its target as far as the elements allow; no plan if the cost reduction is small.
template <int D>
[[nodiscard]] Planned<D> plan_return(const RepairState<D>& state, EdgeId edge);

struct CavityExtent {
    /// Kinds of points that may move. `slides`: surface nodes, vertices in the volume and on the boundary, and the
    /// nodes of edges at these vertices.
    enum class Moves : std::uint8_t { volume_nodes, vertices, surface_nodes, slides };
    Moves moves = Moves::volume_nodes;
    int closures = 0;  ///< extensions of the set of edges: 0 has those of the seed, each adds those of adjacent
                       ///< elements
};

template <int D>
struct RepairCavity {
    std::vector<EdgeId> edges;       ///< free, ascending
    std::vector<VertexId> vertices;  ///< free, ascending
    std::vector<ElementId> elements;
};
template <int D>
[[nodiscard]] RepairCavity<D> repair_cavity(const RepairState<D>& state, ElementId seed, CavityExtent extent);

/// Plans a joint move that gives the element `seed` at least the scaled Jacobian `requested` without degrading an
/// element. For `requested` 0, the bound suffices, at any cost.
template <int D>
[[nodiscard]] Planned<D> plan_cavity_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed,
                                            double requested, double max_work);

/// Amount by which required scaled Jacobians exceed the bound. The solver may miss a requirement by a fraction of this
/// amount.
inline constexpr double floor_slack = 2e-6;

/// Like `plan_cavity_repair`, but boundary nodes and vertices slide on the geometry (`onto`, `vertices_onto`). Each
/// step moves points in their tangent planes (along tangents of curves), then projects them. No plan if a few steps do
/// not succeed.
template <int D>
[[nodiscard]] Planned<D> plan_slide_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed,
                                           double requested, double max_work);

/// Plans a joint move of the cavity's points towards their targets: the cheaper of two solutions, started from the
/// current and from the target positions. No plan if the cost reduction is small.
template <int D>
[[nodiscard]] Planned<D> plan_joint_return(const RepairState<D>& state, const RepairCavity<D>& cavity, double max_work);

/// Position to which the node of a volume edge is restored; nothing: the node stays.
template <int D>
using RestoredPosition = std::function<std::optional<LagrangeNode<D>>(EdgeId)>;

/// Moves the nodes of queued elements to their restored positions in steps, the last one exact, until the elements
/// reach the target. Elements that become invalid join the queue; some may stay degraded if the restored positions are
/// invalid. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> restore_nodes(RepairState<D>& state, std::vector<ElementId> queue,
                                          const RestoredPosition<D>& restored, const Execution& execution);

/// Plans moves of nodes to their positions in `there`, except nodes of elements that would degrade.
template <int D>
[[nodiscard]] Moves<D> plan_towards(const RepairState<D>& state, const Overlay<EdgeId, LagrangeNode<D>>& there);

/// Mean ratio that a straight element keeps when its vertices move, unless its ratio is already lower.
inline constexpr double enough_mean_ratio = 0.05;
/// Straight elements with a lower mean ratio count as flat.
inline constexpr double flat_mean_ratio = 1e-10;

template <int D>
struct ShapeFloor {
    double determinant = 0;  ///< det J must exceed bound · `determinant`
    double mean_ratio = 0;
};

template <int D>
[[nodiscard]] inline std::array<Vec<D>, D + 1> corners_of(const RepairState<D>& state, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = state.mesh().linear.points[state.mesh().linear.elements.vertices[e][i]];
    return corners;
}
template <int D>
[[nodiscard]] inline std::array<Vec<D>, D + 1> corners_of(const NodalSimplex<D>& element) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = element.nodes[i];
    return corners;
}
template <int D>
[[nodiscard]] inline double determinant_of(const std::array<Vec<D>, D + 1>& corners) {
    return (D == 2 ? 2 : 6) * signed_measure<D>(corners);
}

/// Returns the determinant and the mean ratio (at most enough_mean_ratio) of the original straight element. If it is
/// flat or inverted, returns means over sound elements around its free vertices.
template <int D>
[[nodiscard]] inline ShapeFloor<D> shape_floor(const RepairState<D>& state, ElementId e) {
    const auto own = corners_of(state, e);
    const double ratio = mean_ratio<D>(own);
    if (ratio > flat_mean_ratio) return {determinant_of<D>(own), std::min(ratio, enough_mean_ratio)};
    double determinants = 0, ratios = 0;
    std::size_t n = 0;
    for (const VertexId v : state.mesh().linear.elements.vertices[e]) {
        if (state.around_vertices.freedom[v] == VertexFreedom::fixed) continue;
        for (const ElementId near : state.around_vertices.balls[v]) {
            const auto corners = corners_of(state, near);
            const double of_near = mean_ratio<D>(corners);
            if (!(of_near > flat_mean_ratio)) continue;
            determinants += determinant_of<D>(corners);
            ratios += of_near;
            ++n;
        }
    }
    if (n == 0) return {};
    const auto count = static_cast<double>(n);
    return {determinants / count, std::min(ratios / count, enough_mean_ratio)};
}

/// Verdict for det J ≥ bound · |det| of the current straight element and, if vertices moved, of the original one
/// (`shape_floor`).
template <int D>
[[nodiscard]] inline Verdict verdict_of(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next) {
    const double bound = state.options.min_scaled_jacobian;
    const auto corners = corners_of(next);
    const Verdict own = decide(next, bound);
    if (own != Verdict::valid || bound == 0 || corners == corners_of(state, e)) return own;
    const double was = shape_floor(state, e).determinant;
    const double is = std::abs(determinant_of<D>(corners));
    return is < was ? decide(next, bound * was / is) : own;
}

/// True if the straight element keeps the mean ratio min(original ratio, 0.05). An element that stays invalid must not
/// lose mean ratio.
template <int D>
[[nodiscard]] inline bool preserves_shape(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next,
                                          Verdict verdict) {
    const auto now = corners_of(state.element(e));
    const auto corners = corners_of(next);
    if (corners == now) return true;
    const double ratio = mean_ratio<D>(corners);
    if (verdict != Verdict::valid) return ratio >= mean_ratio<D>(now);
    return ratio >= shape_floor(state, e).mean_ratio;
}

template <class T>
[[nodiscard]] inline int index_in(const std::vector<T>& sorted, const T& value) {
    const auto it = std::lower_bound(sorted.begin(), sorted.end(), value);
    return it != sorted.end() && *it == value ? static_cast<int>(it - sorted.begin()) : -1;
}

template <int D>
[[nodiscard]] inline double min_of(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId e,
                                   double share) {
    constexpr double nothing = -std::numeric_limits<double>::infinity();
    if (share == 0) return nothing;
    for (const VertexId v : state.mesh().linear.elements.vertices[e])
        if (index_in(cavity.vertices, v) >= 0) return share * shape_floor(state, e).determinant;
    return nothing;
}

/// Cost of a vertex relative to an edge node.
inline constexpr double vertex_weight = 4;

/// Cost model of a vertex: the mean model of its edges, centred at the original position.
template <int D>
[[nodiscard]] inline OffsetModel<D> model_of(const RepairState<D>& state, VertexId vertex) {
    OffsetModel<D> model{-state.moved.shift(vertex), {}};
    std::size_t n = 0;
    for (const ElementId e : state.around_vertices.balls[vertex])
        for (const EdgeId edge : state.mesh().edges.of_elements[e]) {
            const auto& ends = state.mesh().edges.vertices[edge];
            if (ends[0] != vertex && ends[1] != vertex) continue;
            model.hessian += state.models[edge].hessian;
            ++n;
        }
    model.hessian *= vertex_weight / static_cast<double>(std::max<std::size_t>(n, 1));
    return model;
}

}  // namespace camber
