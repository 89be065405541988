module;
#include <optional>
#include <string>
#include <vector>
export module camber.commands:cycles;
import camber.core;
import camber.config;
import :execute;
import :named_files;

namespace camber::app {

/// What is asked of cycles beside the config.
struct CyclesChoice {
    std::optional<int> from;  ///< the cycle of an earlier run that they go on from; none: they begin anew
    int degree = 0;           ///< that the mesh is to have; 0: any
};

/// Where the cycles of a config are kept; empty: nothing is.
[[nodiscard]] std::string kept_folder(const config::Pipeline& pipeline);

/// Runs a config's cycles: their table as it comes to be, messages, and the exit code. What they made last stands in
/// the config's outputs after every cycle.
[[nodiscard]] int run_cycles(const config::Pipeline& pipeline, const CyclesChoice& choice);

/// What became of a verb's arguments, whose files are named so: the cycles, or the plan of them.
[[nodiscard]] int run_or_plan_cycles(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                                     const CyclesChoice& choice, bool dry_run);

/// The same as text, with nothing done but reading the input.
[[nodiscard]] Outcome<std::string> plan_cycles(const config::Pipeline& pipeline, const CyclesChoice& choice);

}  // namespace camber::app
