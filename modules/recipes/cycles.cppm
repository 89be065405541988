module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>
export module camber.recipes:cycles;
import camber.core;
import camber.solution_metric;
import :fields;
import :report;
import :run;
import :state;
import :values;

/// Cycles of a pipeline (config "adapt"), and their table.
export namespace camber::run {

struct CycleFiles {
    std::string folder;
    std::string mesh, solution, guess;  ///< the mesh, the solver's solution on it, and its initial guess
    std::string said;                   ///< output of the solver
    std::string report, view;           ///< `view`: mesh with fields, for ParaView
    std::string vtu, metric, carried, plots, page;
};
/// `folder`: contains the folders of all cycles.
[[nodiscard]] CycleFiles files_of_cycle(const config::Pipeline& pipeline, const std::string& folder);
/// "cycle-007".
[[nodiscard]] std::string name_of_cycle(int cycle);

/// Stages of a cycle: remeshing, and for quadratic meshes also curving (for the solution if the metric is made for it).
[[nodiscard]] config::Pipeline steps_of_cycles(int degree, const config::Metric& metric);
/// The solver runs on the first mesh. Stages that preserve the topology make it; without a solver, none.
[[nodiscard]] config::Pipeline first_pipeline(const config::Pipeline& pipeline, const CycleFiles& into);
[[nodiscard]] config::Pipeline cycle_pipeline(const config::Pipeline& pipeline, int cycle, const CycleFiles& first,
                                              const CycleFiles& before, const CycleFiles& into);
[[nodiscard]] std::vector<std::string> solver_command(const config::Adaptation& adapt, int cycle,
                                                      const CycleFiles& files);

/// Adjusts a pipeline to its input mesh.
using Fit = std::function<Outcome<config::Pipeline>(config::Pipeline, const AnyMesh&)>;

struct InputDegree {
    int degree = 0;                          ///< 0: any
    std::string_view option = "the degree";  ///< option that requires the degree, for errors
};
/// A curved mesh is not elevated; as first mesh it is only validated. Errors of the result (input): wrong degree.
[[nodiscard]] Fit fit_of_cycle(int cycle, const InputDegree& required = {});

/// Errors (usage): stages and options that cannot be repeated in cycles.
[[nodiscard]] Outcome<Done> check_cycles(const config::Pipeline& pipeline);

/// Error in the degree of the mesh.
struct CycleError {
    double l2 = 0, h1 = 0;

    static void fields(auto& s, auto& f) {
        f("l2", s.l2, "L2 norm");
        f("h1", s.h1, "H1 seminorm");
    }
};

enum class DistanceBoundBy : std::uint8_t { expected_error, config };
[[nodiscard]] constexpr auto words(DistanceBoundBy) {
    return words_of(Word{DistanceBoundBy::expected_error, "expected_error"}, Word{DistanceBoundBy::config, "config"});
}

/// Distance of the boundary from its geometry, at the facet with the largest ratio of distance to bound.
struct BoundaryDistance {
    double bound = 0, reached = 0;
    DistanceBoundBy by = DistanceBoundBy::expected_error;

    static void fields(auto& s, auto& f) {
        f("bound", s.bound, "bound on the distance", unit("model units"));
        f("reached", s.reached, "distance", unit("model units"));
        f("origin", s.by, "origin of the bound: `config` or `expected_error`");
    }
};

/// A row of the table. Shares and qualities are measured in the metric that made the mesh.
struct CycleRow {
    int cycle = 0;
    std::size_t unknowns = 0, elements = 0;
    std::string problem = {};
    double complexity_target = 0, complexity = 0;  ///< 0: not requested; no metric
    double unit_before = 0, unit_edges = 0;
    double worst_quality = 0, mean_quality = 0;
    double smallest_jacobian = 1;
    std::optional<double> expected = {};  ///< by `curve` (objective `solution`), or for a straight mesh from the
                                          ///< solution
    std::optional<CycleError> interpolated = {}, solved = {};  ///< if the exact solution is known
    std::optional<BoundaryDistance> boundary = {};             ///< if it is bounded
    double seconds = 0, solve_seconds = 0;
    ErrorQuantity error_of = ErrorQuantity::values;
    bool is_valid = true;
    std::vector<std::string> misses = {};

    static void fields(auto& s, auto& f) {
        f("cycle", s.cycle, "number of the cycle; 0: the first mesh");
        f("unknowns", s.unknowns, "number of nodes in the degree of the interpolants");
        f("elements", s.elements, "number of elements");
        f("problem", s.problem, "exact solution and solver command");
        f("complexity_target", s.complexity_target, "requested complexity of the metric; 0: none");
        f("complexity", s.complexity, "complexity of the metric; 0: no metric");
        f("unit_edges_before", s.unit_before, "share of unit edges in the mesh before the passes");
        f("unit_edges", s.unit_edges, "share of unit edges in the mesh");
        f("min_quality", s.worst_quality, "minimum quality of its elements");
        f("mean_quality", s.mean_quality, "mean quality of its elements");
        f("min_scaled_jacobian", s.smallest_jacobian, "minimum scaled Jacobian of its elements");
        f("expected_error", s.expected, "expected L2 error");
        f("interpolation_error", s.interpolated, "error of the exact solution's interpolant");
        f("solution_error", s.solved, "error of the solver's first scalar field");
        f("boundary_distance", s.boundary, "distance of the boundary from its geometry");
        f("seconds", s.seconds, "elapsed time of the steps", unit("s"));
        f("solve_seconds", s.solve_seconds, "elapsed time of the solver", unit("s"));
        f("error_of", s.error_of, "error that the metric is made for", shown_if(s.error_of != ErrorQuantity::values));
        f("valid", s.is_valid, "true if all elements are certified valid", shown_if(!s.is_valid));
        f("misses", s.misses, "reasons why the mesh is not the requested one", unless_empty);
    }
};
struct CycleRun {
    Run run;
    std::string miss;  ///< reports that the complexity is not the requested one; empty: it is
};
/// The row lacks the values of `add_errors`.
[[nodiscard]] CycleRow row_of(int cycle, const config::Pipeline& pipeline, const CycleRun& outcome);

/// Adds to the row of a mesh:
/// - the number of unknowns in degree 2, if the mesh, the solution metric or the solver's fields have degree 2;
/// - the L2 error expected from the solver's fields (empty: none) on a straight mesh; otherwise `curve` computes it;
/// - errors of the exact solution's interpolant and of the first scalar field, if the exact solution is known.
///
/// Errors: an expression that cannot be parsed or is not finite somewhere, a wrong number of weights (usage); no scalar
/// field (input); those of `known_solution`.
[[nodiscard]] Outcome<Done> add_errors(CycleRow& row, const AnyMesh& mesh, std::span<const NamedField> solved,
                                       const config::Pipeline& pipeline, const Execution& execution);

/// Runs a cycle with \p execute. While elements are not certified valid, repeats it with a smaller complexity, at most
/// three times: halfway (in the logarithm) to that of the cycle before, or 10 % less if the two are close. Each
/// repetition adds a notice. \p rows: earlier cycles. Errors: those of \p execute.
[[nodiscard]] Outcome<CycleRun> run_cycle(config::Pipeline pipeline, std::span<const CycleRow> rows,
                                          const std::function<Outcome<Run>(const config::Pipeline&)>& execute);

/// If the solution is known, the error of its interpolant in L2, or in H1 if the metric is for gradients; otherwise the
/// expected L2 error, if any.
[[nodiscard]] std::optional<double> error_of_mesh(const CycleRow& row, const config::Adaptation& adapt);
/// Row of the result: the last valid mesh (`result` "last"), or the valid mesh of the last complexity and problem with
/// the smallest error. Meshes that miss a requirement come last.
[[nodiscard]] std::size_t row_of_result(std::span<const CycleRow> rows, const config::Adaptation& adapt);
/// Reason to stop: the minimum error has not fallen, or, without errors, meshes come no closer to unit meshes in the
/// metric of their solution. Empty: more cycles are needed.
[[nodiscard]] std::string reason_to_end(std::span<const CycleRow> rows, const config::Adaptation& adapt);
/// Notes if the result is not the last mesh, its boundary is too far away, or unit edges or the minimum quality fell.
[[nodiscard]] std::vector<std::string> notes_on_result(std::span<const CycleRow> rows, const config::Adaptation& adapt);

/// Fields are those of the solver, if it was called.
struct FinishedCycle {
    int cycle = 0;
    CycleFiles files = {};
    CycleRun cycle_run = {};
};

/// Stores meshes, solutions and the table by file names.
class CycleStore {
  public:
    CycleStore() = default;
    CycleStore(const CycleStore&) = delete;
    CycleStore& operator=(const CycleStore&) = delete;
    CycleStore(CycleStore&&) = delete;
    CycleStore& operator=(CycleStore&&) = delete;
    virtual ~CycleStore() = default;

    [[nodiscard]] virtual std::vector<CycleRow> rows() const = 0;
    [[nodiscard]] virtual CycleFiles files(int cycle) const = 0;
    [[nodiscard]] virtual Outcome<CycleFiles> begin(int cycle) = 0;
    /// Runs a pipeline on stored meshes, and writes the files. `fit`: applied if the input is not a stored mesh.
    [[nodiscard]] virtual Outcome<Run> run(const config::Pipeline& pipeline, const Fit& fit) = 0;
    /// Stores a finished cycle, whose row is the last of `rows`.
    [[nodiscard]] virtual Outcome<Done> add(FinishedCycle finished, std::span<const CycleRow> rows) = 0;
    /// Called when the result changes.
    [[nodiscard]] virtual Outcome<Done> deliver(int cycle) = 0;
};

struct SolverCall {
    const AnyMesh& mesh;
    const std::vector<NamedField>& guess;  ///< solution of the previous cycle, on this mesh; empty in cycle 0
    int cycle;
    const CycleFiles& files;
};
struct SolverResult {
    AnyMesh mesh;
    std::vector<NamedField> fields;
    double seconds = 0;
};
using CycleSolver = std::function<Outcome<SolverResult>(const SolverCall&)>;

/// Functions may be empty.
struct CycleListener {
    std::function<void(const Run&)> on_mesh = {};
    /// Called when the mesh of a row is stored. An error ends the loop.
    std::function<Outcome<Done>(const CycleRow&)> row_added = {};
};

struct EndedCycles {
    std::vector<CycleRow> rows;
    std::size_t result = 0;
    std::string reason;  ///< reason to stop early; empty: all cycles were run
    std::vector<std::string> notes;

    /// False: the last mesh has elements that are not certified valid, and the result is the previous mesh, if any.
    [[nodiscard]] bool is_valid() const { return rows.back().is_valid; }
};

/// `solver` is called on each valid mesh; empty: the pipeline has the solution. Errors: those of check_cycles, the
/// store, the solver, the listener and add_errors.
[[nodiscard]] Outcome<EndedCycles> adapt(const config::Pipeline& pipeline, CycleStore& store, const CycleSolver& solver,
                                         const CycleListener& listener, const InputDegree& required,
                                         const StepWrapper& around);

struct NamedValues {
    std::map<std::string, AnyMesh, std::less<>> meshes = {};
    std::map<std::string, std::vector<NamedField>, std::less<>> solutions = {};
};

/// `fit`: see CycleStore::run.
using RunOnValues = std::function<Outcome<Run>(const config::Pipeline& pipeline, const Fit& fit, const NamedValues&)>;

struct AdaptedValues {
    CycleRun result;
    EndedCycles cycles;
};
/// Errors: those of adapt.
[[nodiscard]] Outcome<AdaptedValues> adapt_values(const config::Pipeline& pipeline, const RunOnValues& run,
                                                  const CycleSolver& solver, const InputDegree& required,
                                                  const StepWrapper& around);

}  // namespace camber::run

export namespace camber {

/// Returns the fields of the solution on a mesh. `guess`: the solution of the previous cycle, transferred to the mesh;
/// empty in cycle 0.
template <int D>
using MeshSolver = std::function<Outcome<std::vector<run::NamedField>>(
    const Mesh<D>& mesh, const std::vector<run::NamedField>& guess, int cycle)>;

struct AdaptMeshOptions {
    int degree = 2;  ///< of the meshes: 1 or 2
    config::SolutionMetric metric = {};
    config::Adaptation cycles = {.cycles = 8};  ///< without files and commands
    config::Geometry geometry = config::Surrogate{};
    run::GeometrySource geometry_source = {};
};

template <int D>
struct AdaptedMesh {
    Mesh<D> mesh;
    std::vector<run::NamedField> solution;
    run::Report report;  ///< of the cycle that made the mesh
    run::EndedCycles cycles;
};

/// Adapts a mesh to a solution, as `camber adapt`. The solution is an expression of x, y and z, or a solver for each
/// mesh. The result may be invalid: see `report` and `cycles`. Errors: options out of range (usage), fields of other
/// sizes than the mesh (input), those of the solver and of `run::adapt`.
template <int D>
[[nodiscard]] Outcome<AdaptedMesh<D>> adapt_mesh(Mesh<D> mesh, const std::variant<std::string, MeshSolver<D>>& solution,
                                                 const AdaptMeshOptions& options, const StepWrapper& around);

}  // namespace camber
