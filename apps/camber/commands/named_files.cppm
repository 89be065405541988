module;
#include <cstdint>
#include <string>
#include <vector>
module camber.commands:named_files;
import camber.core;
import camber.config;

namespace camber::app {

enum class Role : std::uint8_t { input, input_mesh, output_mesh, output };

/// A file that a verb reads or writes.
struct NamedFile {
    std::string path, word;  ///< the word by which it was named: an option, or a place in the config
    Role role;
};

/// Whether every path can be one, and no output is also an input or another output, by whatever path or link. Only the
/// mesh that is made may take the place of the one it is made from. Asked before any work is done. Errors: usage.
[[nodiscard]] Outcome<Done> check_named_files(const std::vector<NamedFile>& files);

/// How a pipeline's files were named.
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
