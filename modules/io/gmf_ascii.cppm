module;
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <system_error>
export module camber.io:gmf_ascii;
import camber.core;
import :gmf_binary;
import :gmf_file;
import :gmf_row;

namespace camber::gmf {

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

/// False when a word is no number of its kind.
template <class RowType>
[[nodiscard]] inline bool read_row(Words& words, RowType& row) {
    if constexpr (RowType::order == RowOrder::reals_first)
        for (double& real : row.real)
            if (!read_number(words, real)) return false;
    for (std::int64_t& integer : row.integer)
        if (!read_number(words, integer)) return false;
    if constexpr (RowType::order == RowOrder::integers_first)
        for (double& real : row.real)
            if (!read_number(words, real)) return false;
    return true;
}

[[nodiscard]] inline Words words_between(const File& file, std::size_t begin, std::size_t end) {
    const char* const text = reinterpret_cast<const char*>(file.bytes.data());
    return {text + begin, text + end};
}

/// store(row number, row) → Fault for each row of a checked block, piece by piece in parallel: a piece's thread reads
/// the rows that begin in it.
template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_ascii_rows(const File& file, const Block& block, const Execution& execution,
                                            Store& store) {
    constexpr std::size_t width = RowType::words;
    const auto read_one = [&](std::size_t i, Words& words) {
        RowType row;
        return read_row(words, row) ? store(i, row) : Fault{.kind = FaultKind::syntax};
    };
    FirstFault first;
    auto done = each_chunk(
        execution, block.pieces.size(),
        [&](std::size_t begin, std::size_t end) {
            const std::size_t first_word = block.pieces[begin].first_word;
            const std::size_t last_word = end < block.pieces.size() ? block.pieces[end].first_word : block.words;
            std::size_t row = (first_word + width - 1) / width;
            Words words = words_between(file, block.pieces[begin].begin, block.end);
            words.skip(row * width - first_word);
            for (; row < block.count && row * width < last_word; ++row)
                if (read_one(row, words).kind != FaultKind::none) return first.note(row);
        },
        1);
    if (!done) return done;
    if (!first.any()) return Done{};
    const std::size_t at = row_begin(file, block, first.row(), RowType::integers, RowType::reals);
    Words words = words_between(file, at, block.end);
    return fail(fault_error(file, block, first.row(), at, read_one(first.row(), words)));
}

}  // namespace camber::gmf
