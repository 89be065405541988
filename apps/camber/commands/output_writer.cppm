module;
#include <optional>
#include <string_view>
module camber.commands:output_writer;
import camber.core;
import camber.config;
import camber.io;
import camber.run;
import :given;

namespace camber::app {

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

}  // namespace camber::app
