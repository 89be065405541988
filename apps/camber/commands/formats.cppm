module;
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>
export module camber.commands:formats;
import camber.core;
import camber.config;
import camber.io;
import camber.run;
import :ending;

namespace camber::app {

/// The formats that a mesh can be written in, told by the ending of the file's name.
enum class MeshFormat : std::uint8_t { gmf_ascii, gmf_binary, vtu };

/// Errors (usage): an ending that is none of .mesh, .meshb, .vtu.
[[nodiscard]] Outcome<MeshFormat> mesh_format_of(std::string_view path);

/// Whether the ending is that of a solution file, .sol or .solb.
[[nodiscard]] bool is_solution_file(std::string_view path);

/// The mesh in the format of the path's ending; the fields only where that has place for them (.vtu).
[[nodiscard]] Outcome<Done> write_mesh(const AnyMesh& mesh, const MeshFields& fields, VtuOptions options,
                                       const std::string& path, const Execution& execution);

/// The solution as ASCII (.sol) or binary (.solb).
[[nodiscard]] Outcome<Done> write_solution(const Solution& solution, const std::string& path,
                                           const Execution& execution);

/// A solution file's content.
[[nodiscard]] Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution);

[[nodiscard]] Outcome<Done> write_text(const std::string& path, std::string_view text);

/// The folder of an output, made if it is not there.
[[nodiscard]] Outcome<Done> make_folder_of(const std::string& path);

/// What the mesh loses in the format of the path's ending.
[[nodiscard]] std::vector<Notice> losses(const AnyMesh& mesh, std::string_view path);

/// The files that plots in a folder may become, one a quantity.
[[nodiscard]] std::vector<std::string> plot_files(const std::string& folder);
[[nodiscard]] Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder,
                                        Written& written);

[[nodiscard]] VtuOptions vtu_options(config::VtuCells cells);

}  // namespace camber::app
