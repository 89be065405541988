module;
#include <cstdint>
export module camber.app_shell:voice;

export namespace camber::app {

/// What the program says beside its errors and the data that is asked for: tables, notes and progress, or none of them
/// (quiet). None: nothing at all, where another process says it.
enum class Voice : std::uint8_t { usual, quiet, none };

/// Set before a verb begins; who has none gets none back.
void set_voice(Voice voice);
[[nodiscard]] Voice voice();

}  // namespace camber::app
