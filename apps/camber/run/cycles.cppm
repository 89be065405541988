module;
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>
export module camber.run:cycles;
import camber.core;
import camber.config;
import camber.io;
import :file_numbers;
import :pipeline;
import :report;
import :solution;

/// A pipeline in cycles (config "adapt"): what each of them runs, when they have settled, and their table.
export namespace camber::run {

/// Where a cycle's files are: all within its folder.
struct CycleFiles {
    std::string folder;
    std::string mesh, solution, guess;  ///< the mesh, the solver's solution on it, what that may begin with
    std::string said;                   ///< what the solver said
    std::string report, view;           ///< view: the mesh with fields, for ParaView
    std::string vtu, metric, carried, plots, page;
};
/// Those of a config's cycle below the folder of all.
[[nodiscard]] CycleFiles files_of_cycle(const config::Pipeline& pipeline, const std::string& folder);
/// "cycle-007".
[[nodiscard]] std::string name_of_cycle(int cycle);

/// What makes the first mesh, which the solver is asked on: the stages that keep the topology; without a solver none.
[[nodiscard]] config::Pipeline first_pipeline(const config::Pipeline& pipeline, const CycleFiles& into);
/// Either one as the mesh that it begins with has it: of degree 2 with curves nothing elevates it, and the first mesh
/// is judged as it is.
[[nodiscard]] config::Pipeline fitted_to(const AnyMesh& mesh, config::Pipeline pipeline, int cycle);
/// What makes the mesh of a cycle, from 1, out of the one before.
[[nodiscard]] config::Pipeline cycle_pipeline(const config::Pipeline& pipeline, int cycle, const CycleFiles& first,
                                              const CycleFiles& before, const CycleFiles& into);
/// The command of a cycle, its braces replaced.
[[nodiscard]] std::vector<std::string> solver_command(const config::Adaptation& adapt, int cycle,
                                                      const CycleFiles& files);

/// What cannot be done cycle after cycle. Errors: usage.
[[nodiscard]] Outcome<Done> check_cycles(const config::Pipeline& pipeline);

/// An error of a solution, or of the exact one's interpolant, in the mesh's degree.
struct CycleError {
    double l2 = 0, h1 = 0;
};

/// The distance of the boundary from its geometry, that of the facet which is farthest by its bound (model units).
struct BoundaryDistance {
    double bound = 0, reached = 0;
    bool is_required = false;  ///< by the config; else the bound is that of the expected error
};

/// A row of the table. Shares and qualities are those of the mesh in the metric that it was made by.
struct CycleRow {
    int cycle = 0;
    std::size_t unknowns = 0, elements = 0;
    std::string problem = {};                ///< the exact solution and the solver's command
    double wanted = 0, complexity = 0;       ///< 0: not asked for; no metric
    double unit_before = 0, unit_edges = 0;  ///< shares: of the mesh that it was made of, and its own
    double worst_quality = 0, mean_quality = 0;
    double smallest_jacobian = 1;
    /// L2 error that `curve` expects (objective solution), or that the solution on a straight mesh lets expect
    std::optional<double> expected = {};
    std::optional<CycleError> interpolated = {}, solved;  ///< where the exact solution is known
    std::optional<BoundaryDistance> boundary = {};        ///< where it is bounded
    double seconds = 0, solve_seconds = 0;
    bool is_of_gradients = false;          ///< the metric is for the error of gradients
    bool is_valid = true;                  ///< all elements are certified valid
    std::vector<std::string> misses = {};  ///< how its mesh is not the one that was wanted
};
/// The mesh of a cycle.
struct CycleRun {
    Run run;
    std::string miss;  ///< says that its complexity is not the one that was wanted; empty: it is
};
/// The row of a cycle's mesh, without what `add_errors` adds.
[[nodiscard]] CycleRow row_of(int cycle, const config::Pipeline& pipeline, const CycleRun& made);

/// Adds to the row of a mesh:
/// - the unknowns, if its interpolants are of degree 2: the largest degree of the mesh, of the metric of the solution,
///   and of the solver's fields counts (a straight mesh may be for elements of degree 2);
/// - the L2 error that the solver's fields (none: {}) let expect on a straight mesh. On others `curve` has it;
/// - the errors of the exact solution's interpolant and of the first scalar field, if the solution is known.
/// Errors: an expression that is not one, or not finite somewhere, other numbers of weights than of fields (usage); no
/// scalar field (input); those of `known_solution`.
[[nodiscard]] Outcome<Done> add_errors(CycleRow& row, const AnyMesh& mesh, std::span<const NamedField> solved,
                                       const config::Pipeline& pipeline, const Execution& execution);

/// Runs the pipeline of a cycle by \p execute. While its mesh has elements that are not certified valid, runs it again,
/// at most three times, with a smaller step: the complexity halfway (in the logarithm) back to that of the mesh before,
/// or 10 % less where the two are as near as that. Each step adds a notice. \p rows are those of the cycles before.
/// Errors: those of \p execute.
[[nodiscard]] Outcome<CycleRun> run_cycle(config::Pipeline pipeline, std::span<const CycleRow> rows,
                                          const std::function<Outcome<Run>(const config::Pipeline&)>& execute);

/// The error of a cycle's mesh: that of the interpolant if the solution is known, in L2, or in H1 if the metric is for
/// gradients; otherwise the expected L2 error. None if there is neither.
[[nodiscard]] std::optional<double> error_of_mesh(const CycleRow& row, const config::Adaptation& adapt);
/// The row whose mesh is the result. Among the valid meshes of the last complexity, for the same problem, it is the one
/// with the least error, where meshes that miss something come last; with `result` "last" it is the last valid mesh.
[[nodiscard]] std::size_t row_of_result(std::span<const CycleRow> rows, const config::Adaptation& adapt);
/// Why no more cycles are needed (`settled` of the config): the least error has not fallen, or without an error meshes
/// become no nearer to unit in their own solution's metric. Empty: they are needed.
[[nodiscard]] std::string reason_to_end(std::span<const CycleRow> rows, const config::Adaptation& adapt);
/// What is worth knowing of the result: that it is not the last, and unit edges or a quality that fell.
[[nodiscard]] std::vector<std::string> notes_on_result(std::span<const CycleRow> rows, const config::Adaptation& adapt);

/// The table for a terminal, whole or line by line, and as JSON, both ways. Errors of reading: input, with its path.
[[nodiscard]] std::string cycles_head(const config::Adaptation& adapt);
[[nodiscard]] std::string cycles_line(const CycleRow& row, const config::Adaptation& adapt);
[[nodiscard]] std::string cycles_json(std::span<const CycleRow> rows);
[[nodiscard]] Outcome<std::vector<CycleRow>> read_cycles(const std::string& text, const std::string& path);

/// Names of references as JSON, both ways: files of cycles may have no place for them. Errors of reading: input, with
/// its path.
[[nodiscard]] std::string groups_json(const Groups& groups);
[[nodiscard]] Outcome<Groups> read_groups(const std::string& text, const std::string& path);

/// A series for ParaView (.pvd): one file a cycle, the cycle as the time.
[[nodiscard]] std::string series_of(std::span<const CycleRow> rows, const std::string& view);

}  // namespace camber::run
