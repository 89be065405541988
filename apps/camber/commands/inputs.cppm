export module camber.commands:inputs;
import camber.core;
import camber.config;
import camber.run;

namespace camber::app {

/// All that a run takes from files, or a generated mesh. Errors: those of reading; what the config says of files that
/// are not there (usage).
[[nodiscard]] Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const Execution& execution);

}  // namespace camber::app
