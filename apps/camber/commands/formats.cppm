module;
#include <optional>
#include <string>
#include <string_view>
#include <vector>
module camber.commands:formats;
import camber.core;
import camber.app_shell;
import camber.io;
import camber.run;
import :ending;

namespace camber::app {

/// Whether what is given as a solution is a file, by its ending or as one is there; else it is an expression.
[[nodiscard]] bool names_a_file(const std::string& text);
/// Whether the ending is that of a format of solutions.
[[nodiscard]] bool is_solution_file(std::string_view path);

/// The format of a mesh that is written: the one of that name, or else by the path's ending, where `source` says of
/// which format the input is (see format_to_write_again); standard output has no ending. Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_of_mesh(const std::string& path, std::string_view name,
                                                        std::string_view source = {});
[[nodiscard]] Outcome<const SolutionFormat*> format_of_solution(const std::string& path, std::string_view name);
/// Whether what is written there is a solution alone: by the format's name, or the path's ending.
[[nodiscard]] bool is_solution_output(const std::string& path, std::string_view name);

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
void tell_renames(const MeshFormat& format, const MeshFields& fields);

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

}  // namespace camber::app
