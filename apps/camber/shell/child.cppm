module;
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>
export module camber.app_shell:child;
import camber.core;

/// This program once more, for work that may crash or never end: what libraries do on damaged files.
export namespace camber::app {

struct ChildLimits {
    double seconds = 0;     ///< by the clock, and of a processor
    std::size_t bytes = 0;  ///< of address space
};

enum class ChildEnd : std::uint8_t { done, crashed, out_of_time };
struct ChildResult {
    ChildEnd end = ChildEnd::done;
    std::string bytes;  ///< that it handed over
    std::string how;    ///< it crashed
};

/// By which words this program is started once more: first the file, then arguments that come before others. At first
/// /proc/self/exe. None: it cannot be, as a library of programs that know nothing of it.
void start_itself_by(std::vector<std::string> words);
[[nodiscard]] bool can_start_itself();

/// Runs this program with other arguments, and waits. It dies with its parent. Errors: stopped; internal, it cannot be
/// started.
[[nodiscard]] Outcome<ChildResult> run_self(const std::vector<std::string>& arguments, const ChildLimits& limits,
                                            const Execution& execution);

/// In the child: nothing beyond the limits from now on (under the address sanitizer, which takes all address space, but
/// for memory).
void keep_limits(const ChildLimits& limits);

/// In the child: what the parent gets. Whether it got all of it.
[[nodiscard]] bool hand_over(std::string_view bytes);

}  // namespace camber::app
