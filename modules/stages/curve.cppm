// Boundary, guide, curve input, proposals, and the recipes for curving and checking.
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

/// The boundary of a mesh as recipes take it: its ridges and corners, the shape that its nodes go onto, and whether
/// required nodes go along.
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

/// With the geometry that is given, or without one smooth surfaces through the mesh's own vertices (the surrogate):
/// with the boundary's own curves where `nodes` of the mesh's edges tell them, one an edge. Errors: those of
/// find_features and build_surrogate.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> find_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const std::optional<Geometry<D>>& given,
                                                 const BoundaryOptions<D>& options, const Execution& execution,
                                                 std::span<const LagrangeNode<D>> nodes = {});

/// Where nodes were wanted, and by what; all is asked while a guide that it makes is used.
template <int D>
struct WantedNodes {
    const Curved<D>& curved;  ///< before any correction
    const Incidence<ElementId>& shells;
    const Column<LagrangeNode<D>>& extended;  ///< see CurveInput
    CurvingAim aim;
    const BackMesh<D>* field;  ///< null: the mesh's own metric
};

/// What repair goes by: what a node off its wanted place costs in the field, feet on surfaces that are prescribed.
/// Without wanted nodes where the mesh itself has them; without a boundary no feet. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<RepairGuide<D>> make_guide(const JudgedProposal<D>& judged,
                                                 const std::optional<WantedNodes<D>>& wanted,
                                                 const Boundary<D>* boundary, const RepairOptions& options,
                                                 const Execution& execution);

/// Whence a mesh has the nodes that curving begins with: straight ones of `elevate`, or curves of its own, which it was
/// read with or got by passes that changed it.
enum class NodesOf : std::uint8_t { elevation, input };

/// What the edges of a mesh are curved from: where boundary nodes are wanted, and from where those of the volume start,
/// one row an edge; and which nodes stay.
template <int D>
struct CurveInput {
    Column<EdgeKind> kinds;
    Column<LagrangeNode<D>> base;
    Incidence<ElementId> shells;
    std::size_t kept = 0;  ///< edges of the boundary that keep the nodes of a mesh with curves of its own
    /// The boundary's displacement extended into the volume; empty where the field is read in the straight mesh, or
    /// nothing is displaced. Of a mesh with curves of its own too: curved again it comes out the same.
    Column<LagrangeNode<D>> extended = {};
    std::optional<PlacementStatistics> placed = {};  ///< where `base` has them elsewhere than projected
    std::size_t drawn_back = 0;                      ///< slides that go a part of their way, for their elements
    std::size_t held_back = 0;                       ///< that go less than half of it, for smooth functions
};

/// A mesh of degree 2 that is to be curved.
template <int D>
struct CurvedFrom {
    const QuadraticMesh<D>& mesh;
    NodesOf nodes;
    const Boundary<D>& boundary;
};

/// Boundary nodes on the geometry; of a mesh with curves of its own only those on prescribed surfaces. Volume edges
/// start at the mesh's nodes.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> curve_input(const CurvedFrom<D>& from, const Execution& execution);

/// Target of a recipe: metric, geometry and solution as values.
template <int D>
struct MeshGoal {
    MetricSource<D> metric = natural_metric<D>();
    std::optional<Geometry<D>> geometry = {};  ///< none: smooth surfaces through the mesh's own vertices
    BoundaryOptions<D> boundary = {};
    GivenSolution<D> solution = {};  ///< of the objective solution
    /// Largest distances of the boundary from its geometry that remeshing must reach.
    std::vector<DistanceBound> distance_bounds = {};
};

/// What places volume nodes: `curve` of camber.curving by one of its aims, its `shape`, or its `solution_nodes`.
enum class Objective : std::uint8_t { accuracy, energy, length, shape, solution };
[[nodiscard]] constexpr auto words(Objective) {
    return words_of(Word{Objective::accuracy, "accuracy"}, Word{Objective::energy, word_of(EdgeObjectiveKind::energy)},
                    Word{Objective::length, word_of(EdgeObjectiveKind::length)}, Word{Objective::shape, "shape"},
                    Word{Objective::solution, "solution"});
}

/// Where the metric is read.
enum class BackMeshKind : std::uint8_t {
    curved,    ///< in a mesh of degree 2 that goes along with walls that sag, see back_mesh_nodes of camber.curving
    straight,  ///< in the straight mesh (paper §1.2)
};
[[nodiscard]] constexpr auto words(BackMeshKind) {
    return words_of(Word{BackMeshKind::curved, "curved"}, Word{BackMeshKind::straight, "straight"});
}

/// The options of `curve`, and what chooses between its aims and `shape`.
struct ProposeOptions : CurveOptions, PlacementOptions {
    Objective objective = Objective::accuracy;
    BackMeshKind back_mesh = BackMeshKind::curved;

    [[nodiscard]] static constexpr auto options() {
        using S = ProposeOptions;
        return std::tuple_cat(
            std::tuple(
                option(
                    "objective", &S::objective,
                    "what edges are curved for: accuracy, that what the metric belongs to is interpolated well; energy "
                    "or "
                    "length, that this is least in the metric (energy: smooth, evenly spaced); shape: no metric, the "
                    "Jacobians of elements are made as even as may be; solution: that the run's solution is "
                    "interpolated "
                    "well, no metric"),
                option("background_mesh", &S::back_mesh,
                       "where the metric is read: curved, in a mesh that goes along with walls that sag by more "
                       "than a little of its sizes, and nodes start from there; straight, at its point's place "
                       "in the straight mesh, as in the paper")),
            PlacementOptions::options(), CurveOptions::options());
    }
    friend bool operator==(const ProposeOptions&, const ProposeOptions&) = default;
};

/// Those for one edge: the aim is the objective's.
[[nodiscard]] CurveOptions edge_options(const ProposeOptions& options);

/// Whether edges follow a metric.
[[nodiscard]] constexpr bool has_field(Objective objective) {
    return objective != Objective::shape && objective != Objective::solution;
}

/// The expected error of a solution: of one field weight · L2 error in the user's unit, of several the root of
/// Σ (weight · L2 error)², each in a unit in which its range is about 1. With the nodes of the objective shape, and
/// with those that were found.
struct ExpectedErrors {
    double before = 0, after = 0;
    int rounds = 0;
};

/// Where the nodes of a mesh are wanted, before any correction, and what they were found from.
template <int D>
struct ProposedCurves {
    Curved<D> curved;
    CurveInput<D> input;
    std::optional<BackMesh<D>> field;                          ///< none: of the objectives shape and solution
    std::optional<Column<LogMetric<D>>> straight_log_metrics;  ///< at the vertices, of the straight mesh where the
                                                               ///< field is another
    CurveOptions edges = {};                                   ///< by which nodes were found: see accuracy_for
    std::optional<ExpectedErrors> expected = {};               ///< of the objective solution
};

/// Steps: extension, then metric where edges follow one, and curve. Errors (usage): the objectives
/// shape and solution with boundary nodes by length, solution without fields; those of the metric, of `known_solution`;
/// stopped; memory.
template <int D>
[[nodiscard]] Outcome<ProposedCurves<D>> propose_curves(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                        const GivenSolution<D>& solution, const ProposeOptions& options,
                                                        const Around& around);

}  // namespace camber

namespace camber {

/// What a curving begins with: the input with its base where the field has nodes, and the field.
template <int D>
struct CurvingStart {
    CurveInput<D> input;
    std::optional<BackMesh<D>> field;
    std::optional<Column<LogMetric<D>>> straight_log_metrics;
    CurveOptions edges = {};  ///< for one edge, of this metric: see accuracy_for
};
/// The steps extension and, where edges follow one, metric.
template <int D>
[[nodiscard]] Outcome<CurvingStart<D>> begin_curving(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                     const ProposeOptions& options, const Around& around);

/// Nodes of boundary edges where the options want them in the field: placed_input, slid_input.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> moved_input(const CurvedFrom<D>& from, CurveInput<D> input,
                                                 const BackMesh<D>& field, const CurveOptions& edges,
                                                 const PlacementOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// A metric as a field on the mesh itself, straight or with its curves. Errors: those of the source, stopped, memory.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_field(const LinearMesh<D>& mesh, const MetricSource<D>& metric,
                                              const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_field(const QuadraticMesh<D>& mesh, const MetricSource<D>& metric,
                                              const Execution& execution);

/// With the stages' own options for the cavities.
struct ReinsertNodesOptions {
    ProposeOptions curve = {};
    ReinsertionOptions cavities = {};
};

/// Nodes that cavities brought to where they were wanted, as far as elements allow.
template <int D>
struct ReinsertedNodes {
    ProposedCurves<D> wanted;
    Reinserted<D> made;
};

/// The paper's global algorithm (§4) on a mesh of degree 2: its nodes are wanted as `propose_curves` has them, and
/// every vertex is put in again. Steps: extension, metric, reinsert. Errors: the objective shape (usage); those of
/// propose_curves and reinsert.
template <int D>
[[nodiscard]] Outcome<ReinsertedNodes<D>> reinsert_nodes(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                         const ReinsertNodesOptions& options, const Around& around);

struct CurveMeshOptions {
    ProposeOptions curve = {};
    RepairOptions repair = {};
};

/// What is asked of a mesh that may be anyone's: the bound is 0, not that of the meshes which Camber makes.
struct MeshCheckOptions {
    double min_scaled_jacobian = 0;
    ExamineOptions examine = {};
};

/// Walls that pass through each other, and elements that overlap; `mesh` is the one that was looked at, with its
/// boundary listed.
template <int D>
struct CheckedWalls {
    QuadraticMesh<D> mesh;
    Crossings crossings;
    Overlaps<D> overlaps = {};  ///< not looked at where the mesh lists elements twice
};

/// What is right and wrong with a mesh, as it is.
template <int D>
struct MeshCheck {
    Soundness soundness;
    QuadraticMesh<D> mesh;  ///< a linear one elevated
    Validation<D> validation;
    /// None where fatal defects forbid the look, or the boundary is not listed and cannot be.
    std::optional<CheckedWalls<D>> walls;

    [[nodiscard]] bool all_good() const {
        return soundness.sound() && validation.all_valid() && walls && walls->crossings.crossing == 0 &&
               walls->overlaps.overlapping == 0;
    }
};

/// What `camber check` looks at, in one call. Steps: examine, validate, cross. Errors: unsupported (no simplices of
/// degree 1 or 2), memory, stopped.
template <int D>
[[nodiscard]] Outcome<MeshCheck<D>> check_mesh(const Mesh<D>& mesh, const MeshCheckOptions& options,
                                               const Around& around);

}  // namespace camber
