module;
#include <cstddef>
#include <string>
#include <string_view>
module camber.core;
import :quoted;

namespace camber {

namespace {

/// Whether a byte goes on with a letter of UTF-8.
bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

}  // namespace

std::string shortened(std::string_view text, std::size_t longest) {
    constexpr std::string_view gap = "…";
    if (text.size() <= longest) return std::string(text);
    const std::size_t room = longest > gap.size() ? longest - gap.size() : 0;
    std::size_t begin = room - room / 4, end = text.size() - room / 4;
    while (begin > 0 && continues(text[begin])) --begin;
    while (end < text.size() && continues(text[end])) ++end;
    return std::string(text.substr(0, begin)).append(gap).append(text.substr(end));
}

std::string in_quotes(std::string_view text) {
    std::string one_line = shortened(text);
    for (char& c : one_line)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
    return "\"" + one_line + "\"";
}

}  // namespace camber
