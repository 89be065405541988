// Boundary, repair guide, curve input, proposals, curving and mesh checks.
module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>
export module camber.stages:curve;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.crossing;
import camber.optimisation;
import camber.soundness;
import camber.surface;
import camber.adapt;
import camber.curving;
import camber.repair;
import :metric;

export namespace camber {

/// Boundary of a mesh: features, geometry, and whether required nodes may move.
template <int D>
struct Boundary {
    Features<D> features;
    RequiredBoundary required = RequiredBoundary::keep;
    Geometry<D> geometry;
};

template <int D>
struct BoundaryOptions {
    FeatureOptions<D> features = {};
    RequiredBoundary required = RequiredBoundary::keep;
};

/// Finds the boundary. Without `specified`, its geometry is the surrogate: smooth surfaces through the vertices and the
/// edges' `nodes`, if any. Errors: those of find_features and build_surrogate.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> find_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const std::optional<Geometry<D>>& specified,
                                                 const BoundaryOptions<D>& options, const Execution& execution,
                                                 std::span<const LagrangeNode<D>> nodes = {});

/// Target positions of nodes. The references must outlive guides made from them.
template <int D>
struct TargetNodes {
    const Curved<D>& curved;  ///< nodes before any correction
    const Incidence<ElementId>& shells;
    const Column<LagrangeNode<D>>& extended;  ///< see CurveInput
    CurvingAim aim;
    const BackMesh<D>* field;  ///< null: the mesh's own metric
};

/// Returns a repair guide: costs of nodes off their targets, and projections onto prescribed surfaces. Without
/// `target`, the nodes of the mesh are the targets; without a boundary, nothing is projected. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<RepairGuide<D>> make_guide(const JudgedProposal<D>& judged,
                                                 const std::optional<TargetNodes<D>>& target,
                                                 const Boundary<D>* boundary, const RepairOptions& options,
                                                 const Execution& execution);

/// Origin of nodes. `elevation`: straight, by the function `elevate`. `input`: curved, in the input or by earlier
/// passes.
enum class NodesOf : std::uint8_t { elevation, input };

/// Input of curving, one row per edge: target positions of boundary nodes, start positions of volume nodes.
template <int D>
struct CurveInput {
    Column<EdgeKind> kinds;
    Column<LagrangeNode<D>> base;
    Incidence<ElementId> shells;
    std::size_t preserved = 0;  ///< boundary edges with preserved input nodes
    /// Extended boundary displacement. It is computed for curved input too, so that curving again changes nothing.
    /// Empty if nothing is displaced or the field is on the straight mesh.
    Column<LagrangeNode<D>> extended = {};
    std::optional<PlacementStatistics> placed = {};  ///< set if the metric field determined boundary nodes in `base`,
                                                     ///< instead of projection
    std::size_t relaxed = 0;                         ///< shifts of nodes that were reduced to protect elements
    std::size_t loss_limited = 0;                    ///< shifts that were more than halved because they would increase
                                                     ///< the error of smooth functions
};

template <int D>
struct CurvedFrom {
    const QuadraticMesh<D>& mesh;
    NodesOf nodes;
    const Boundary<D>& boundary;
};

/// Puts boundary nodes onto the geometry; for curved input, only nodes on prescribed surfaces. Volume nodes stay.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> curve_input(const CurvedFrom<D>& from, const Execution& execution);

template <int D>
struct MeshGoal {
    MetricSource<D> metric = natural_metric<D>();
    std::optional<Geometry<D>> geometry = {};  ///< none: surrogate
    BoundaryOptions<D> boundary = {};
    SolutionInput<D> solution = {};  ///< for the objective solution
    /// Largest distances of the boundary from its geometry, for remeshing.
    std::vector<DistanceBound> distance_bounds = {};
};

/// Objective for volume nodes: an aim of `curve` (accuracy, energy, length), the element shape, or the error of a
/// solution.
enum class Objective : std::uint8_t { accuracy, energy, length, shape, solution };
[[nodiscard]] constexpr auto words(Objective) {
    return words_of(Word{Objective::accuracy, "accuracy"}, Word{Objective::energy, word_of(EdgeObjectiveKind::energy)},
                    Word{Objective::length, word_of(EdgeObjectiveKind::length)}, Word{Objective::shape, "shape"},
                    Word{Objective::solution, "solution"});
}

enum class BackMeshKind : std::uint8_t {
    curved,    ///< follows boundaries with noticeable sagitta (see back_mesh_nodes)
    straight,  ///< paper §1.2
};
[[nodiscard]] constexpr auto words(BackMeshKind) {
    return words_of(Word{BackMeshKind::curved, "curved"}, Word{BackMeshKind::straight, "straight"});
}

struct ProposeOptions : CurveOptions, PlacementOptions {
    Objective objective = Objective::accuracy;
    BackMeshKind back_mesh = BackMeshKind::curved;

    [[nodiscard]] static constexpr auto options() {
        using S = ProposeOptions;
        return std::tuple_cat(
            std::tuple(
                option("objective", &S::objective,
                       "objective that determines node positions. accuracy: functions to which the metric belongs are "
                       "interpolated well; energy: edges of minimal energy in the metric, which are smooth and evenly "
                       "spaced; length: edges of minimal length in the metric; shape: no metric, Jacobians of elements "
                       "as uniform as possible; solution: no metric, the run's solution is interpolated well"),
                option("background_mesh", &S::back_mesh,
                       "mesh in which the metric is evaluated. curved: a mesh that follows curved boundaries if their "
                       "sagitta exceeds a small share of the metric's sizes, from which nodes also start; straight: "
                       "the straight mesh, as in the paper")),
            PlacementOptions::options(), CurveOptions::options());
    }
    friend bool operator==(const ProposeOptions&, const ProposeOptions&) = default;
};

[[nodiscard]] CurveOptions edge_options(const ProposeOptions& options);

[[nodiscard]] constexpr bool has_field(Objective objective) {
    return objective != Objective::shape && objective != Objective::solution;
}

/// Expected errors of a solution: `before` with the nodes of the objective `shape`, `after` with the nodes found. For
/// one field, the error is weight · L2 error in the user's unit. For several fields, it is the root of Σ (weight · L2
/// error)², in units in which the fields' ranges are about 1.
struct ExpectedErrors {
    double before = 0, after = 0;
    int rounds = 0;
};

/// Node targets before any correction, and the data from which they were computed.
template <int D>
struct ProposedCurves {
    Curved<D> curved;
    CurveInput<D> input;
    std::optional<BackMesh<D>> field;                          ///< none for the objectives shape and solution
    std::optional<Column<LogMetric<D>>> straight_log_metrics;  ///< log-metrics of the straight mesh, if the field uses
                                                               ///< another mesh
    CurveOptions edges = {};                                   ///< options of the search, see accuracy_for
    std::optional<ExpectedErrors> expected = {};               ///< for the objective solution
};

/// Computes node targets. Steps: extension; metric, if edges follow one; curve. Errors: usage (objective shape or
/// solution with boundary nodes by length, solution without fields); those of the metric and `known_solution`; stopped;
/// memory.
template <int D>
[[nodiscard]] Outcome<ProposedCurves<D>> propose_curves(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                        const SolutionInput<D>& solution, const ProposeOptions& options,
                                                        const StepWrapper& around);

}  // namespace camber

namespace camber {

/// Metric field, and curve input with `base` at the nodes of the field's mesh.
template <int D>
struct CurvingStart {
    CurveInput<D> input;
    std::optional<BackMesh<D>> field;
    std::optional<Column<LogMetric<D>>> straight_log_metrics;
    CurveOptions edges = {};  ///< see accuracy_for
};
/// Computes field and input. Steps: extension; metric, if edges follow one.
template <int D>
[[nodiscard]] Outcome<CurvingStart<D>> begin_curving(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                     const ProposeOptions& options, const StepWrapper& around);

/// Moves boundary nodes to positions that the field determines (placed_input, slid_input).
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> moved_input(const CurvedFrom<D>& from, CurveInput<D> input,
                                                 const BackMesh<D>& field, const CurveOptions& edges,
                                                 const PlacementOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Builds the field of a metric on its mesh. Errors: those of the source, stopped, memory.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_field(const LinearMesh<D>& mesh, const MetricSource<D>& metric,
                                              const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_field(const QuadraticMesh<D>& mesh, const MetricSource<D>& metric,
                                              const Execution& execution);

struct ReinsertNodesOptions {
    ProposeOptions curve = {};
    ReinsertionOptions cavities = {};
};

template <int D>
struct ReinsertedNodes {
    ProposedCurves<D> target;
    ReinsertionResult<D> result;
};

/// The paper's global algorithm (§4): reinserts every vertex, with the targets of `propose_curves`. Steps: extension,
/// metric, reinsert. Errors: objective shape (usage); those of propose_curves and reinsert.
template <int D>
[[nodiscard]] Outcome<ReinsertedNodes<D>> reinsert_nodes(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                         const ReinsertNodesOptions& options,
                                                         const StepWrapper& around);

struct CurveMeshOptions {
    ProposeOptions curve = {};
    RepairOptions repair = {};
};

/// The default bound of the scaled Jacobian is 0, because any program may have written the mesh.
struct MeshCheckOptions {
    double min_scaled_jacobian = 0;
    ExamineOptions examine = {};
};

/// Crossing boundaries and overlapping elements of `mesh`, in which all boundary facets are listed.
template <int D>
struct CheckedWalls {
    QuadraticMesh<D> mesh;
    Crossings crossings;
    Overlaps<D> overlaps = {};  ///< empty if elements occur twice
};

template <int D>
struct MeshCheck {
    Soundness soundness;
    QuadraticMesh<D> mesh;  ///< of degree 2 also if the input is linear
    Validation<D> validation;
    /// None for fatal defects, or if the boundary cannot be listed.
    std::optional<CheckedWalls<D>> walls;

    [[nodiscard]] bool all_good() const {
        return soundness.sound() && validation.all_valid() && walls && walls->crossings.crossing == 0 &&
               walls->overlaps.overlapping == 0;
    }
};

/// Checks a mesh. Steps: examine, validate, cross. Errors: unsupported (no simplices of degree 1 or 2), memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<MeshCheck<D>> check_mesh(const Mesh<D>& mesh, const MeshCheckOptions& options,
                                               const StepWrapper& around);

}  // namespace camber
