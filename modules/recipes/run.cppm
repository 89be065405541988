module;
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
export module camber.recipes:run;
import camber.core;
import camber.ordering;
import camber.metric;
import camber.validity;
import camber.io;
import camber.surface;
import camber.cad;
import camber.curving;
import camber.stages;
import camber.distributed;
import :measurements;
import :report;
import :state;
import :values;

export namespace camber::run {

template <int D>
struct RunSources {
    GeometrySource geometry = {};
    AvailableMemory memory = {};
    const SolutionSource* solution = nullptr;
    const MeshGoal<D>* goal = nullptr;          ///< geometry, metric and solution as values; null: those of the config
    std::shared_ptr<Ranks> ranks = one_rank();  ///< ranks that share the work by blocks
    RunEnd end = RunEnd::whole;
    OrderingOptions ordering = {};
};

/// A run in D dimensions: pipeline, sources, state and report.
template <int D>
class Runner {
  public:
    Runner(const config::Pipeline& config, State<D> state, RunSources<D> sources, std::span<const MetricFile> files,
           const StepWrapper& around)
        : config(config), files(files), sources(std::move(sources)), state(std::move(state)), around_(around) {}

    const config::Pipeline& config;
    const std::span<const MetricFile> files;
    const RunSources<D> sources;
    State<D> state;
    Report report;

    /// Parts of the state that exist in a valid order of steps (check_order).
    [[nodiscard]] Quadratic<D>& quadratic() { return std::get<Quadratic<D>>(state.mesh); }
    [[nodiscard]] Plan<D>& plan() { return std::get<Plan<D>>(quadratic().plan); }
    [[nodiscard]] const BackMesh<D>* field() const { return state.field ? &*state.field : nullptr; }

    template <class F>
    auto step(std::string_view name, F&& f) {
        return run_step(around_, name, std::forward<F>(f));
    }
    [[nodiscard]] const StepWrapper& around() const { return around_; }
    template <class Options, class F>
    auto step_of(const Options&, F&& f) {
        return step(std::get<Step<Options>>(step_table).name, std::forward<F>(f));
    }
    void note(std::string sentence) { report.notices.push_back(std::move(sentence)); }

  private:
    const StepWrapper& around_;
};

/// One overload for each row of `step_table`. Errors: those of the step, and stopped.
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Elevate& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Curve& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Validate& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Relax& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Commit& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Reinsert& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Collapse& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Split& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Swap& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Smooth& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Mend& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Remesh& options);

/// Moves boundary vertices onto the CAD model before the first stage, if the config requests it.
template <int D>
[[nodiscard]] Outcome<Done> move_vertices(Runner<D>& run);

/// Features and geometry of the mesh before any change.
template <int D>
struct DescribedBoundary {
    Boundary<D> boundary;
    BoundaryReport report;
};
/// Errors (usage): the geometry does not fit the mesh.
template <int D>
[[nodiscard]] Outcome<DescribedBoundary<D>> boundary_by_config(const config::Pipeline& pipeline,
                                                               const GeometrySource& source, const LinearMesh<D>& mesh,
                                                               const EdgeSet<D>& edges, const Execution& execution);

/// Describes the boundary for a stage that curves or changes topology. `curves`: see make_geometry. Errors (usage): the
/// geometry does not fit the mesh.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                     std::span<const LagrangeNode<D>> curves = {});

template <int D>
[[nodiscard]] std::vector<DistanceBound> required_distances(const Runner<D>& run);
template <int D>
[[nodiscard]] BoundedDistances bounded_distances(const Runner<D>& run);

/// Set when the metric is made.
struct MetricReports {
    std::optional<MetricReport> report;
    Notices notices;
};
/// The config's metric, made when it is needed; the arguments must live until then. Errors name the JSON path of the
/// metric or the operation, or the file.
template <int D>
[[nodiscard]] MetricSource<D> metric_for_curving(const Runner<D>& run, const QuadraticMesh<D>& mesh,
                                                 const Boundary<D>& boundary, MetricReports& metric_report);
/// The config's metric as a field on the mesh itself, straight or curved.
template <int D>
struct OwnField {
    BackMesh<D> back;
    MetricReport report;
    MetricOrigin origin = MetricOrigin::natural;
};
template <int D>
[[nodiscard]] Outcome<OwnField<D>> make_own_field(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Boundary<D>& boundary);
template <int D>
[[nodiscard]] Outcome<OwnField<D>> make_own_field(Runner<D>& run, const QuadraticMesh<D>& mesh,
                                                  const Boundary<D>& boundary);
template <int D>
void report_metric(Runner<D>& run, MetricReports metric_report);

/// Predicts the mesh that passes make, before they start; none: no pass splits. Errors: those of describe_boundary and
/// make_own_field; memory: not enough.
template <int D>
[[nodiscard]] Outcome<std::optional<Growth>> requested_growth(Runner<D>& run);

/// Field for the passes of the config on the current mesh.
template <int D>
[[nodiscard]] Outcome<OwnField<D>> requested_field(Runner<D>& run);

/// No effect unless passes changed the mesh.
template <int D>
[[nodiscard]] Outcome<Done> finish(Runner<D>& run);

/// Makes the nodes of a curved input mesh its plan, if there is no plan.
template <int D>
[[nodiscard]] Outcome<Done> adopt_own_nodes(Runner<D>& run);

/// Bound for a stage: its own, else that of an earlier stage, else the recommended one.
template <int D>
[[nodiscard]] JacobianBound bound_for(Runner<D>& run, const JacobianBound& of_stage);

/// Validates the plan for a bound, unless the last stage did.
template <int D>
[[nodiscard]] Outcome<Done> judge_plan(Runner<D>& run, double bound, const Execution& execution);

/// Reports the current verdicts; until the first correction they are also those before it.
template <int D>
void report_verdicts(Runner<D>& run, const Validation<D>& validation);

template <int D>
void report_curves(Runner<D>& run, const ProposedCurves<D>& result, const ProposeOptions& options);

/// Stores the field in the run's state; the result is part of a plan.
template <int D>
[[nodiscard]] CurvingTarget<D> store_field(Runner<D>& run, Boundary<D> boundary, ProposedCurves<D> result,
                                           CurvingAim aim);

/// Last step. Returns lengths after correction, if they were measured.
template <int D>
[[nodiscard]] Outcome<std::optional<EdgeLengths>> measure(Runner<D>& run);

struct SolutionMetricInput {
    config::SolutionMetric requested;
    std::vector<Solution> intersect;  ///< rows of its files, at the input's vertices
    std::string path;                 ///< its path in the config, for errors
};

/// Files are already read.
struct Inputs {
    DecodedMesh mesh;
    std::optional<Solution> metric = {};
    std::optional<MetricMesh> metric_mesh = {};  ///< mesh of the metric, if its rows are not at the input's vertices
    std::vector<MetricFile> operands = {};       ///< metric files that the operations intersect with
    OrderingOptions ordering = {};               ///< conditions for another order of work
    GeometrySource geometry = {};
    AvailableMemory memory = {};
    std::vector<NamedField> fields = {};
    std::vector<SolutionMetricInput> solution_metrics = {};
    std::shared_ptr<Ranks> ranks = one_rank();
    RunEnd end = RunEnd::whole;
};

template <int D>
struct MeshRun {
    Mesh<D> mesh;  ///< committed mesh, or the last state
    Report report;
    std::optional<Inherited<D>> remeshed = {};  ///< geometry and metric at the vertices, if passes changed the mesh
    MeshFields fields = {};                     ///< if the output shows them
    std::optional<Solution> metric = {};        ///< if the output requests it and the steps made one
    std::optional<FinishedRows<D>> rows = {};   ///< rows of this rank if the run ends in rows; the mesh is then empty
};
/// Prepares the mesh first. Errors: those of check_order, those of the steps with their JSON path, stopped, memory.
template <int D>
[[nodiscard]] Outcome<MeshRun<D>> run_steps(StageInputs<D> input, const config::Pipeline& pipeline,
                                            RunSources<D> sources, const StepWrapper& around);

struct Run {
    AnyMesh mesh;  ///< committed mesh, or the last state
    Report report;
    MeshFields fields;                      ///< empty unless the output shows them
    std::optional<Solution> metric = {};    ///< at the vertices, if the output requests it and the stages made one
    std::vector<NamedField> solution = {};  ///< fields of the input, if the output stores them
    std::vector<std::string> details = {};  ///< notices of the report that are printed with --verbose only
    /// Rows of this rank if the run ends in rows; the mesh is then empty.
    std::variant<std::monostate, FinishedRows<2>, FinishedRows<3>> rows = {};
};

/// True if ranks may end with their shares: only the mesh is requested, and blocks are the last to change it.
[[nodiscard]] bool may_end_in_rows(const config::Pipeline& pipeline);

/// True for VTU files and pages.
[[nodiscard]] bool shows_fields(const config::Output& output);
/// True if the output stores fields of a solution, in their own file or with the mesh.
[[nodiscard]] bool carries_fields(const config::Output& output);
[[nodiscard]] bool places_by_solution(const config::Pipeline& pipeline);
[[nodiscard]] bool preserves_elements(const config::Pipeline& pipeline);

/// True if the mesh is quadratic and not straight; `elevate` rejects it.
[[nodiscard]] bool is_curved(const AnyMesh& mesh);

/// Prepares the mesh first. Errors name the stage's JSON path.
[[nodiscard]] Outcome<Run> run_pipeline(const config::Pipeline& pipeline, Inputs inputs, const StepWrapper& around);

/// Predicts the mesh that passes make, if only `elevate` precedes them. None: no stage splits, or the metric needs
/// other stages first. Errors: those of the run so far, and memory.
[[nodiscard]] Outcome<std::optional<Growth>> planned_growth(const config::Pipeline& pipeline, Inputs inputs,
                                                            const StepWrapper& around);

/// Metric after the operations of a config at the input's vertices; no stage runs. Errors: those of the run so far.
struct MetricResult {
    Solution metric;
    MetricReport report;
    std::vector<std::string> notices;
};
[[nodiscard]] Outcome<MetricResult> compute_metric(const config::Pipeline& pipeline, Inputs inputs,
                                                   const StepWrapper& around);

[[nodiscard]] Outcome<DecodedMesh> generate_shape(const config::Shape& shape, const Execution& execution = {});

struct PlanSize {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, elements = 0, facets = 0;
    std::size_t edges = 0;       ///< estimated from the others by Euler's formula; exact for a ball
    std::size_t peak_bytes = 0;  ///< see estimated_peak_bytes
};
[[nodiscard]] PlanSize plan_size(const AnyMesh& mesh);

// If the order of a mesh makes stages slow, it is renumbered before the first stage, and its results after the last.

/// Order to work in. None: the mesh's order is good enough, or stages change the straight mesh and so its order.
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::optional<BetterOrder>> working_order(const StageInputs<D>& inputs,
                                                                std::span<const config::Stage> stages,
                                                                const OrderingOptions& options,
                                                                const Execution& execution);

/// Metric files without one row per vertex are unchanged; they are rejected later. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<StageInputs<D>> in_working_order(StageInputs<D> inputs, const Renumbering& order,
                                                       const Execution& execution);

/// Renumbers mesh, fields, metric and reported elements. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<MeshRun<D>> in_input_order(MeshRun<D> run, const Renumbering& order, const Execution& execution);

template <int D>
[[nodiscard]] Error in_input_order(Error error, const Renumbering& order);

/// Block options of the first stage `curve`; none: no blocks are requested.
[[nodiscard]] std::optional<CurveByBlocks> requested_blocks(const config::Pipeline& pipeline);

struct BlockSources {
    GeometrySource geometry = {};
    std::vector<MetricFile> files = {};
    BlockOptions blocks = {};
    std::shared_ptr<Ranks> ranks = one_rank();
};
/// The report is that of the whole mesh.
template <int D>
struct BlocksRun {
    CurvedBlocks<D> curved;
    Report report;
};
/// Runs the steps of a pipeline on a mesh in blocks; all ranks call it. Errors: unsupported (steps other than elevate,
/// curve, validate, relax and commit, or options that need the whole mesh); those of the steps on any rank.
template <int D>
[[nodiscard]] Outcome<BlocksRun<D>> run_steps(const MeshRows<D>& rows, const config::Pipeline& pipeline,
                                              const BlockSources& sources, const StepWrapper& around);

}  // namespace camber::run

/// Recipes: fixed lists of steps on values, one call each.
export namespace camber {

/// Curves a straight mesh, as `camber curve`. Steps: elevate, curve, validate, relax, commit. The result may be
/// invalid: see `report`. It has the input's order (camber.ordering makes a better one). Errors: input (no mesh, see
/// `prepare`), unsupported (no simplices of degree 1), usage (options out of range), those of the goal, stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<run::MeshRun<D>> curve_mesh(Mesh<D> mesh, const MeshGoal<D>& goal,
                                                  const CurveMeshOptions& options, const StepWrapper& around);

struct RemeshMeshOptions {
    ToMetricOptions passes = {};
    config::RemeshObjective objective = config::RemeshObjective::automatic;
    config::GeometryBound geometry_bound = config::GeometryBound::by_default;
};

/// Remeshes a mesh of degree 1 or 2 for a metric, as `camber remesh`. Errors: those of curve_mesh.
template <int D>
[[nodiscard]] Outcome<run::MeshRun<D>> remesh_mesh(Mesh<D> mesh, const MeshGoal<D>& goal,
                                                   const RemeshMeshOptions& options, const StepWrapper& around);

}  // namespace camber
