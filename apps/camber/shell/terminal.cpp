module;
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
module camber.app_shell;

namespace camber::app {

namespace {

constexpr std::size_t widest = 100, narrowest = 60;

/// What is before the first `mark`; that and the mark are taken from the text.
std::string_view taken(std::string_view& text, char mark) {
    const std::size_t end = std::min(text.find(mark), text.size());
    const std::string_view front = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return front;
}

}  // namespace

std::size_t text_width() {
    struct winsize size{};
    if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return widest;
    return std::clamp<std::size_t>(size.ws_col, narrowest, widest);
}

std::string wrapped(std::string_view text, std::size_t width, std::size_t indent) {
    const std::string margin(indent, ' ');
    std::string out;
    while (!text.empty()) {
        std::string_view line = taken(text, '\n');
        const bool as_it_is = line.starts_with(' ');
        if (!out.empty()) out += line.empty() ? "\n" : "\n" + margin;
        if (as_it_is) {
            out += line;
            continue;
        }
        for (std::size_t at = indent; !line.empty();) {
            const std::string_view word = taken(line, ' ');
            if (at > indent && at + 1 + word.size() > width) {
                out += "\n" + margin;
                at = indent;
            }
            if (at > indent) out += ' ', ++at;
            out += word;
            at += word.size();
        }
    }
    return out;
}

}  // namespace camber::app
