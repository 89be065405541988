module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
export module camber.commands:requests;
import camber.core;
import camber.drawing;
import camber.transfer;
import camber.io;
import camber.cad;
import camber.distributed;
import camber.config;
import camber.recipes;
import camber.reports;
import camber.app_shell;

/// Cells of a mesh for other languages, by the names of their types.
export namespace camber::app {

/// Names of K-simplices in meshio, K = 1, 2, 3, of degree 1 and 2.
inline constexpr std::array<const char*, 3> straight_names{"line", "triangle", "tetra"};
inline constexpr std::array<const char*, 3> curved_names{"line3", "triangle6", "tetra10"};

/// Calls f(simplices, edges) for the K-simplices of the mesh. `edges`: their edges if the degree is 2; otherwise null.
template <int K, class F>
void on_cells(const AnyMesh& mesh, F&& f) {
    const auto with_edges = [&]<int D>(const Mesh<D>& m, const auto& cells, const auto& edges) {
        f(cells, m.degree == 2 ? &edges : nullptr);
    };
    std::visit(
        [&]<int D>(const Mesh<D>& m) {
            if constexpr (K == D) {
                with_edges(m, m.elements.template of<simplex<K>>(),
                           m.entities.edges_of_elements.template of<simplex<K>>().ids);
            } else if constexpr (K == D - 1) {
                with_edges(m, m.facets.template of<simplex<K>>(),
                           m.entities.edges_of_facets.template of<simplex<K>>().ids);
            } else if constexpr (K == 1) {
                Buffer<std::array<EdgeId, 1>> edges;
                for (const EdgeId e : m.entities.edges_of_edges) edges.push_back({e});
                with_edges(m, m.edges, Column<std::array<EdgeId, 1>>(std::move(edges)));
            }
        },
        mesh);
}

}  // namespace camber::app

export namespace camber::app {

/// Prints "camber: …" to standard error. Failures are ignored.
void print_line(const std::string& line);

/// Prints a note, which is not an error, to standard error, except with --quiet.
void print_note(const std::string& note);

/// Prints a notice in this way. Details are only printed with --verbose.
void print_notice(const Notice& notice);

/// Prints `camber: where: entity: what (remedy)` to standard error. Returns the exit code for the kind of error.
int report_error(const Error& error);

/// Returns the last error that was not printed, if printing is disabled.
[[nodiscard]] std::optional<Error> unreported_error();

/// Prints the complete output of a verb. Returns exit code 0, or that of the error if writing fails.
[[nodiscard]] int end_with(std::string_view text);

}  // namespace camber::app

namespace camber::app {

/// Files that a verb has written. An error after the first of them lists them.
class Written {
  public:
    /// Adds the file if writing succeeded. Otherwise adds to the error which files were written before.
    [[nodiscard]] Outcome<Done> add(const std::string& path, Outcome<Done> outcome);
    [[nodiscard]] Error error_with_files(Error error) const;
    /// True if standard output received a file. Messages then go to standard error.
    [[nodiscard]] bool takes_standard_output() const;
    [[nodiscard]] const std::vector<std::string>& paths() const { return paths_; }

  private:
    std::vector<std::string> paths_;
};

/// Returns " wrote wing.vtu\n" for each nonempty path.
[[nodiscard]] std::string wrote_rows(const std::vector<std::string>& paths);

/// Prints the text of a verb that wrote these files: not with --quiet, and to standard error if a file went to standard
/// output. An error lists the written files.
[[nodiscard]] int end_with(std::string_view text, const Written& written);

}  // namespace camber::app

export namespace camber::app {

struct PictureArguments {
    std::string input, output;
    std::string size, cut, view, zoom;    ///< "1200x900"; "x=0.5"; "top", "1,-2,1"; "X,Y,Z,RADIUS"; empty: default
    std::string show, hide;               ///< names of groups or reference numbers, separated by commas
    std::string metric, solution, field;  ///< files, and a field of the solution; empty: none, the first
    std::optional<run::PictureColour> colour = {};
    Background background = Background::light;
    bool no_edges = false;
    int worst = 0;
    config::Flat flat = config::Flat::plane;
    int threads = 0;
};
[[nodiscard]] Outcome<int> picture_command(const PictureArguments& arguments);

/// If the arguments are those of the child process that reads a CAD file, does its work and returns its exit code.
[[nodiscard]] std::optional<int> cad_reader(std::span<const char* const> arguments);

}  // namespace camber::app

export namespace camber::app {

/// Returns `did you mean "curve"?` if the word begins a known one or differs by one edit (a letter too many, missing or
/// wrong, or two swapped). Otherwise returns `known: …`.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace camber::app

export namespace camber::app {

/// Values of the caller, by the names that the config or arguments use for them (config::is_in_memory).
struct MemoryInputs {
    std::map<std::string, DecodedMesh, std::less<>> meshes = {};
    std::map<std::string, Solution, std::less<>> metrics = {};  ///< rows in the order of a file of the mesh
    std::map<std::string, std::vector<run::NamedField>, std::less<>> solutions = {};
    run::Groups groups = {};  ///< names of references of an input mesh without names
};

enum class NamesOfGroups : std::uint8_t {
    in_its_file,    ///< names that the format cannot store are lost and reported
    by_the_caller,  ///< the caller has the names
};

/// Environment of a run: values in memory, request to stop, progress, and ranks.
struct Host {
    MemoryInputs memory_inputs = {};
    NamesOfGroups names = NamesOfGroups::in_its_file;
    std::stop_token stop = stop_on_signals();
    ProgressCallback progress = {};  ///< none: the terminal
    std::shared_ptr<Ranks> ranks = one_rank();
    GraphPartitioner partition = {};  ///< partitions graphs distributed on ranks; none: not available
};

/// Returns the outputs that are files, not values in memory.
[[nodiscard]] config::Output files_of(config::Output output);

}  // namespace camber::app

/// Verbs on meshes in memory, for other languages (apps/python, apps/c). They do the same work as the program and write
/// the same bytes. Errors: those of the verbs.
export namespace camber::app {

struct MemoryResult {
    DecodedMesh mesh;
    std::string report = {};                     ///< JSON: docs/report.md
    std::optional<Solution> metric = {};         ///< at the vertices, if a stage computed one
    std::vector<run::NamedField> solution = {};  ///< the input's fields on this mesh
    std::vector<std::string> notices = {};
    bool meets_requirements = true;  ///< false: the report lists the missed requirements
    bool has_valid_elements = true;  ///< false: some elements are not certified valid
};

/// Runs the stages of a config once. A curved mesh needs no `elevate`. Outputs that are files are written.
[[nodiscard]] Outcome<MemoryResult> run_in_memory(config::Pipeline pipeline, Host host);

/// Returns the solution on a mesh. `guess`: the solution of the previous cycle, transferred to this mesh.
using Solver = std::function<Outcome<std::vector<run::NamedField>>(
    const DecodedMesh& mesh, const std::vector<run::NamedField>& guess, int cycle)>;

struct AdaptedInMemory {
    MemoryResult result;  ///< see run::row_of_result; with the solver's solution, if there is a solver
    std::string cycles;   ///< JSON: one row per cycle
    std::string reason;   ///< reason for an early end; empty: all cycles were run
};
/// Runs the cycles of a config. `solver`: empty if the config has the target; `degree`: degree of meshes; 0: any.
[[nodiscard]] Outcome<AdaptedInMemory> adapt_in_memory(config::Pipeline pipeline, int degree, const Solver& solver,
                                                       Host host);

/// Report of `camber check` as JSON (docs/report.md), and verdicts and values of the elements as named columns.
struct ElementColumn {
    std::string name;
    std::vector<double> values;
};
struct CheckedInMemory {
    std::string report, table;
    std::vector<ElementColumn> elements;
    bool all_good = false;
};
[[nodiscard]] Outcome<CheckedInMemory> check_in_memory(const DecodedMesh& mesh, const std::optional<Solution>& metric,
                                                       const run::CheckOptions& options, Host host);

/// Returns the page of `camber report` as HTML.
[[nodiscard]] Outcome<std::string> page_in_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                                  const std::string& title, const run::PageOptions& options, Host host);

/// Returns the report of `camber geometry` as JSON.
[[nodiscard]] Outcome<std::string> geometry_in_memory(const DecodedMesh& mesh, const config::Geometry& geometry,
                                                      const run::InspectOptions& options, Host host);

/// Metric at the vertices of a config's input, from its source and operations. Stages are not run.
struct MetricInMemory {
    Solution metric;
    double complexity = 0, largest_anisotropy = 0;
    std::vector<std::string> notices;
};
[[nodiscard]] Outcome<MetricInMemory> metric_in_memory(const config::Pipeline& pipeline, Host host);

/// Returns the second derivatives of a field at the vertices.
[[nodiscard]] Outcome<Solution> hessians_in_memory(const DecodedMesh& mesh, const run::NamedField& field, Host host);

[[nodiscard]] Outcome<std::vector<run::NamedField>> transfer_in_memory(const DecodedMesh& old_mesh,
                                                                       const DecodedMesh& new_mesh,
                                                                       std::vector<run::NamedField> fields,
                                                                       const TransferOptions& options, Host host);

/// Read and write a mesh with its fields as `camber convert` does.
[[nodiscard]] Outcome<DecodedMesh> read_into_memory(const std::string& path, config::Flat flat,
                                                    const DecodeOptions& options, Host host);
[[nodiscard]] Outcome<std::vector<std::string>> write_from_memory(const DecodedMesh& mesh,
                                                                  const std::vector<run::NamedField>& fields,
                                                                  const std::string& path, const std::string& format,
                                                                  Host host);
/// Returns the nodal fields that a mesh was read with.
[[nodiscard]] std::vector<run::NamedField> nodal_fields_of(const DecodedMesh& mesh);

/// Writes a file of `bytes` bytes, each rank its pieces. The file gets its name when all ranks are done. Collective: a
/// rank whose pieces failed must call it too; then no rank writes. Errors, of any rank: write, stopped.
[[nodiscard]] Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                                           const Outcome<std::span<const FilePiece>>& pieces,
                                           const Execution& execution);

/// Writes pieces that are generated in several steps (`turns`). All ranks execute each step together.
[[nodiscard]] Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                                           std::size_t turns,
                                           const std::function<Outcome<std::vector<FilePiece>>(std::size_t)>& pieces_of,
                                           const Execution& execution);

/// Contents of a .meshb besides its rows.
template <int D>
struct MeshbContents {
    PartTotals totals;
    const LinearMesh<D>& lists;  ///< corners, ridges, required entities, groups
};

/// Writes a .meshb with these totals and lists, collectively. In each step a rank writes a part of its rows. In its
/// first step, the first rank also writes the beginning and the end of the file.
template <int D, int Degree>
[[nodiscard]] Outcome<Done> write_meshb_together(
    Ranks& ranks, const std::string& path, const MeshbContents<D>& contents, std::size_t turns,
    const std::function<Outcome<FilePart<D, Degree>>(std::size_t)>& part_of, const Execution& execution) {
    const auto& [totals, lists] = contents;
    const auto frame = gmf_frame<D, Degree>(totals, lists);
    if (!frame) return fail(frame.error());
    const Execution quiet = without_progress(execution);
    const auto pieces_of = [&](std::size_t turn) -> Outcome<std::vector<FilePiece>> {
        const auto part = part_of(turn);
        if (!part) return fail(part.error());
        auto pieces = encode_gmf_part<D, Degree>(*frame, *part, quiet);
        if (!pieces || turn > 0 || ranks.rank() > 0) return pieces;
        auto rest = encode_gmf_frame<D, Degree>(*frame, lists, quiet);
        if (!rest) return rest;
        std::ranges::move(*rest, std::back_inserter(*pieces));
        return pieces;
    };
    return write_together(ranks, path, frame->bytes, turns, pieces_of, execution);
}

}  // namespace camber::app
