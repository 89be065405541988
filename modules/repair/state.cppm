module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>
module camber.repair:state;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import :guide;
import :held_vertices;
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

}  // namespace camber
