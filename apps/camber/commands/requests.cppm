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

/// meshio's names of K-simplices, K = 1, 2, 3, of degree 1 and 2.
inline constexpr std::array<const char*, 3> straight_names{"line", "triangle", "tetra"};
inline constexpr std::array<const char*, 3> curved_names{"line3", "triangle6", "tetra10"};

/// f(simplices, their edges in a mesh of degree 2 or null) of the K-simplices that a mesh of its dimension may have.
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

/// "camber: …" in a line on standard error. Where that cannot be written there is nobody to tell.
void print_line(const std::string& line);

/// The same of what is worth knowing and no error; not said where the program is to be quiet.
void print_note(const std::string& note);

/// The same of a notice; of a detail with --verbose only.
void print_notice(const Notice& notice);

/// `camber: where: entity: what (remedy)` on standard error, and the exit code of the error's kind.
int report_error(const Error& error);

/// The last error that was not said, where the program has no voice.
[[nodiscard]] std::optional<Error> unreported_error();

/// Prints the whole of what a verb says to standard output, and returns its exit code: 0, or that of the error if the
/// text cannot be written.
[[nodiscard]] int end_with(std::string_view text);

}  // namespace camber::app

namespace camber::app {

/// The outputs of a verb as they come to be: an error after the first of them says which were written.
class Written {
  public:
    /// Adds the file if writing it succeeded; otherwise completes the error by the files written before.
    [[nodiscard]] Outcome<Done> add(const std::string& path, Outcome<Done> outcome);
    /// An error that comes after them.
    [[nodiscard]] Error error_with_files(Error error) const;
    /// True if one of them is standard output: messages then go to standard error.
    [[nodiscard]] bool takes_standard_output() const;
    [[nodiscard]] const std::vector<std::string>& paths() const { return paths_; }

  private:
    std::vector<std::string> paths_;
};

/// "  wrote wing.vtu\n", for each path that is not empty.
[[nodiscard]] std::string wrote_rows(const std::vector<std::string>& paths);

/// As above, of what a verb that wrote these files says: nothing where it is to be quiet, and to standard error where a
/// file went to standard output. An error also tells which outputs were written.
[[nodiscard]] int end_with(std::string_view text, const Written& written);

}  // namespace camber::app

export namespace camber::app {

/// A mesh as a picture.
struct PictureArguments {
    std::string input, output;
    std::string size, cut, view, zoom;    ///< "1200x900"; "x=0.5"; "top", "1,-2,1"; "X,Y,Z,RADIUS"; empty: the usual
    std::string show, hide;               ///< names of groups or reference numbers, separated by commas
    std::string metric, solution, field;  ///< files, and the name of a field of the latter; empty: none, the first
    std::optional<run::PictureColour> colour = {};
    Background background = Background::light;
    bool no_edges = false;
    int worst = 0;
    config::Flat flat = config::Flat::plane;
    int threads = 0;
};
[[nodiscard]] Outcome<int> picture_command(const PictureArguments& arguments);

/// The work of the process that reads a CAD file for another, and its exit code, if the arguments are of that.
[[nodiscard]] std::optional<int> cad_reader(std::span<const char* const> arguments);

}  // namespace camber::app

export namespace camber::app {

/// `did you mean "curve"?` where the word is one slip away from a known one (a letter too many, missing, wrong, or two
/// swapped) or its beginning; else `known: …`.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace camber::app

/// Runs of programs that have their meshes in memory and not in files.
export namespace camber::app {

/// Values of a caller, by the names that a config or the arguments of a verb use (config::is_in_memory).
struct MemoryInputs {
    std::map<std::string, DecodedMesh, std::less<>> meshes = {};
    std::map<std::string, Solution, std::less<>> metrics = {};  ///< rows as a file of the mesh has them
    std::map<std::string, std::vector<run::NamedField>, std::less<>> solutions = {};
    run::Groups groups = {};  ///< names of references of an input mesh whose file has none
};

/// Storage of the names of references of a run's mesh.
enum class NamesOfGroups : std::uint8_t {
    in_its_file,    ///< those that the format has no place for are lost, and reported
    by_the_caller,  ///< the caller has them
};

/// The caller of a run: its values in memory, its request to stop, its progress, and the ranks that share the run.
struct Host {
    MemoryInputs memory_inputs = {};
    NamesOfGroups names = NamesOfGroups::in_its_file;
    std::stop_token stop = stop_on_signals();
    ProgressCallback progress = {};  ///< none: the terminal
    std::shared_ptr<Ranks> ranks = one_rank();
    GraphPartitioner partition = {};  ///< of what several ranks hold; none: there is none
};

/// The outputs that are files.
[[nodiscard]] config::Output files_of(config::Output output);

}  // namespace camber::app

/// The verbs over meshes in memory, for other languages (apps/python, apps/c): the same work as the program's, and the
/// same bytes. Errors: those of the verbs.
export namespace camber::app {

/// Result of a run.
struct MemoryResult {
    DecodedMesh mesh;
    std::string report = {};                     ///< JSON: docs/report.md
    std::optional<Solution> metric = {};         ///< at the vertices, where a stage made one
    std::vector<run::NamedField> solution = {};  ///< the input's fields on this mesh
    std::vector<std::string> notices = {};       ///< worth knowing, and no error
    bool meets_requirements = true;              ///< false: the report lists what it misses
    bool has_valid_elements = true;              ///< false: elements remain that are not certified valid
};

/// A config's stages, once; a mesh that begins with curves has no need of `elevate`. Its outputs that are files are
/// written.
[[nodiscard]] Outcome<MemoryResult> run_in_memory(config::Pipeline pipeline, Host host);

/// The solution on a mesh; `guess`: that of the cycle before, brought to it.
using Solver = std::function<Outcome<std::vector<run::NamedField>>(
    const DecodedMesh& mesh, const std::vector<run::NamedField>& guess, int cycle)>;

struct AdaptedInMemory {
    MemoryResult result;  ///< see run::row_of_result; with the solver's solution, where there is one
    std::string cycles;   ///< JSON: a row a cycle
    std::string reason;   ///< why they ended before their number; empty: they did not
};
/// A config's cycles; `solver`: empty, the config's metric or expression says what the mesh is adapted to. `degree`:
/// that meshes must have; 0: any.
[[nodiscard]] Outcome<AdaptedInMemory> adapt_in_memory(config::Pipeline pipeline, int degree, const Solver& solver,
                                                       Host host);

/// The report of `camber check`, as JSON (docs/report.md), and of each element its verdict and figures by name.
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

/// The page of `camber report`, as HTML.
[[nodiscard]] Outcome<std::string> page_in_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                                  const std::string& title, const run::PageOptions& options, Host host);

/// The report of `camber geometry`, as JSON.
[[nodiscard]] Outcome<std::string> geometry_in_memory(const DecodedMesh& mesh, const config::Geometry& geometry,
                                                      const run::InspectOptions& options, Host host);

/// The metric that a config's source and operations make on its input, at the vertices; its stages are not run.
struct MetricInMemory {
    Solution metric;
    double complexity = 0, largest_anisotropy = 0;
    std::vector<std::string> notices;
};
[[nodiscard]] Outcome<MetricInMemory> metric_in_memory(const config::Pipeline& pipeline, Host host);

/// Second derivatives of a field at the vertices.
[[nodiscard]] Outcome<Solution> hessians_in_memory(const DecodedMesh& mesh, const run::NamedField& field, Host host);

/// Fields of a mesh on another one.
[[nodiscard]] Outcome<std::vector<run::NamedField>> transfer_in_memory(const DecodedMesh& old_mesh,
                                                                       const DecodedMesh& new_mesh,
                                                                       std::vector<run::NamedField> fields,
                                                                       const TransferOptions& options, Host host);

/// A file's mesh with its fields, and a mesh to a file, as `camber convert` does both.
[[nodiscard]] Outcome<DecodedMesh> read_into_memory(const std::string& path, config::Flat flat,
                                                    const DecodeOptions& options, Host host);
[[nodiscard]] Outcome<std::vector<std::string>> write_from_memory(const DecodedMesh& mesh,
                                                                  const std::vector<run::NamedField>& fields,
                                                                  const std::string& path, const std::string& format,
                                                                  Host host);
/// The nodal fields that a mesh was read with.
[[nodiscard]] std::vector<run::NamedField> nodal_fields_of(const DecodedMesh& mesh);

/// A file of so many bytes that all ranks write, each its pieces; it has its name once all have done so. All ranks call
/// it, also one whose pieces failed: none writes then. Errors: of any rank; write, stopped.
[[nodiscard]] Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                                           const Outcome<std::span<const FilePiece>>& pieces,
                                           const Execution& execution);

/// The same of pieces that are made a few at a time, in so many turns; all ranks make theirs in each turn together.
[[nodiscard]] Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                                           std::size_t turns,
                                           const std::function<Outcome<std::vector<FilePiece>>(std::size_t)>& pieces_of,
                                           const Execution& execution);

/// Contents of a .meshb beside its rows.
template <int D>
struct MeshbContents {
    PartTotals totals;
    const LinearMesh<D>& lists;  ///< corners, ridges, required entities, groups
};

/// A .meshb of these totals and lists that all ranks write so: in each turn a part of its rows, and along with the
/// first rank's first what the file begins and ends with.
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
