module;
#include <string>
#include <string_view>
#include <vector>
module camber.commands:formats;
import camber.core;
import camber.io;
import camber.run;
import :ending;

namespace camber::app {

/// Whether what is given as a solution is a file, by its ending or as one is there; else it is an expression.
[[nodiscard]] bool names_a_file(const std::string& text);
/// Whether the ending is that of a format of solutions.
[[nodiscard]] bool is_solution_file(std::string_view path);

/// The mesh in this format; the fields only where that has place for them.
[[nodiscard]] Outcome<Done> write_mesh(const MeshFormat& format, const AnyMesh& mesh, const MeshFields& fields,
                                       EncodeOptions options, const std::string& path, const Execution& execution);
[[nodiscard]] Outcome<Done> write_solution(const SolutionFormat& format, const Solution& solution,
                                           const std::string& path, const Execution& execution);

/// A solution file's content, in whichever format it is.
[[nodiscard]] Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution);

[[nodiscard]] Outcome<Done> write_text(const std::string& path, std::string_view text);

/// The folder of an output, made if it is not there.
[[nodiscard]] Outcome<Done> make_folder_of(const std::string& path);

/// The files that plots in a folder may become, one a quantity.
[[nodiscard]] std::vector<std::string> plot_files(const std::string& folder);
[[nodiscard]] Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder,
                                        Written& written);

}  // namespace camber::app
