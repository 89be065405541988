module;
#include <cstdint>
#include <string>
#include <vector>
export module camber.app_shell:command;
import camber.core;

/// A program of somebody else's, run without a shell.
export namespace camber::app {

enum class CommandEnd : std::uint8_t { done, failed, out_of_time };
struct CommandResult {
    CommandEnd end = CommandEnd::done;
    std::string how;  ///< it failed: "exit code 3", "segmentation fault"
    double seconds = 0;
};

/// Runs the command, found along PATH, with what it says on either stream in the file `output`, and nothing to read;
/// waits at most `seconds` (0: any time). It has a process group of its own: out of time or stopped, all of that is
/// asked to end, and killed two seconds later. Errors: usage, it cannot be started; write, of `output`; stopped.
[[nodiscard]] Outcome<CommandResult> run_command_line(const std::vector<std::string>& words, double seconds,
                                                      const std::string& output, const Execution& execution);

}  // namespace camber::app

namespace camber::app {

/// "segmentation fault" and the like.
[[nodiscard]] std::string name_of_signal(int signal);

}  // namespace camber::app
