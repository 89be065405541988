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

/// Reads a number that is the whole text; none if it is not.
template <class T>
[[nodiscard]] std::optional<T> number_in(std::string_view text) {
    T x{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(x) : std::nullopt;
}

/// An error that says no place, as one of that file.
Error of_file(Error error, const std::string& path);

/// A file's mesh, by its content; a flat one as a plane mesh in 2D with its lift, and a notice of that, or as a
/// surface.
Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat, const DecodeOptions& options,
                               const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat,
                                                    const Execution& execution) {
    return read_mesh(path, flat, {}, execution);
}

/// A solution file for a mesh that was read: of a flat one's in space, what it says of directions in the plane.
Outcome<DecodedSolution> read_solution_for(const DecodedMesh& mesh, const std::string& path,
                                           const Execution& execution);

/// Reads the geometry of a config: a CAD model, or another mesh, unless that is in memory.
Outcome<run::GeometrySource> read_geometry(const config::Geometry& geometry, const Execution& execution,
                                           const MemoryInputs& specified = {});

using run::Fit;

/// The whole run of a config: reads or generates, runs the stages with clocks and progress, writes the outputs
/// and adds them to those written. `fit`, if there is one, is asked once the input is read. Outputs with names of
/// values in memory are not written: the run has them.
Outcome<run::Run> execute(const config::Pipeline& pipeline, Written& written, const Fit& fit = {}, Host host = {});

/// Runs the steps of a run with clocks and progress.
class TimedSteps {
  public:
    /// The arguments must outlive it.
    TimedSteps(const config::Pipeline& pipeline, Host& host)
        : pipeline_(pipeline), host_(host), progress_(std::move(host.progress)) {}

    [[nodiscard]] StepWrapper around();
    [[nodiscard]] Progress& progress() { return progress_; }
    /// Adds what is common to the reports of all runs: times, threads, origin. `origin` and the mesh are those of the
    /// input.
    void add_to(run::Report& report, run::OriginReport origin);

  private:
    const config::Pipeline& pipeline_;
    Host& host_;
    Progress progress_;
    std::vector<run::StageTime> times_;  ///< one per name
};

/// Describes the beginning of a run.
[[nodiscard]] run::OriginReport origin_of(const config::Pipeline& pipeline, const run::PlanSize& mesh);
/// Writes the report of a run, if the pipeline names a file, on the first rank.
[[nodiscard]] Outcome<Done> write_report(const run::Report& report, const config::Output& files, const Host& host,
                                         Written& written);
/// Completes an error of a run that names no place: the place is the input.
[[nodiscard]] Error of_input(Error error, const config::Pipeline& pipeline);

/// The plan of `execute` as text: reads or generates the input, checks the outputs, writes nothing.
Outcome<std::string> plan(const config::Pipeline& pipeline, const Fit& fit = {});

/// Checks that all outputs can be written. Errors: usage, an ending; write.
Outcome<Done> check_outputs(const config::Output& output);

/// True if the text of a solution names a file, by its ending or as it exists; otherwise it is an expression.
[[nodiscard]] bool names_a_file(const std::string& text);
/// True if the ending is that of a format of solutions.
[[nodiscard]] bool is_solution_file(std::string_view path);

/// The format of a mesh that is written: the one of that name, or else by the path's ending, where `source` says of
/// which format the input is (see format_to_rewrite); standard output has no ending. Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_of_mesh(const std::string& path, std::string_view name,
                                                        std::string_view source = {});
[[nodiscard]] Outcome<const SolutionFormat*> format_of_solution(const std::string& path, std::string_view name);

/// The mesh in this format; the fields only where that has place for them.
[[nodiscard]] Outcome<Done> write_mesh(const MeshFormat& format, const AnyMesh& mesh, const MeshFields& fields,
                                       EncodeOptions options, const std::string& path, const Execution& execution);
/// The same in a format for viewers; a flat mesh of one with three coordinates where it was. Whether that can be is
/// asked before the work; an empty path: nothing is to be written. Errors: usage.
[[nodiscard]] Outcome<Done> write_for_viewers(AnyMesh mesh, MeshFields fields, const std::optional<Lift>& lift,
                                              const std::string& path, const Execution& execution);
[[nodiscard]] Outcome<Done> check_viewer_output(const std::string& path);
[[nodiscard]] Outcome<Done> write_solution(const SolutionFormat& format, const Solution& solution,
                                           const std::string& path, const Execution& execution);

/// Reports names of fields that are others in files of this format.
void report_renames(const MeshFormat& format, const MeshFields& fields);

/// Gives the mesh the names of references that it had before it was in a file without any.
void name_references(AnyMesh& mesh, const run::Groups& groups);

/// The bound of a stream that should be a mesh: a quarter of the memory if it begins as a format does; that of a text
/// if its name alone says so; none is read that does neither.
[[nodiscard]] StreamBound bound_of_mesh(const std::string& path);

/// A solution file's content, in whichever format it is.
[[nodiscard]] Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution);

[[nodiscard]] Outcome<Done> write_text(const std::string& path, std::string_view text);

/// The files that plots in a folder may become, one a quantity. The folder is made where its own is there.
[[nodiscard]] std::vector<std::string> plot_files(const std::string& folder);
[[nodiscard]] Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder,
                                        Written& written);

enum class Role : std::uint8_t { input, input_mesh, output_mesh, output };

/// A file that a verb reads or writes.
struct NamedFile {
    std::string path, word;  ///< the word by which it was named: an option, or a place in the config
    Role role;
};

/// Checks that every path is possible or empty, and that no output is an input or another output, by any path or link.
/// With `force` the mesh that is written may replace the one that is read. Called before any work. Errors: usage.
[[nodiscard]] Outcome<Done> check_named_files(const std::vector<NamedFile>& files, bool force = false);

/// The words by which the files of a pipeline are named.
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

/// Fields of a solution on a mesh, from and to files.
namespace camber::app {

using run::NamedField;

/// The fields of numbers at the nodes of a mesh that was read with them. Notices of those that are left out.
[[nodiscard]] std::vector<NamedField> fields_at_nodes(const DecodedMesh& mesh, std::vector<Notice>& notices);

/// The fields of a solution file, or of a mesh file at its nodes, on that mesh: at its vertices, or at all nodes that
/// it has in degree 2. On a straight mesh the rows of the edges' nodes come after those of the vertices, in the order
/// of (lower vertex, higher vertex). Fields of a solution file are called field_1 and so on. `only`: the names of those
/// that are wanted; empty: all. Errors (input): rows that are not those of the mesh, a mesh that is another one, no
/// field at nodes; (usage): a name that it does not have.
[[nodiscard]] Outcome<std::vector<NamedField>> read_nodal_fields(const DecodedMesh& mesh, const std::string& path,
                                                                 const std::vector<std::string>& only,
                                                                 std::vector<Notice>& notices,
                                                                 const Execution& execution);

/// A metric of that mesh, by its vertices or all nodes: a solution file's rows, or of a mesh file with the same nodes
/// the field `metric`, or else its only tensor, or else its only number, a size. Errors: those of reading; (input) a
/// mesh file without such a field.
[[nodiscard]] Outcome<run::RowsByNodes> read_metric_rows(const DecodedMesh& mesh, const std::string& path,
                                                         std::vector<Notice>& notices, const Execution& execution);

/// Metric files of that mesh, rows at its vertices. Errors: those of reading.
[[nodiscard]] Outcome<std::vector<Solution>> read_metrics_at_vertices(const DecodedMesh& mesh,
                                                                      const std::vector<config::FilePath>& files,
                                                                      std::vector<Notice>& notices,
                                                                      const Execution& execution);

/// Writes fields to a solution file, with rows as the mesh's file counts its nodes, or with the mesh to a format that
/// has fields: the format of that name, else that of the ending, where the mesh's own goes by it that one. Errors: an
/// ending that is none of these (usage); those of writing.
[[nodiscard]] Outcome<Done> write_nodal_fields(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                               const std::string& path, std::string_view format,
                                               const Execution& execution);
/// The same with the mesh, in this format; fields only where it has a place for them.
[[nodiscard]] Outcome<Done> write_with_mesh(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                            const MeshFormat& format, const std::string& path,
                                            const Execution& execution);
/// Check before the work that this is possible, and that the format has a place for such fields. Errors: usage.
[[nodiscard]] Outcome<Done> check_fields_output(const std::string& path, std::string_view format);
[[nodiscard]] Outcome<Done> check_place_for(const std::string& path, std::string_view format, FieldKind kind);

/// The folder of all cycles, and within it one of each: a cycle's is made as a part, and has its name once all of it is
/// there.
class CycleFolders {
  public:
    /// In a place that is kept: new, or with its cycles up to `last` and their table. Errors: usage, there are cycles
    /// already, or none to go on from; input, the table; write.
    [[nodiscard]] static Outcome<CycleFolders> anew(const std::string& folder);
    [[nodiscard]] static Outcome<CycleFolders> continued(const std::string& folder, int last);
    /// Beside a file, and gone in the end.
    [[nodiscard]] static Outcome<CycleFolders> passing(const std::string& beside);

    CycleFolders(const CycleFolders&) = delete;
    CycleFolders& operator=(const CycleFolders&) = delete;
    CycleFolders(CycleFolders&& other) noexcept;
    CycleFolders& operator=(CycleFolders&&) = delete;
    ~CycleFolders();

    [[nodiscard]] bool is_permanent() const { return is_permanent_; }
    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const std::vector<run::CycleRow>& rows() const { return rows_; }
    /// Names of references of the first mesh.
    [[nodiscard]] const run::Groups& groups() const { return groups_; }

    /// An empty folder for a cycle that is being made.
    [[nodiscard]] Outcome<std::string> part_of_cycle(int cycle) const;
    [[nodiscard]] std::string of_cycle(int cycle) const;
    /// The part becomes the folder of the last cycle, and its table and series are written.
    [[nodiscard]] Outcome<Done> add(std::span<const run::CycleRow> rows, const std::string& view);
    /// Stores the names beside the cycles, whose files may have no place for them. Errors: write.
    [[nodiscard]] Outcome<Done> store_groups(run::Groups groups);

  private:
    CycleFolders(std::string path, bool is_permanent) : path_(std::move(path)), is_permanent_(is_permanent) {}

    std::string path_;
    bool is_permanent_;
    std::vector<run::CycleRow> rows_;
    run::Groups groups_;
};

/// Options of cycles beside the config.
struct CyclesChoice {
    std::optional<int> from;  ///< the cycle of an earlier run that they go on from; none: they begin anew
    int degree = 0;           ///< that the mesh is to have; 0: any
};

/// Runs a config's cycles, whose files are named so: prints their table as it comes to be, and returns the exit code.
/// The outputs are those of the last cycle after every cycle. With `dry_run` prints the plan of a cycle.
[[nodiscard]] Outcome<int> run_or_plan_cycles(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                                              const CyclesChoice& choice, bool dry_run);

/// All that a run takes from files, or a generated mesh; what is given in memory from there. Errors: those of reading;
/// what the config says of files that are not there (usage).
[[nodiscard]] Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const MemoryInputs& specified,
                                               const Execution& execution);

/// Steps of a verb, which are shown while they run, and which the host may stop.
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

/// Outputs in parts, by rows of ranks, and pages.
namespace camber::app {

/// True if a pipeline runs by blocks: it specifies their size, or several ranks share it.
[[nodiscard]] bool runs_by_blocks(const config::Pipeline& pipeline, const Host& host);

/// Runs a pipeline by blocks on all ranks of the host, and writes its outputs. Of several ranks each reads the rows of
/// a binary .meshb that it works on, and writes its own at their offsets; other formats are read as a whole. The mesh
/// of the result is empty: it is in the file.
[[nodiscard]] Outcome<run::Run> execute_by_blocks(const config::Pipeline& pipeline, Written& written, Host host);

/// True if the path is that of a file that names its pieces (.pvtu): it is written in parts only.
[[nodiscard]] bool names_its_pieces(const std::string& path);
/// The error of such a file without a number of parts.
[[nodiscard]] Outcome<Done> missing_partition_error(const std::string& path);
/// The format of the files that are written there in parts: that of that name, else by the ending; of a .pvtu VTU.
/// Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_of_parts(const std::string& path, const std::string& name);

/// Output of a mesh in parts.
struct PartedOutput {
    std::string path;
    std::size_t parts = 0;
    EncodeOptions options = {};
};

/// The mesh in so many parts for a solver, each a file `OUT.1.EXT` … with its nodes' and cells' numbers in the whole as
/// fields (global_nodes, global_cells; from 1), where the format has fields. A .pvtu names them; of other formats the
/// whole is written beside them, with the field `partition` of its cells. Errors: usage, unsupported, write, memory,
/// stopped.
[[nodiscard]] Outcome<Done> write_in_parts(const MeshFormat& format, const DecodedMesh& mesh,
                                           const PartedOutput& output, Written& written, const Execution& execution);

/// Writes the parts that ranks have of a mesh (of `whole` rows) as pieces that a .pvtu names: all ranks call it.
/// Returns the names of the pieces. Errors, of any rank: usage, write, memory, stopped.
template <class Mesh>
[[nodiscard]] Outcome<std::vector<std::string>> write_parts_of_ranks(Ranks& ranks, const RowCounts& whole,
                                                                     const PartsOfRank<Mesh>& own,
                                                                     const PartedOutput& output,
                                                                     const Execution& execution);

/// The same of a binary .meshb that several ranks read, into a .pvtu whose pieces each of them writes some
/// of: all ranks call it. The names of the pieces. Errors: of any rank; usage, unsupported.
[[nodiscard]] Outcome<std::vector<std::string>> write_in_parts_on_ranks(const Host& host, const std::string& input,
                                                                        const PartedOutput& output,
                                                                        const Execution& execution);

}  // namespace camber::app

namespace camber::app {

/// A mesh to be curved: rows that are read as they are asked for, or those of a mesh in memory.
template <int D>
struct Opened {
    std::unique_ptr<MeshRows<D>> rows;
    std::optional<LinearMesh<D>> mesh = {};  ///< in memory, in the order to work in
    std::optional<BetterOrder> order = {};   ///< how that came of the file's
    std::optional<Lift> lift = {};
};

/// A file whose rows several read: none of it is held. Errors: input; unsupported where it is of the other dimension.
template <int D>
[[nodiscard]] Outcome<Opened<D>> mapped(const std::string& path);

/// The same of a file of degree 2. All ranks call it. Errors: of any rank; unsupported where it is of another form than
/// QuadraticRows takes.
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic(const std::string& path, Ranks& ranks);

/// The simplices of a binary file. Errors: input.
[[nodiscard]] Outcome<GmfShape> shape_of_file(const std::string& path);

/// A mesh of degree 1 in memory, made sound, in an order in which what is near is near.
template <int D>
[[nodiscard]] Outcome<Opened<D>> prepared(Mesh<D> specified, std::vector<std::string>& notices,
                                          const Execution& execution);

/// Form of the input mesh of a run as a file.
struct InputForm {
    std::string_view format = {};
    bool is_always_3d = false;      ///< its format has no plane
    std::optional<Lift> lift = {};  ///< of a flat one: back to its plane
};

/// Writes the files of a run that the config names, and adds them to those written; but for the report, which tells
/// also what writing them cost. All ranks ask: rows are written by all, what all have by the first.
/// Errors: usage, an ending; write.
Outcome<Done> write_outputs(run::Run& run, const config::Output& files, const InputForm& input,
                            const StepWrapper& around, Written& written, const Host& host);

/// Checks that the file of a page ends in .html, before the work is done. Errors: usage.
[[nodiscard]] Outcome<Done> check_page(const std::string& path);

/// A page of a mesh that was checked; `source` without title, version and command; `mesh`: its path, which names
/// the page. Errors: those of `run::page` and of writing.
[[nodiscard]] Outcome<Done> write_page(run::PageSource source, const std::string& mesh, const std::string& path,
                                       const run::PageOptions& options, const Execution& execution);

/// Reads the texts of the arguments. Errors: usage.
[[nodiscard]] Outcome<run::PictureChoice> choice_of(const PictureArguments& arguments);

}  // namespace camber::app
