module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>
module camber.run:state;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.metric;
import camber.operation;
import camber.adapt;
import camber.surface;
import camber.validity;
import camber.curving;
import camber.distributed;
import camber.recipes;
import :histogram;
import :report;

/// What a run holds between two stages: a sum of what can be, so that a stage which finds its input there has all of
/// it.
namespace camber::run {

/// A mesh as it was read: its degree is the file's.
template <int D>
using GivenMesh = std::variant<LinearMesh<D>, QuadraticMesh<D>>;

/// A plan that began with the nodes that the mesh was read with.
template <int D>
struct OwnNodes {
    Features<D> features;
    std::optional<Boundary<D>> boundary = {};  ///< with a prescribed geometry, onto which the boundary's nodes went
};

/// A plan of `curve` or `reinsert`: where they want nodes, and by what.
template <int D>
struct Wanted {
    Boundary<D> boundary;
    Incidence<ElementId> shells;
    Curved<D> curved;  ///< before any correction
    CurvingAim aim = CurvingAim::energy;
    Column<LagrangeNode<D>> extended = {};  ///< where nodes go back to, see CurveInput
};

/// Places that are the mesh's by now, and the verdicts that they became so with.
template <int D>
struct CommittedPlaces {
    Proposal<D> proposal;
    Validation<D> validation;
};

/// Places for nodes and vertices, committed or not.
template <int D>
struct Plan {
    std::variant<OwnNodes<D>, Wanted<D>> origin;
    std::variant<Proposal<D>, JudgedProposal<D>, CommittedPlaces<D>> places;

    [[nodiscard]] const Features<D>& features() const;
    [[nodiscard]] const Proposal<D>& proposal() const;
    [[nodiscard]] const Validation<D>* validation() const;  ///< of the places; null until they were judged
    /// Null: to be judged for the mesh as it is now.
    [[nodiscard]] const JudgedProposal<D>* judged() const { return std::get_if<JudgedProposal<D>>(&places); }
    /// Null: began with the nodes that the mesh was read with.
    [[nodiscard]] const Wanted<D>* wanted() const { return std::get_if<Wanted<D>>(&origin); }
    /// Null: the mesh's own, without a geometry.
    [[nodiscard]] const Boundary<D>* boundary() const {
        if (const auto* own = std::get_if<OwnNodes<D>>(&origin)) return own->boundary ? &*own->boundary : nullptr;
        return &std::get<Wanted<D>>(origin).boundary;
    }
};

/// Nothing is planned; verdicts of the mesh's own nodes, once asked for.
template <int D>
struct Unplanned {
    std::optional<Validation<D>> validation;
};

/// A mesh of degree 2, and what is planned for it.
template <int D>
struct Quadratic {
    QuadraticMesh<D> mesh;
    NodesOf nodes = NodesOf::elevation;
    std::variant<Unplanned<D>, Plan<D>> plan;

    [[nodiscard]] const Plan<D>* planned() const { return std::get_if<Plan<D>>(&plan); }
    /// Of the plan, or of the mesh where there is none; null when nothing was judged.
    [[nodiscard]] const Validation<D>* validation() const;
    /// Whether the boundary's nodes are the file's: they stay, unless analytic surfaces are given.
    [[nodiscard]] bool boundary_is_given() const;
    /// Whether there are planned places that are not the mesh's.
    [[nodiscard]] bool has_uncommitted() const;
};

/// Nothing was corrected yet: the last verdicts, if any.
template <int D>
struct Uncorrected {
    std::optional<Validation<D>> last;
};
/// Something was: the verdicts before.
template <int D>
struct Corrected {
    Validation<D> before;
};
/// What verdicts in the end are compared with.
template <int D>
using History = std::variant<Uncorrected<D>, Corrected<D>>;

/// A mesh between two passes that change it, and what it is brought to.
template <int D>
struct Changing {
    Adaptation<D> mesh;
    AdaptationGoal<D> goal;
    MetricReport metric;                ///< of the goal's field
    std::vector<Histogram> histograms;  ///< of the mesh before, see UnitMesh
    /// Shared among ranks, at the end of a run that ends in rows: the mesh is empty then.
    std::optional<BroughtRows<D>> shared = {};
};

/// What a mesh that was remeshed has of the one before: its facets approximate the same geometry, and its vertices know
/// their metric.
template <int D>
struct Inherited {
    Geometry<D> geometry;
    Column<LogMetric<D>> log_metrics;
    MetricReport metric;                    ///< of the field that it was remeshed by
    std::optional<BackMesh<D>> field = {};  ///< itself, where that is of a file with a mesh of its own
    EmbeddedCurves<D> curves = {};          ///< of the mesh that was remeshed
};

/// Crossings of a proposal, and its places.
template <int D>
struct KnownCrossings {
    Column<Vec<D>> points;
    Column<LagrangeNode<D>> mid_nodes;
    Crossings crossings;

    [[nodiscard]] bool is_of(const QuadraticMesh<D>& mesh) const {
        return points == mesh.linear.points && mid_nodes == mesh.mid_nodes;
    }
};

template <int D>
struct State {
    std::variant<LinearMesh<D>, Changing<D>, Quadratic<D>> mesh;
    Column<Vec<D>> given_points;  ///< of the vertices as they were read: where the rows of metric files speak
    Column<LagrangeNode<D>> given_nodes = {};  ///< of a mesh of degree 2 its nodes, likewise: what came is told beside
    std::optional<BackMesh<D>> field;          ///< the last that was made
    /// Where that is on a curved back mesh: the metric of the straight mesh at its vertices.
    std::optional<Column<LogMetric<D>>> straight_log_metrics;
    std::optional<Inherited<D>> inherited;
    /// Of the boundary that the stage `remesh` left, against the bounds of the config; empty once a stage changes it.
    std::optional<ReachedDistance<D>> reached;
    std::optional<FinishedRows<D>> rows;              ///< what this rank has in the end: the mesh is empty then
    std::optional<CadMovesReport> cad_moves;          ///< of vertices, before the first stage
    std::optional<std::size_t> crossings_of_input;    ///< pairs of facets that crossed before passes changed the mesh
    std::optional<RelaxedWallsReport> relaxed_walls;  ///< boundary nodes that were moved back because walls crossed
    std::optional<KnownCrossings<D>> crossings;       ///< of the places that the stage `relax` left
    History<D> history;
    JacobianBound bound = {};   ///< what the last stage asked for that did
    CurveOptions curving = {};  ///< of the last stage that curved: passes have new edges find their nodes alike
};

/// How a run begins.
template <int D>
[[nodiscard]] State<D> beginning_with(GivenMesh<D> mesh);

}  // namespace camber::run
