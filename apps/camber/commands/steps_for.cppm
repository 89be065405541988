module;
#include <functional>
module camber.commands:steps_for;
import camber.core;
import camber.app_shell;
import camber.io;
import camber.run;
import :given;
import :in_memory;

namespace camber::app {

/// Steps of which the host is told, and which it may stop.
[[nodiscard]] inline Around steps_for(Progress& progress, const Host& host, int threads) {
    return steps_shown(progress, Execution{.threads = threads, .stop = host.stop});
}

/// A run's outcome, its mesh where the input was.
[[nodiscard]] MadeInMemory made_of(run::Run run, const DecodedMesh& input);

}  // namespace camber::app
