module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.io:gmf_ascii_writer;
import camber.core;
import :notice;
import :gmf_keywords;
import :gmf_row;
import :text_writer;

namespace camber::gmf {

/// A sink that makes an ASCII file: a row a line, reals with the fewest digits that give them back.
class AsciiWriter {
  public:
    /// `words`: in the rows of all blocks, for the progress.
    AsciiWriter(int version, std::size_t words, const Execution& execution) : text_(execution, words) {
        text_.put("MeshVersionFormatted " + std::to_string(version) + "\n");
    }

    Outcome<Done> value(Keyword keyword, std::int64_t value) {
        text_.put("\n" + std::string(name_of(keyword)) + " " + std::to_string(value) + "\n");
        return Done{};
    }

    template <class RowType>
    Outcome<Done> rows(Keyword keyword, std::size_t n, const auto& row) {
        if (n == 0 && keyword != Keyword::vertices) return Done{};
        text_.put("\n" + std::string(name_of(keyword)) + "\n" + std::to_string(n) + "\n");
        return text_.lines(n, RowType::words, [&](std::size_t i, char* to) { return write_row(to, row(i)); });
    }

    /// A count, integers on one line (field types), and rows of `width` reals.
    Outcome<Done> solution(std::size_t rows, std::span<const std::int32_t> header, std::span<const double> values) {
        std::string text = "\n" + std::string(name_of(Keyword::sol_at_vertices)) + "\n" + std::to_string(rows) + "\n";
        for (const std::int32_t word : header) text += std::to_string(word) + " ";
        text.back() = '\n';
        text_.put(text);
        const std::size_t width = rows == 0 ? 0 : values.size() / rows;
        return text_.lines(rows, width, [&](std::size_t i, char* to) {
            for (std::size_t c = 0; c < width; ++c)
                to = write_word(to, values[i * width + c], c + 1 == width ? '\n' : ' ');
            return to;
        });
    }

    [[nodiscard]] Chunks finish() && {
        text_.put("\nEnd\n");
        return std::move(text_).finish();
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

    TextWriter text_;
};

}  // namespace camber::gmf
