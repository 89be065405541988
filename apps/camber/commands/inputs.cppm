export module camber.commands:inputs;
import camber.core;
import camber.config;
import camber.run;
import :given;

namespace camber::app {

/// All that a run takes from files, or a generated mesh; what is given in memory from there. Errors: those of reading;
/// what the config says of files that are not there (usage).
[[nodiscard]] Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const Given& given,
                                               const Execution& execution);

}  // namespace camber::app
