module;
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>
module camber.io:text;
import camber.core;

/// Words and numbers of text files.
namespace camber {

[[nodiscard]] constexpr bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
[[nodiscard]] constexpr bool ends_word(char c) { return is_blank(c) || c == '#'; }

/// Walks the words of ASCII text between blanks and comments (`#` to the end of the line).
struct Words {
    const char* at;
    const char* end;

    /// Moves to the next word; false at the end.
    [[nodiscard]] inline bool find() {
        for (; at != end; ++at) {
            if (*at == '#') {
                while (at != end && *at != '\n' && *at != '\r') ++at;
                if (at == end) return false;
            } else if (!is_blank(*at)) {
                return true;
            }
        }
        return false;
    }
    inline void pass() {
        while (at != end && !ends_word(*at)) ++at;
    }
    /// The next word, or an empty one at the end.
    [[nodiscard]] inline std::string_view next() {
        if (!find()) return {};
        const char* const begin = at;
        pass();
        return {begin, static_cast<std::size_t>(at - begin)};
    }
    inline void skip(std::size_t words) {
        for (; words > 0 && find(); --words) pass();
    }
    [[nodiscard]] inline bool at_word_end() const { return at == end || ends_word(*at); }
};

/// `name: line N` of a place in a text.
[[nodiscard]] std::string line_place(std::string_view name, std::string_view text, const char* at);

/// Reads a number that the plain way cannot: a leading +, Fortran's exponent D, magnitudes beyond those of double.
[[nodiscard]] bool read_unusual_real(std::string_view word, double& value);

[[nodiscard]] inline bool read_number(Words& words, std::int64_t& value) {
    if (!words.find()) return false;
    if (*words.at == '+') ++words.at;
    const auto [stop, error] = std::from_chars(words.at, words.end, value);
    words.at = stop;
    return error == std::errc{} && words.at_word_end();
}

[[nodiscard]] inline bool read_number(Words& words, double& value) {
    if (!words.find()) return false;
    const char* const begin = words.at;
    const auto [stop, error] = std::from_chars(begin, words.end, value);
    words.at = stop;
    if (error == std::errc{} && words.at_word_end()) return true;
    words.at = begin;
    return read_unusual_real(words.next(), value);
}

}  // namespace camber
