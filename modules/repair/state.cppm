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

/// What moving vertices asks of the mesh: made when they first do.
struct VertexSurroundings {
    Incidence<ElementId> balls;
    Column<VertexFreedom> freedom;  ///< of vertices
};

/// A mesh while programmes repair it.
template <int D>
struct RepairState {
    MovedMesh<D> moved;
    const Incidence<ElementId>& shells;
    const std::function<LagrangeNode<D>(EdgeId)>& wanted_nodes;
    Memo<EdgeId, QuadraticModel<D>> models;
    const RepairOptions& options;
    Column<EdgeKind> kinds;
    Schedule& schedule;    ///< of the mesh's elements
    double work_left = 0;  ///< of programmes and extensions, see element_work
    double work = 0;       ///< done so far
    VertexSurroundings around_vertices = {};
    const FootOnGeometry<D>* onto = nullptr;             ///< none: boundary nodes do not slide
    const VertexOnGeometry<D>* vertices_onto = nullptr;  ///< none: nor do the boundary's vertices

    [[nodiscard]] const QuadraticMesh<D>& mesh() const { return moved.mesh; }
    [[nodiscard]] bool exhausted() const { return work_left < 1; }
    [[nodiscard]] bool good(ElementId e) const { return moved.is_valid(e); }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const { return moved.element(e); }
    /// Where the edge's node is wanted; that goes along with its vertices.
    [[nodiscard]] Vec<D> wanted(EdgeId edge) const { return wanted_nodes(edge).point + moved.shift(edge); }
    /// The edge's model; what is wanted goes along with its vertices.
    [[nodiscard]] QuadraticModel<D> model(EdgeId edge) const {
        QuadraticModel<D> m = models[edge];
        m.centre += moved.shift(edge);
        return m;
    }
};

/// The scaled Jacobian that an element must keep while others are given `asked`: its own where that is less.
template <int D>
[[nodiscard]] inline double jacobian_to_keep(const RepairState<D>& state, ElementId e, double asked) {
    const NodalSimplex<D> element = state.element(e);
    const double weak = smallest_scaled_coefficient(bounded_jacobian(element));
    if (weak >= asked) return asked;
    const double sharp = check_element(element, 0).min_scaled_jacobian;
    const double now = sharp > weak ? sharp : weak;
    return now < asked ? now : asked;
}

/// Whether an element that becomes `next`, with this verdict, is spoilt: it was good enough and is not, or it was valid
/// below the bound and is not even that.
template <int D>
[[nodiscard]] inline bool is_degraded(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next,
                                      Verdict verdict) {
    if (verdict == Verdict::valid) return false;
    return state.good(e) || (decide(state.element(e), 0) == Verdict::valid && decide(next, 0) != Verdict::valid);
}

/// What planning came to, and the work that it was.
template <int D>
struct Planned {
    std::optional<Moves<D>> plan;
    double work = 0;
};

/// The work of the programme of one edge.
inline constexpr double edge_work = 1;

/// One volume node moves, such that the seed is good enough and no element around it stops being so: the cheapest of
/// the seed's edges. None when none can.
template <int D>
[[nodiscard]] Planned<D> plan_edge_repair(const RepairState<D>& state, ElementId seed);

/// An edge's node on the segment to where it is wanted, as far as the elements around it allow by their coefficients:
/// they are affine there. None if that is not far. It counts as no work.
template <int D>
[[nodiscard]] Planned<D> plan_return_on_segment(const RepairState<D>& state, EdgeId edge);

/// A return that wins less of what its nodes cost is not made.
inline constexpr double min_returned_share = 0.01;

/// An edge's node nearer to where it is wanted, as far as the elements around it allow; none if that is not worth it.
template <int D>
[[nodiscard]] Planned<D> plan_return(const RepairState<D>& state, EdgeId edge);

/// What a cavity may move, and how far it reaches around its element.
struct CavityExtent {
    /// `slides`: surface nodes and vertices of volume and boundary, with the nodes of all their edges.
    enum class Moves : std::uint8_t { volume_nodes, vertices, surface_nodes, slides };
    Moves moves = Moves::volume_nodes;
    int closures = 0;  ///< 0: the element's own edges; each more: those of all elements around these
};

/// What a cavity holds: its elements are those around its free edges and vertices.
template <int D>
struct RepairCavity {
    std::vector<EdgeId> edges;       ///< free, rising
    std::vector<VertexId> vertices;  ///< free, rising
    std::vector<ElementId> elements;
};
template <int D>
[[nodiscard]] RepairCavity<D> repair_cavity(const RepairState<D>& state, ElementId seed, CavityExtent extent);

/// The cavity's nodes and vertices together: repairs the seed, to `asked` as a scaled Jacobian; no other element that
/// is good enough stops being so. `asked` 0: to the bound, at whatever cost. None when that is not found.
template <int D>
[[nodiscard]] Planned<D> plan_cavity_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed,
                                            double asked, double max_work);

/// Floors lie this much above the bound: the programme ends within a part of it.
inline constexpr double floor_slack = 2e-6;

/// The same with nodes of boundary edges that slide on the geometry (`state.onto`), and the cavity's vertices, of which
/// those of the boundary slide too (`state.vertices_onto`): each step of the programme is taken in the tangent planes
/// (on curves along the tangents), then brought back onto the geometry, from where the next begins. None when that is
/// not found in a few steps.
template <int D>
[[nodiscard]] Planned<D> plan_slide_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed,
                                           double asked, double max_work);

/// The cavity's nodes together nearer to where they are wanted, as far as its elements allow: from where they are, and
/// from where they are wanted, whichever costs less; none if that is not worth it.
template <int D>
[[nodiscard]] Planned<D> plan_joint_return(const RepairState<D>& state, const RepairCavity<D>& cavity, double max_work);

/// Where the node of a volume edge goes back to; none: it stays.
template <int D>
using HomeOf = std::function<std::optional<LagrangeNode<D>>(EdgeId)>;

/// Nodes of elements that are not good enough go home, step by step, the last one exactly there, until these elements
/// reach the target; those that break on the way are next. Only what is around nodes that moved is looked at. Where
/// homes are not valid themselves elements may be left spoilt. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> go_home(RepairState<D>& state, std::vector<ElementId> queue, const HomeOf<D>& home,
                                    const Execution& execution);

/// As many nodes to where they are `there` as spoil no element: around such nodes stay.
template <int D>
[[nodiscard]] Moves<D> plan_towards(const RepairState<D>& state, const Overlay<EdgeId, LagrangeNode<D>>& there);

/// The mean ratio that the straight form of an element must keep when its vertices move, unless it has less already.
inline constexpr double enough_mean_ratio = 0.05;
/// Below it a straight element counts as flat.
inline constexpr double flat_mean_ratio = 1e-10;

/// What vertices that move must leave of a straight element.
template <int D>
struct ShapeFloor {
    double determinant = 0;  ///< of the mesh's straight element: det J is to be above bound · this
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

/// The mesh's own element; where that is flat or inverted, the mean over the sound elements around its free vertices.
template <int D>
[[nodiscard]] inline ShapeFloor<D> shape_floor(const RepairState<D>& state, ElementId e) {
    const auto own = corners_of(state, e);
    const double ratio = mean_ratio<D>(own);
    if (ratio > flat_mean_ratio) return {determinant_of<D>(own), std::min(ratio, enough_mean_ratio)};
    double determinants = 0, ratios = 0;
    std::size_t n = 0;
    for (const VertexId v : state.mesh().linear.elements.vertices[e]) {
        if (state.around_vertices.freedom[v] == VertexFreedom::held) continue;
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

/// The verdict on an element that becomes `next`: det J ≥ bound · |det| of its own straight form, and, where its
/// vertices are not where the mesh has them, of the mesh's too (`shape_floor`).
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

/// Whether vertices that move leave the straight element shaped well enough: a mean ratio of at least min(the mesh's
/// element's, 0.05). An element that stays invalid may only become better.
template <int D>
[[nodiscard]] inline bool keeps_shape(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next,
                                      Verdict verdict) {
    const auto now = corners_of(state.element(e));
    const auto corners = corners_of(next);
    if (corners == now) return true;
    const double ratio = mean_ratio<D>(corners);
    if (verdict != Verdict::valid) return ratio >= mean_ratio<D>(now);
    return ratio >= shape_floor(state, e).mean_ratio;
}

/// Where something is in a rising list; -1: it is not there.
template <class T>
[[nodiscard]] inline int position_in(const std::vector<T>& sorted, const T& wanted) {
    const auto it = std::lower_bound(sorted.begin(), sorted.end(), wanted);
    return it != sorted.end() && *it == wanted ? static_cast<int>(it - sorted.begin()) : -1;
}

/// What the coefficients of an element with a free vertex are to be above.
template <int D>
[[nodiscard]] inline double min_of(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId e,
                                   double share) {
    constexpr double nothing = -std::numeric_limits<double>::infinity();
    if (share == 0) return nothing;
    for (const VertexId v : state.mesh().linear.elements.vertices[e])
        if (position_in(cavity.vertices, v) >= 0) return share * shape_floor(state, e).determinant;
    return nothing;
}

/// What a vertex weighs more than an edge's node.
inline constexpr double vertex_weight = 4;

/// The mean of the models of the vertex's edges, heavier, about where the vertex was.
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
