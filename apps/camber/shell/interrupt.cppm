module;
#include <stop_token>
export module camber.app_shell:interrupt;

export namespace camber::app {

/// Ctrl-C and SIGTERM become the request to stop; a second one ends the process as if nobody had listened. Writing to a
/// closed pipe or past a file-size limit becomes an error of that write. Call once, before the work.
[[nodiscard]] std::stop_token stop_on_signals();

}  // namespace camber::app
