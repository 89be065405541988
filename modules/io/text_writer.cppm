module;
#include <charconv>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <utility>
module camber.io:text_writer;
import camber.core;
import :notice;

namespace camber {

/// Room for the longest integer or shortest-digits real (−1.2345678901234567e−308) and a blank.
inline constexpr std::size_t word_room = 26;

/// Writes `value` and a separator to where there is room; returns the end.
template <class Number>
[[nodiscard]] inline char* write_word(char* to, Number value, char separator) {
    to = std::to_chars(to, to + word_room - 1, value).ptr;
    *to = separator;
    return to + 1;
}

/// For the next `words` of so many in all: their part of what `execution` tells of; `written` counts on.
[[nodiscard]] inline Execution next_part(const Execution& execution, std::size_t words, std::size_t& written,
                                         std::size_t all) {
    if (all == 0) return without_progress(execution);
    const auto share = [all](std::size_t n) { return static_cast<double>(n) / static_cast<double>(all); };
    const double from = share(written);
    return part_of(execution, from, share(written += words));
}

/// A text in chunks.
class TextWriter {
  public:
    /// `words`: in all lines, for the progress, which is not told where it is not known.
    explicit TextWriter(const Execution& execution, std::size_t words = 0) : execution_(execution), words_(words) {}

    void put(std::string_view text) {
        Buffer<std::byte> bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        chunks_.push_back(std::move(bytes));
    }

    /// n lines of at most so many numbers by write(line number, where) → end, in parallel.
    Outcome<Done> lines(std::size_t n, std::size_t words, const auto& write) {
        constexpr std::size_t grain = 4096;
        const std::size_t before = chunks_.size();
        chunks_.resize(before + (n + grain - 1) / grain);
        return each_chunk(
            next_part(execution_, n * words, written_, words_), n,
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

    [[nodiscard]] Chunks finish() && { return std::move(chunks_); }

  private:
    const Execution& execution_;
    std::size_t words_, written_ = 0;
    Chunks chunks_;
};

}  // namespace camber
