module;
#include <span>
#include <string>
export module camber.app_shell:command_line;

export namespace camber::app {

/// How the program was called, for what tells of it: set once, when it begins.
void set_command_line(std::span<char*> arguments);
/// As one would type it again, with quotes where a shell wants them; the program by its plain name.
[[nodiscard]] const std::string& command_line();

}  // namespace camber::app
