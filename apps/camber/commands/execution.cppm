module;
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.commands:execution;
import camber.core;
import camber.io;
import camber.config;
import camber.recipes;
import camber.reports;
import camber.app_shell;
import camber.ordering;
import camber.distributed;
import :requests;

namespace camber::app {

/// Parses the whole text as a number; none: it is not one.
template <class T>
[[nodiscard]] std::optional<T> number_in(std::string_view text) {
    T x{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(x) : std::nullopt;
}

/// Adds the file to an error without a location.
Error of_file(Error error, const std::string& path);

/// Reads a mesh file, with the format by its content. A flat mesh becomes 2D with its lift and a notice, or a surface.
Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat, const DecodeOptions& options,
                               const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat,
                                                    const Execution& execution) {
    return read_mesh(path, flat, {}, execution);
}

/// Reads a solution file for this mesh. For a flat mesh in space, directions are reduced to the plane.
Outcome<DecodedSolution> read_solution_for(const DecodedMesh& mesh, const std::string& path,
                                           const Execution& execution);

/// Reads the geometry of a config (CAD model or mesh), unless it is in memory.
Outcome<run::GeometrySource> read_geometry(const config::Geometry& geometry, const Execution& execution,
                                           const MemoryInputs& specified = {});

using run::Fit;

/// Executes the run of a config: reads or generates the input, runs the stages with clocks and progress, and writes the
/// outputs. `written` collects the output files. `fit`, if set, is called with the input. Outputs named after values in
/// memory are not written; the run contains them.
Outcome<run::Run> execute(const config::Pipeline& pipeline, Written& written, const Fit& fit = {}, Host host = {});

class TimedSteps {
  public:
    /// The arguments must outlive this object.
    TimedSteps(const config::Pipeline& pipeline, Host& host)
        : pipeline_(pipeline), host_(host), progress_(std::move(host.progress)) {}

    [[nodiscard]] StepWrapper around();
    [[nodiscard]] Progress& progress() { return progress_; }
    /// Adds times, threads and origin, which all reports have. `origin` and the mesh are those of the input.
    void add_to(run::Report& report, run::OriginReport origin);

  private:
    const config::Pipeline& pipeline_;
    Host& host_;
    Progress progress_;
    std::vector<run::StageTime> times_;  ///< one per name
};

[[nodiscard]] run::OriginReport origin_of(const config::Pipeline& pipeline, const run::PlanSize& mesh);
/// Writes the report on the first rank if the pipeline names a file.
[[nodiscard]] Outcome<Done> write_report(const run::Report& report, const config::Output& files, const Host& host,
                                         Written& written);
/// Adds the input to an error without a location.
[[nodiscard]] Error of_input(Error error, const config::Pipeline& pipeline);

/// Returns the plan of `execute` as text. Reads or generates the input and checks the outputs, but writes nothing.
Outcome<std::string> plan(const config::Pipeline& pipeline, const Fit& fit = {});

/// Checks that all outputs can be written. Errors: usage (an ending), write.
Outcome<Done> check_outputs(const config::Output& output);

/// True if the text names a file, by its ending or because it exists; otherwise it is an expression.
[[nodiscard]] bool names_a_file(const std::string& text);
[[nodiscard]] bool is_solution_file(std::string_view path);

/// Returns the format with this name, or else by the path's ending. If formats share the ending, `source`, the input's
/// format, decides (see format_to_rewrite). Standard output has no ending. Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_of_mesh(const std::string& path, std::string_view name,
                                                        std::string_view source = {});
[[nodiscard]] Outcome<const SolutionFormat*> format_of_solution(const std::string& path, std::string_view name);

/// Writes the mesh, and its fields if the format stores fields.
[[nodiscard]] Outcome<Done> write_mesh(const MeshFormat& format, const AnyMesh& mesh, const MeshFields& fields,
                                       EncodeOptions options, const std::string& path, const Execution& execution);
/// Writes the mesh in a format for viewers, a flat mesh at its position in space. An empty path: nothing is written.
/// `check_viewer_output` checks the path before the work. Errors: usage.
[[nodiscard]] Outcome<Done> write_for_viewers(AnyMesh mesh, MeshFields fields, const std::optional<Lift>& lift,
                                              const std::string& path, const Execution& execution);
[[nodiscard]] Outcome<Done> check_viewer_output(const std::string& path);
[[nodiscard]] Outcome<Done> write_solution(const SolutionFormat& format, const Solution& solution,
                                           const std::string& path, const Execution& execution);

void report_renames(const MeshFormat& format, const MeshFields& fields);

/// Restores the names of references that the mesh lost in a file without names.
void name_references(AnyMesh& mesh, const run::Groups& groups);

/// Size limit for a mesh read from a stream. If it begins like a mesh format: a quarter of the memory. If only its name
/// suggests one: the limit of texts. Otherwise nothing is read.
[[nodiscard]] StreamBound bound_of_mesh(const std::string& path);

[[nodiscard]] Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution);

[[nodiscard]] Outcome<Done> write_text(const std::string& path, std::string_view text);

/// Returns the possible plot files of a folder, one for each quantity. The folder is created if its parent exists.
[[nodiscard]] std::vector<std::string> plot_files(const std::string& folder);
[[nodiscard]] Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder,
                                        Written& written);

enum class Role : std::uint8_t { input, input_mesh, output_mesh, output };

struct NamedFile {
    std::string path, word;  ///< word: the option or config key that named the file
    Role role;
};

/// Checks that each path is empty or valid, and that no output is an input or another output, also by links. With
/// `force` the output mesh may replace the input mesh. Called before any work. Errors: usage.
[[nodiscard]] Outcome<Done> check_named_files(const std::vector<NamedFile>& files, bool force = false);

struct PipelineWords {
    const char *input, *solution, *metric, *cad, *geometry, *mesh, *vtu, *plots, *report, *page;
};
inline constexpr PipelineWords words_of_options{"the input", "--solution", "--metric", "--cad",    "--geometry",
                                                "-o",        "--vtu",      "--plots",  "--report", "--page"};
inline constexpr PipelineWords words_of_config{"/input/mesh",    "/solution/file", "/metric/file", "/geometry/cad/file",
                                               "/geometry/mesh", "/output/mesh",   "/output/vtu",  "/output/plots",
                                               "/output/report", "/output/page"};

[[nodiscard]] std::vector<NamedFile> files_of(const config::Pipeline& pipeline, const PipelineWords& words);

}  // namespace camber::app

namespace camber::app {

using run::NamedField;

/// Returns the floating-point fields at the nodes of a mesh, with notices of omitted fields.
[[nodiscard]] std::vector<NamedField> fields_at_nodes(const DecodedMesh& mesh, std::vector<Notice>& notices);

/// Reads the fields of a solution or mesh file for this mesh, at the vertices or at all nodes of degree 2. On a
/// straight mesh, rows of edge nodes follow those of the vertices, ordered by (lower vertex, higher vertex). Fields of
/// a solution file are named field_1, field_2, …. `only`: names of the requested fields; empty: all. Errors: input
/// (wrong number of rows, another mesh, no field at nodes); usage (unknown name).
[[nodiscard]] Outcome<std::vector<NamedField>> read_nodal_fields(const DecodedMesh& mesh, const std::string& path,
                                                                 const std::vector<std::string>& only,
                                                                 std::vector<Notice>& notices,
                                                                 const Execution& execution);

/// Reads a metric of this mesh, at its vertices or all nodes, from a solution file or a mesh file with the same nodes.
/// In a mesh file it is the field `metric`, or else the only tensor, or else the only scalar, a size. Errors: those of
/// reading; input (a mesh file without such a field).
[[nodiscard]] Outcome<run::RowsByNodes> read_metric_rows(const DecodedMesh& mesh, const std::string& path,
                                                         std::vector<Notice>& notices, const Execution& execution);

[[nodiscard]] Outcome<std::vector<Solution>> read_metrics_at_vertices(const DecodedMesh& mesh,
                                                                      const std::vector<config::FilePath>& files,
                                                                      std::vector<Notice>& notices,
                                                                      const Execution& execution);

/// Writes fields to a solution file, with rows in the node order of the mesh file, or with the mesh if the format
/// stores fields. The format is the named one, else that of the ending; if formats share the ending, that of the input
/// mesh. Errors: usage (unknown ending); those of writing.
[[nodiscard]] Outcome<Done> write_nodal_fields(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                               const std::string& path, std::string_view format,
                                               const Execution& execution);
[[nodiscard]] Outcome<Done> write_with_mesh(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                            const MeshFormat& format, const std::string& path,
                                            const Execution& execution);
/// Checks before the work that fields can be written to the path, and that the format stores fields of this kind.
/// Errors: usage.
[[nodiscard]] Outcome<Done> check_fields_output(const std::string& path, std::string_view format);
[[nodiscard]] Outcome<Done> check_place_for(const std::string& path, std::string_view format, FieldKind kind);

/// Folder of all cycles, with a folder for each. A cycle's folder gets its name when it is complete.
class CycleFolders {
  public:
    /// A permanent folder: a new one, or one with its cycles up to `last` and their table. Errors: usage (there are
    /// cycles already, or none to continue); input (the table); write.
    [[nodiscard]] static Outcome<CycleFolders> anew(const std::string& folder);
    [[nodiscard]] static Outcome<CycleFolders> continued(const std::string& folder, int last);
    /// A temporary folder next to a file, removed at the end.
    [[nodiscard]] static Outcome<CycleFolders> passing(const std::string& beside);

    CycleFolders(const CycleFolders&) = delete;
    CycleFolders& operator=(const CycleFolders&) = delete;
    CycleFolders(CycleFolders&& other) noexcept;
    CycleFolders& operator=(CycleFolders&&) = delete;
    ~CycleFolders();

    [[nodiscard]] bool is_permanent() const { return is_permanent_; }
    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const std::vector<run::CycleRow>& rows() const { return rows_; }
    /// Names of the first mesh's references.
    [[nodiscard]] const run::Groups& groups() const { return groups_; }

    /// Creates the empty folder of an unfinished cycle.
    [[nodiscard]] Outcome<std::string> part_of_cycle(int cycle) const;
    [[nodiscard]] std::string of_cycle(int cycle) const;
    /// Renames the unfinished folder to that of the last cycle, and writes table and series.
    [[nodiscard]] Outcome<Done> add(std::span<const run::CycleRow> rows, const std::string& view);
    /// Stores the names next to the cycles, whose files may not support names. Errors: write.
    [[nodiscard]] Outcome<Done> store_groups(run::Groups groups);

  private:
    CycleFolders(std::string path, bool is_permanent) : path_(std::move(path)), is_permanent_(is_permanent) {}

    std::string path_;
    bool is_permanent_;
    std::vector<run::CycleRow> rows_;
    run::Groups groups_;
};

/// Options of cycles that are not in the config.
struct CyclesChoice {
    std::optional<int> from;  ///< cycle of an earlier run to continue after; none: a new run
    int degree = 0;           ///< required degree of the mesh; 0: any
};

/// Runs the cycles of a config, prints their table row by row, and returns the exit code. After each cycle the outputs
/// are those of this cycle. With `dry_run` prints the plan of one cycle. `files`: paths with the names for messages.
[[nodiscard]] Outcome<int> run_or_plan_cycles(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                                              const CyclesChoice& choice, bool dry_run);

/// Reads or generates the inputs of a run. Errors: those of reading; usage (options for missing files).
[[nodiscard]] Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const MemoryInputs& specified,
                                               const Execution& execution);

/// Runs steps of a verb with progress. The host may stop them.
struct ShownSteps {
    explicit ShownSteps(int threads, const Host& host = {})
        : progress(host.progress), around(steps_shown(progress, {.threads = threads, .stop = host.stop})) {}

    template <class F>
    auto run(std::string_view step, F&& f) {
        return run_step(around, step, std::forward<F>(f));
    }

    Progress progress;
    StepWrapper around;
};

}  // namespace camber::app

namespace camber::app {

/// True if a pipeline runs by blocks: it specifies their size, or runs on several ranks.
[[nodiscard]] bool runs_by_blocks(const config::Pipeline& pipeline, const Host& host);

/// Runs a pipeline by blocks on all ranks of the host and writes its outputs. If there are several ranks, each reads
/// its rows of a binary .meshb and writes its rows at their offsets. Other formats are read as a whole. The returned
/// mesh is empty, since it is in the file.
[[nodiscard]] Outcome<run::Run> execute_by_blocks(const config::Pipeline& pipeline, Written& written, Host host);

/// True for a file that lists its pieces (.pvtu). It is only written in parts.
[[nodiscard]] bool names_its_pieces(const std::string& path);
[[nodiscard]] Outcome<Done> missing_partition_error(const std::string& path);
/// Returns the format of the parts: the named one, else by the ending; VTU for a .pvtu. Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_of_parts(const std::string& path, const std::string& name);

struct PartedOutput {
    std::string path;
    std::size_t parts = 0;
    EncodeOptions options = {};
};

/// Writes the parts of a mesh for a solver, as files `OUT.1.EXT`, …. If the format stores fields, global_nodes and
/// global_cells are the numbers in the whole mesh (from 1). A .pvtu lists the parts. In other formats the whole mesh is
/// written too, with the field `partition` on its cells. Errors: usage, unsupported, write, memory, stopped.
[[nodiscard]] Outcome<Done> write_in_parts(const MeshFormat& format, const DecodedMesh& mesh,
                                           const PartedOutput& output, Written& written, const Execution& execution);

/// Writes the ranks' parts of a mesh with `whole` rows as pieces of a .pvtu. Collective. Returns the names of the
/// pieces. Errors, of any rank: usage, write, memory, stopped.
template <class Mesh>
[[nodiscard]] Outcome<std::vector<std::string>> write_parts_of_ranks(Ranks& ranks, const RowCounts& whole,
                                                                     const PartsOfRank<Mesh>& own,
                                                                     const PartedOutput& output,
                                                                     const Execution& execution);

/// Converts a binary .meshb that several ranks read to a .pvtu; each rank writes some pieces. Collective. Returns the
/// names of the pieces. Errors, of any rank: usage, unsupported.
[[nodiscard]] Outcome<std::vector<std::string>> write_in_parts_on_ranks(const Host& host, const std::string& input,
                                                                        const PartedOutput& output,
                                                                        const Execution& execution);

}  // namespace camber::app

namespace camber::app {

/// Mesh to curve: rows read on request, or a mesh in memory.
template <int D>
struct Opened {
    std::unique_ptr<MeshRows<D>> rows;
    std::optional<LinearMesh<D>> mesh = {};  ///< in memory, in processing order
    std::optional<BetterOrder> order = {};   ///< from the file's order to the processing order
    std::optional<Lift> lift = {};
};

/// Opens a file whose rows several ranks read on request. Errors: input; unsupported (another dimension).
template <int D>
[[nodiscard]] Outcome<Opened<D>> mapped(const std::string& path);

/// Opens a file of degree 2 in this way. Collective. Errors, of any rank: those of the file; unsupported (a form that
/// QuadraticRows does not support).
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic(const std::string& path, Ranks& ranks);

[[nodiscard]] Outcome<GmfShape> shape_of_file(const std::string& path);

/// Repairs the defects of a straight mesh and reorders it, so that close elements have close numbers.
template <int D>
[[nodiscard]] Outcome<Opened<D>> prepared(Mesh<D> specified, std::vector<std::string>& notices,
                                          const Execution& execution);

struct InputForm {
    std::string_view format = {};
    bool is_always_3d = false;      ///< the format has no 2D meshes
    std::optional<Lift> lift = {};  ///< maps a flat mesh back to its plane in space
};

/// Writes the files of a run that the config names, except the report, which includes the time of writing. `written`
/// collects them. Collective: all ranks write rows; the first writes data that all have. Errors: usage (an ending),
/// write.
Outcome<Done> write_outputs(run::Run& run, const config::Output& files, const InputForm& input,
                            const StepWrapper& around, Written& written, const Host& host);

/// Checks before the work that a page's file ends in .html. Errors: usage.
[[nodiscard]] Outcome<Done> check_page(const std::string& path);

/// Writes the page of a checked mesh. `source`: without title, version and command. `mesh`: path of the mesh, for the
/// title. Errors: those of `run::page` and of writing.
[[nodiscard]] Outcome<Done> write_page(run::PageSource source, const std::string& mesh, const std::string& path,
                                       const run::PageOptions& options, const Execution& execution);

[[nodiscard]] Outcome<run::PictureChoice> choice_of(const PictureArguments& arguments);

}  // namespace camber::app
