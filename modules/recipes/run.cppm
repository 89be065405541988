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

/// Sources of a run beside its mesh.
template <int D>
struct RunSources {
    GeometrySource geometry = {};
    AvailableMemory memory = {};
    const SolutionSource* solution = nullptr;   ///< null: no stage places nodes by a solution
    const MeshGoal<D>* goal = nullptr;          ///< geometry, metric and solution as values; null: those of the config
    std::shared_ptr<Ranks> ranks = one_rank();  ///< share the work by blocks
    RunEnd end = RunEnd::whole;
    OrderingOptions ordering = {};
};

/// One run in D dimensions as its steps see it: the pipeline, the sources, the state that steps read and change, and
/// the report that they add to.
template <int D>
class Runner {
  public:
    Runner(const config::Pipeline& config, State<D> state, RunSources<D> sources, std::span<const MetricFile> files,
           const StepWrapper& around)
        : config(config), files(files), sources(std::move(sources)), state(std::move(state)), around_(around) {}

    const config::Pipeline& config;
    const std::span<const MetricFile> files;  ///< all metric files that the pipeline names
    const RunSources<D> sources;
    State<D> state;
    Report report;

    /// Parts of the state that exist by the order of the steps (check_order).
    [[nodiscard]] Quadratic<D>& quadratic() { return std::get<Quadratic<D>>(state.mesh); }
    [[nodiscard]] Plan<D>& plan() { return std::get<Plan<D>>(quadratic().plan); }
    [[nodiscard]] const BackMesh<D>* field() const { return state.field ? &*state.field : nullptr; }

    template <class F>
    auto step(std::string_view name, F&& f) {
        return run_step(around_, name, std::forward<F>(f));
    }
    [[nodiscard]] const StepWrapper& around() const { return around_; }
    /// The step of the stage with these options.
    template <class Options, class F>
    auto step_of(const Options&, F&& f) {
        return step(std::get<Step<Options>>(step_table).name, std::forward<F>(f));
    }
    void note(std::string sentence) { report.notices.push_back(std::move(sentence)); }

  private:
    const StepWrapper& around_;
};

// ---------------------------------------------------------------- steps, which change the state of a run

/// Runs one step: one overload for each row of `step_table`. Errors: those of its verb, and stopped.
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

/// Vertices of the boundary brought onto the CAD model, where the config wants that; before the first stage.
template <int D>
[[nodiscard]] Outcome<Done> move_vertices(Runner<D>& run);

/// Features and geometry as a config describes them, of a mesh that nothing has changed.
template <int D>
struct DescribedBoundary {
    Boundary<D> boundary;
    BoundaryReport report;
};
/// Errors (usage): a geometry that is not the mesh's.
template <int D>
[[nodiscard]] Outcome<DescribedBoundary<D>> boundary_by_config(const config::Pipeline& pipeline,
                                                               const GeometrySource& source, const LinearMesh<D>& mesh,
                                                               const EdgeSet<D>& edges, const Execution& execution);

/// The boundary as the config describes it, before a stage that curves or changes topology; `curves`: see
/// make_geometry. Errors (usage): a geometry that is not the mesh's.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                     std::span<const LagrangeNode<D>> curves = {});

/// Distances that the goal or the pipeline requires.
template <int D>
[[nodiscard]] std::vector<DistanceBound> required_distances(const Runner<D>& run);
template <int D>
[[nodiscard]] BoundedDistances bounded_distances(const Runner<D>& run);

/// Report of the config's metric when it is made.
struct MetricReports {
    std::optional<MetricReport> report;
    Notices notices;
};
/// The config's metric as recipes take it. Errors, when it is made, name the JSON path of the metric or the operation,
/// or the file. All arguments are asked then.
template <int D>
[[nodiscard]] MetricSource<D> metric_for_curving(const Runner<D>& run, const QuadraticMesh<D>& mesh,
                                                 const Boundary<D>& boundary, MetricReports& metric_report);
/// The same as a field on the mesh itself, straight or with its curves.
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

/// Before any work of passes: what those of the config will make of the run's mesh; none where none of them splits.
/// Errors: those of describe_boundary and make_own_field; memory: more than there is room for.
template <int D>
[[nodiscard]] Outcome<std::optional<Growth>> requested_growth(Runner<D>& run);

/// The field that passes of the config would go by, on the run's mesh as it is. Errors: those of describe_boundary and
/// make_own_field.
template <int D>
[[nodiscard]] Outcome<OwnField<D>> requested_field(Runner<D>& run);

/// A mesh that passes have changed becomes one as any other; nothing where none has.
template <int D>
[[nodiscard]] Outcome<Done> finish(Runner<D>& run);

/// A mesh that was read with its curves brings what else the stage `curve` proposes: its nodes become the plan where
/// there is none.
template <int D>
[[nodiscard]] Outcome<Done> adopt_own_nodes(Runner<D>& run);

/// Within a stage: the bound that it asks for, or that a stage before did, or the recommended one.
template <int D>
[[nodiscard]] JacobianBound bound_for(Runner<D>& run, const JacobianBound& of_stage);

/// Within a stage: the plan is judged to that bound, as the last stage judged it, or anew.
template <int D>
[[nodiscard]] Outcome<Done> judge_plan(Runner<D>& run, double bound, const Execution& execution);

/// The verdicts as they are now: told, and those of before as long as nothing was corrected.
template <int D>
void report_verdicts(Runner<D>& run, const Validation<D>& validation);

template <int D>
void report_curves(Runner<D>& run, const ProposedCurves<D>& result, const ProposeOptions& options);

/// The field goes to the run's state, the rest to a plan.
template <int D>
[[nodiscard]] CurvingTarget<D> store_field(Runner<D>& run, Boundary<D> boundary, ProposedCurves<D> result,
                                           CurvingAim aim);

/// The last step: what the report says of the end, and the lengths after correction where they were measured.
template <int D>
[[nodiscard]] Outcome<std::optional<EdgeLengths>> measure(Runner<D>& run);

// ---------------------------------------------------------------- runs

/// A metric that is made for the run's solution.
struct SolutionMetricInput {
    config::SolutionMetric requested;
    std::vector<Solution> intersect;  ///< rows of its files, at the input's vertices
    std::string path;                 ///< in the config, for errors
};

/// Inputs of a run beside the config: files already read.
struct Inputs {
    DecodedMesh mesh;
    std::optional<Solution> metric = {};         ///< of the metric file, when the config names one
    std::optional<MetricMesh> metric_mesh = {};  ///< that it speaks of, where its rows are not at the input's vertices
    std::vector<MetricFile> operands = {};       ///< metric files that the operations intersect with
    OrderingOptions ordering = {};               ///< when the stages work in an order of their own
    GeometrySource geometry = {};
    AvailableMemory memory = {};
    std::vector<NamedField> fields = {};                     ///< of the solution, on that mesh
    std::vector<SolutionMetricInput> solution_metrics = {};  ///< those of the config that are made for these
    std::shared_ptr<Ranks> ranks = one_rank();               ///< who share what goes by blocks
    RunEnd end = RunEnd::whole;
};

/// Result of a run in D dimensions.
template <int D>
struct MeshRun {
    Mesh<D> mesh;                               ///< committed, or the last state if nothing was
    Report report;                              ///< `meets_requirements`: the result is the requested one
    std::optional<Inherited<D>> remeshed = {};  ///< geometry and metric at the vertices of a mesh that passes changed
    MeshFields fields = {};                     ///< if the output shows them
    std::optional<Solution> metric = {};        ///< if the output requests it and the steps made one
    std::optional<FinishedRows<D>> rows = {};   ///< those of this rank, of a run that ends in rows; the mesh is empty
};
/// Runs the steps of a pipeline on a mesh, which is made sound first (`prepare`). Errors: a step that lacks what it
/// needs (check_order), those of the steps with their JSON path, stopped, memory.
template <int D>
[[nodiscard]] Outcome<MeshRun<D>> run_steps(StageInputs<D> input, const config::Pipeline& pipeline,
                                            RunSources<D> sources, const StepWrapper& around);

struct Run {
    AnyMesh mesh;  ///< committed, or the last state when nothing was
    Report report;
    MeshFields fields;                    ///< empty unless the config's output shows them
    std::optional<Solution> metric = {};  ///< at the vertices, if the config's output wants it and the stages made one
    std::vector<NamedField> solution = {};  ///< the input's fields, if the config's output has a place for them
    std::vector<std::string> details = {};  ///< notices of the report that are printed with --verbose only
    /// Rows of this rank, of a run that ends in rows; the mesh is empty then.
    std::variant<std::monostate, FinishedRows<2>, FinishedRows<3>> rows = {};
};

/// True if several ranks may end a run with a share of the mesh each: nothing but the mesh is requested, and blocks
/// are the last that changes it.
[[nodiscard]] bool may_end_in_rows(const config::Pipeline& pipeline);

/// True if an output shows fields of the run: a VTU file, a page.
[[nodiscard]] bool shows_fields(const config::Output& output);
/// True if it has a place for fields of a solution: a file of their own, or with the mesh.
[[nodiscard]] bool carries_fields(const config::Output& output);
[[nodiscard]] bool places_by_solution(const config::Pipeline& pipeline);
[[nodiscard]] bool preserves_elements(const config::Pipeline& pipeline);

/// True if the mesh is of degree 2 and not straight: no stage `elevate` takes it.
[[nodiscard]] bool is_curved(const AnyMesh& mesh);

/// The mesh prepared, then the stages of a config, one after the other. Errors name the stage's JSON path.
[[nodiscard]] Outcome<Run> run_pipeline(const config::Pipeline& pipeline, Inputs inputs, const StepWrapper& around);

/// Predicts the mesh that passes make, where no stage but `elevate` comes before them; none: no stage splits, or the
/// metric is not known before other stages run. Errors: those of the run so far, and memory.
[[nodiscard]] Outcome<std::optional<Growth>> planned_growth(const config::Pipeline& pipeline, Inputs inputs,
                                                            const StepWrapper& around);

/// The metric of a config, its operations done, at the vertices of the input's mesh; no stage is run. Errors: those of
/// the run so far.
struct MetricResult {
    Solution metric;
    MetricReport report;
    std::vector<std::string> notices;
};
[[nodiscard]] Outcome<MetricResult> compute_metric(const config::Pipeline& pipeline, Inputs inputs,
                                                   const StepWrapper& around);

/// The mesh of a config's shape.
[[nodiscard]] Outcome<DecodedMesh> generate_shape(const config::Shape& shape, const Execution& execution = {});

/// Size of a run before its first step.
struct PlanSize {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, elements = 0, facets = 0;
    std::size_t edges = 0;       ///< estimated by Euler's formula from the others, exact for a ball
    std::size_t peak_bytes = 0;  ///< estimated_peak_bytes
};
[[nodiscard]] PlanSize plan_size(const AnyMesh& mesh);

// ---------------------------------------------------------------- order of the mesh

// A mesh in an order that makes stages slow is renumbered before the first stage, and its results after the last one.

/// The order to work in; nothing where the mesh's own will do, or where stages change the straight mesh: what they make
/// has an order of its own. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::optional<BetterOrder>> working_order(const StageInputs<D>& inputs,
                                                                std::span<const config::Stage> stages,
                                                                const OrderingOptions& options,
                                                                const Execution& execution);

/// Renumbers the inputs. Metric files whose rows are not the mesh's vertices stay: they are refused later. Errors:
/// memory, stopped.
template <int D>
[[nodiscard]] Outcome<StageInputs<D>> in_working_order(StageInputs<D> inputs, const Renumbering& order,
                                                       const Execution& execution);

/// Renumbers the results as the input: mesh, fields, metric, and elements of the report. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<MeshRun<D>> in_input_order(MeshRun<D> run, const Renumbering& order, const Execution& execution);

/// Renumbers the entity of an error.
template <int D>
[[nodiscard]] Error in_input_order(Error error, const Renumbering& order);

// ---------------------------------------------------------------- meshes in blocks

/// Returns the options of the first stage `curve` for blocks; none: the pipeline requests no blocks.
[[nodiscard]] std::optional<CurveByBlocks> requested_blocks(const config::Pipeline& pipeline);

/// Sources of a run by blocks.
struct BlockSources {
    GeometrySource geometry = {};
    std::vector<MetricFile> files = {};  ///< one row per vertex of the whole mesh
    BlockOptions blocks = {};
    std::shared_ptr<Ranks> ranks = one_rank();
};
/// Share of this rank in the result; the report is that of the whole mesh.
template <int D>
struct BlocksRun {
    CurvedBlocks<D> curved;
    Report report;
};
/// Runs the steps of a pipeline on a mesh in blocks; all ranks call it. Errors (unsupported): steps other than elevate,
/// curve, validate, relax and commit, and options of these that need the whole mesh; those of the steps, of any rank.
template <int D>
[[nodiscard]] Outcome<BlocksRun<D>> run_steps(const MeshRows<D>& rows, const config::Pipeline& pipeline,
                                              const BlockSources& sources, const StepWrapper& around);

}  // namespace camber::run

/// Recipes: runs of fixed lists of steps on values, one call each.
export namespace camber {

/// Curves a straight mesh: what `camber curve` does. Steps: elevate, curve, validate, relax, commit. The result may be
/// invalid: see `report`. Its order is that of the input (camber.ordering makes a better one). Errors: input (no mesh,
/// see `prepare`), unsupported (no simplices of degree 1), options out of range (usage), those of the goal, stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<run::MeshRun<D>> curve_mesh(Mesh<D> mesh, const MeshGoal<D>& goal,
                                                  const CurveMeshOptions& options, const StepWrapper& around);

/// Options of remesh_mesh.
struct RemeshMeshOptions {
    ToMetricOptions passes = {};
    config::RemeshObjective objective = config::RemeshObjective::automatic;  ///< degree 2: nodes of inner edges
    config::GeometryBound geometry_bound = config::GeometryBound::by_default;
};

/// Brings a mesh of degree 1 or 2 to a metric: what `camber remesh` does. Step: remesh. Errors: as curve_mesh, with
/// degree 2.
template <int D>
[[nodiscard]] Outcome<run::MeshRun<D>> remesh_mesh(Mesh<D> mesh, const MeshGoal<D>& goal,
                                                   const RemeshMeshOptions& options, const StepWrapper& around);

}  // namespace camber
