module;
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
module camber.io:vtk_source;
import camber.core;
import :legal_names;
import :text;
import :vtu_file;

namespace camber::vtk {

/// Names of fields: as in VTU, and none that is a keyword among arrays.
[[nodiscard]] FieldNames field_names();

inline constexpr const char* damaged = "the file is cut off or damaged";
using Failure = decltype(fail(std::declval<Error>()));

[[nodiscard]] inline std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

/// Walks a legacy VTK file from its begin to its end: words and lines of text, and numbers, which may be binary.
struct Source {
    std::string name;  ///< the file's
    std::string_view text;
    std::size_t at = 0, keyword = 0;  ///< here, and where the section began: the place of errors
    bool binary = false;

    [[nodiscard]] std::string place() const { return line_place(name, text, text.data() + keyword); }
    [[nodiscard]] bool at_end() const { return at == text.size(); }
    void skip_blanks() {
        while (at < text.size() && is_blank(text[at])) ++at;
    }
    std::string_view word() {
        skip_blanks();
        const std::size_t begin = at;
        while (at < text.size() && !is_blank(text[at])) ++at;
        return text.substr(begin, at - begin);
    }
    std::string_view line() {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string_view found = text.substr(at, end - at);
        at = std::min(end + 1, text.size());
        if (found.ends_with('\r')) found.remove_suffix(1);
        return found;
    }
    std::optional<std::uint64_t> count() {
        const std::string_view digits = word();
        std::uint64_t value = 0;
        const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc{} || stop != digits.data() + digits.size() || value > text.size() * 8 + 8)
            return std::nullopt;
        return value;
    }
    [[nodiscard]] Failure wrong(std::string what, std::string remedy = damaged) const {
        return fail(ErrorKind::input, std::move(what), place(), {}, std::move(remedy));
    }
    [[nodiscard]] Failure refused(std::string what, std::string remedy) const {
        return fail(ErrorKind::unsupported, std::move(what), place(), {}, std::move(remedy));
    }

    /// So many rows of numbers of VTK's type. Errors: input (more than follow, malformed), unsupported (no numbers).
    [[nodiscard]] Outcome<vtu::Numbers> numbers(const std::string& type, std::uint64_t rows, std::uint64_t components);
};

}  // namespace camber::vtk
