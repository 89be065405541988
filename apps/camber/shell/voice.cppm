module;
#include <cstdint>
export module camber.app_shell:voice;

export namespace camber::app {

/// What the program says beside its errors and the data that is asked for: tables, notes and progress, or none of them.
enum class Voice : std::uint8_t { usual, quiet };

/// Set once, before a verb begins.
void set_voice(Voice voice);
[[nodiscard]] Voice voice();

}  // namespace camber::app
