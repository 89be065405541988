module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.io:mfem_source;
import camber.core;
import :text;

/// An MFEM file, word by word.
namespace camber::mfem {

inline constexpr const char* damaged = "the file is cut off or damaged";

[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The first line without what blanks end it.
[[nodiscard]] inline std::string_view first_line_of(std::string_view text) {
    const std::string_view line = text.substr(0, text.find('\n'));
    const std::size_t last = line.find_last_not_of(" \t\r");
    return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

/// The words of a file, and errors at their places.
struct Source {
    std::string name;
    std::string_view text;
    Words words;
    bool has_end = false;  ///< a line behind all that there is: since version 1.2

    [[nodiscard]] std::string place(const char* at) const { return line_place(name, text, at); }
    [[nodiscard]] auto fail_here(std::string what, std::string remedy = damaged) const {
        return fail(ErrorKind::input, std::move(what), place(words.at), {}, std::move(remedy));
    }
    [[nodiscard]] auto refuse_here(std::string what, std::string remedy) const {
        return fail(ErrorKind::unsupported, std::move(what), place(words.at), {}, std::move(remedy));
    }
    [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(words.end - words.at); }

    [[nodiscard]] Outcome<Done> expect(std::string_view word) {
        if (words.next() == word) return Done{};
        return fail_here(in_quotes(word) + " is missing here",
                         "the sections of MFEM's files have one order; " + std::string(damaged));
    }
    [[nodiscard]] Outcome<std::int64_t> number(const std::string& what) {
        std::int64_t value = 0;
        if (!read_number(words, value)) return fail_here("the number of " + what + " is missing or malformed");
        return value;
    }
    /// A number of rows of so many words at least.
    [[nodiscard]] Outcome<std::size_t> count(const std::string& what, std::size_t min_words) {
        const auto value = number(what);
        if (!value) return fail(value.error());
        if (*value < 0 || static_cast<std::uint64_t>(*value) > left() / (2 * min_words) + 1)
            return fail_here("announces " + std::to_string(*value) + " " + what + ", more than follow");
        if (static_cast<std::uint64_t>(*value) > max_entities)
            return refuse_here("has more " + what + " than 32 bits can number", "divide the mesh");
        return static_cast<std::size_t>(*value);
    }
};

struct Geometry {
    std::size_t vertices;
    const char* plural;
};
/// By MFEM's numbers.
inline constexpr std::array<Geometry, 8> geometries{{{1, "points"},
                                                     {2, "segments"},
                                                     {3, "triangles"},
                                                     {4, "quadrilaterals"},
                                                     {4, "tetrahedra"},
                                                     {8, "hexahedra"},
                                                     {6, "prisms"},
                                                     {5, "pyramids"}}};

}  // namespace camber::mfem
