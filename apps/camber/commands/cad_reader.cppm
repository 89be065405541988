module;
#include <optional>
#include <span>
export module camber.commands:cad_reader;
import camber.core;
import camber.cad;
import camber.config;

export namespace camber::app {

/// The work of the process that reads a CAD file for another, and its exit code, if the arguments are of that.
[[nodiscard]] std::optional<int> cad_reader(std::span<const char* const> arguments);

}  // namespace camber::app

namespace camber::app {

/// The model of a config's file, read by a process of its own: what crashes, never ends or takes all memory on a
/// damaged file is an error of the file (input). Errors also: of read_cad.
[[nodiscard]] Outcome<CadModel> read_cad_apart(const config::Cad& cad, const Execution& execution);

}  // namespace camber::app
