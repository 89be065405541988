module;
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
module camber.commands:output;
import camber.core;
import camber.ordering;
import camber.io;
import camber.distributed;
import camber.config;
import camber.recipes;
import camber.reports;
import :requests;

namespace camber::app {

/// Whether a pipeline goes by blocks: it says of how many elements, or several ranks share it.
[[nodiscard]] bool goes_by_blocks(const config::Pipeline& pipeline, const Host& host);

/// Runs a pipeline by blocks on all ranks of the host, and writes its outputs. Of several ranks each reads the rows of
/// a binary .meshb that it works on, and writes its own at their offsets; other formats are read as a whole. The mesh
/// of the result is empty: it is in the file.
[[nodiscard]] Outcome<run::Run> execute_by_blocks(const config::Pipeline& pipeline, Written& written, Host host);

/// Whether the path is that of a file that names its pieces (.pvtu): written in parts only.
[[nodiscard]] bool names_its_pieces(const std::string& path);
/// What is said where such a file is asked for, and not in how many parts.
[[nodiscard]] Outcome<Done> in_parts_alone(const std::string& path);
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

/// What ranks have of a mesh in parts (of `whole` rows), as pieces that a .pvtu names: all ranks call it. The names of
/// the pieces. Errors, of any rank: usage, write, memory, stopped.
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

/// Whether the shape is made by rows, and so by several ranks. Errors: those of the shape; unsupported, with what to
/// do.
[[nodiscard]] Outcome<Done> check_goes_by_rows(const config::Shape& shape);

/// The shape's mesh in a .meshb, to which each rank writes the rows that it makes, a few at a time: the bytes are those
/// of the mesh as a whole. What it is, on all ranks. Errors: of any rank; those of the shape, write, stopped.
[[nodiscard]] Outcome<run::PlanSize> write_by_rows(Ranks& ranks, const config::Shape& shape, const std::string& path,
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

/// What simplices a binary file has. Errors: input.
[[nodiscard]] Outcome<GmfShape> shape_of_file(const std::string& path);

/// A mesh of degree 1 in memory, made sound, in an order in which what is near is near.
template <int D>
[[nodiscard]] Outcome<Opened<D>> prepared(Mesh<D> given, std::vector<std::string>& notices, const Execution& execution);

/// What the mesh that a run began with was as a file.
struct InputForm {
    std::string_view format = {};
    bool always_in_space = false;   ///< its format has no plane
    std::optional<Lift> lift = {};  ///< of a flat one: back to its plane
};

/// Writes the files of a run that the config names, and adds them to those written; but for the report, which tells
/// also what writing them cost. All ranks ask: rows are written by all, what all have by the first.
/// Errors: usage, an ending; write.
Outcome<Done> write_outputs(run::Run& run, const config::Output& files, const InputForm& input, const Around& around,
                            Written& written, const Host& host);

/// Checks that the file of a page ends in .html, before the work is done. Errors: usage.
[[nodiscard]] Outcome<Done> check_page(const std::string& path);

/// A page of a mesh that was checked; `source` without title, version and command; `mesh`: its path, which names
/// the page. Errors: those of `run::page` and of writing.
[[nodiscard]] Outcome<Done> write_page(run::PageSource source, const std::string& mesh, const std::string& path,
                                       const run::PageOptions& options, const Execution& execution);

/// What the texts of the arguments mean. Errors: usage.
[[nodiscard]] Outcome<run::PictureChoice> choice_of(const PictureArguments& arguments);

}  // namespace camber::app
