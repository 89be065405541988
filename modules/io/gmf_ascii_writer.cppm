module;
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
export module camber.io:gmf_ascii_writer;
import camber.core;
import :any_mesh;
import :gmf_keywords;
import :gmf_row;

namespace camber::gmf {

/// Room for the longest integer or shortest-digits real (−1.2345678901234567e−308) and a blank.
inline constexpr std::size_t word_room = 26;

/// Writes `value` and a separator to where there is room; returns the end.
template <class Number>
[[nodiscard]] inline char* write_word(char* to, Number value, char separator) {
    to = std::to_chars(to, to + word_room - 1, value).ptr;
    *to = separator;
    return to + 1;
}

/// A sink that makes an ASCII file: a row a line, reals with the fewest digits that give them back.
class AsciiWriter {
  public:
    AsciiWriter(int version, const Execution& execution) : execution_(execution) {
        put("MeshVersionFormatted " + std::to_string(version) + "\n");
    }

    Outcome<Done> value(Keyword keyword, std::int64_t value) {
        put("\n" + std::string(name_of(keyword)) + " " + std::to_string(value) + "\n");
        return Done{};
    }

    template <class RowType>
    Outcome<Done> rows(Keyword keyword, std::size_t n, const auto& row) {
        if (n == 0 && keyword != Keyword::vertices) return Done{};
        put("\n" + std::string(name_of(keyword)) + "\n" + std::to_string(n) + "\n");
        return lines(n, RowType::words, [&](std::size_t i, char* to) { return write_row(to, row(i)); });
    }

    /// A count, integers on one line (field types), and rows of `width` reals.
    Outcome<Done> solution(std::size_t rows, std::span<const std::int32_t> header, std::span<const double> values) {
        std::string text = "\n" + std::string(name_of(Keyword::sol_at_vertices)) + "\n" + std::to_string(rows) + "\n";
        for (const std::int32_t word : header) text += std::to_string(word) + " ";
        text.back() = '\n';
        put(text);
        const std::size_t width = rows == 0 ? 0 : values.size() / rows;
        return lines(rows, width, [&](std::size_t i, char* to) {
            for (std::size_t c = 0; c < width; ++c)
                to = write_word(to, values[i * width + c], c + 1 == width ? '\n' : ' ');
            return to;
        });
    }

    [[nodiscard]] Chunks finish() && {
        put("\nEnd\n");
        return std::move(chunks_);
    }

  private:
    template <class RowType>
    [[nodiscard]] static inline char* write_row(char* to, const RowType& row) {
        const auto integers = [&](char* at) {
            for (const std::int64_t integer : row.integer) at = write_word(at, integer, ' ');
            return at;
        };
        const auto reals = [&](char* at) {
            for (const double real : row.real) at = write_word(at, real, ' ');
            return at;
        };
        to = RowType::order == RowOrder::reals_first ? integers(reals(to)) : reals(integers(to));
        to[-1] = '\n';
        return to;
    }

    /// One line for each row by write(row number, where) → end, in parallel: a chunk of bytes for some rows.
    Outcome<Done> lines(std::size_t n, std::size_t words, const auto& write) {
        constexpr std::size_t grain = 4096;
        const std::size_t before = chunks_.size();
        chunks_.resize(before + (n + grain - 1) / grain);
        return each_chunk(
            execution_, n,
            [&](std::size_t first, std::size_t last) {
                Buffer<char> text((last - first) * words * word_room);
                char* to = text.data();
                for (std::size_t i = first; i < last; ++i) to = write(i, to);
                Buffer<std::byte> bytes(static_cast<std::size_t>(to - text.data()));
                std::memcpy(bytes.data(), text.data(), bytes.size());
                chunks_[before + first / grain] = std::move(bytes);
            },
            grain);
    }

    void put(std::string_view text) {
        Buffer<std::byte> bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        chunks_.push_back(std::move(bytes));
    }

    const Execution& execution_;
    Chunks chunks_;
};

}  // namespace camber::gmf
