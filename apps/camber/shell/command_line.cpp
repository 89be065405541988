module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
module camber.app_shell;
import :command_line;

namespace camber::app {

namespace {

std::string& the_line() {
    static std::string line;
    return line;
}

std::string quoted(std::string_view word) {
    constexpr std::string_view plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./:,@%";
    if (!word.empty() && word.find_first_not_of(plain) == std::string_view::npos) return std::string(word);
    std::string text = "'";
    for (const char c : word)
        if (c == '\'')
            text += "'\\''";
        else
            text += c;
    return text + "'";
}

}  // namespace

void set_command_line(std::span<char*> arguments) {
    std::string line = "camber";
    for (std::size_t i = 1; i < arguments.size(); ++i) line += " " + quoted(arguments[i]);
    the_line() = line;
}

const std::string& command_line() { return the_line(); }

}  // namespace camber::app
