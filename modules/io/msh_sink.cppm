module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
module camber.io:msh_sink;
import camber.core;
import :msh;
import :notice;
import :text_writer;

namespace camber::msh {

/// A row of a table: whole numbers, then reals.
template <class Integer, std::size_t Integers, std::size_t Reals>
struct Row {
    static constexpr std::size_t words = Integers + Reals;
    static constexpr std::size_t integer_bytes = Integers * sizeof(Integer), real_bytes = Reals * sizeof(double);
    static constexpr std::size_t bytes = integer_bytes + real_bytes;
    std::array<Integer, Integers> integers = {};
    std::array<double, Reals> reals = {};
};

/// Makes an MSH file: numbers are words of text, or in binary files int32, uint64 and double of this machine's order.
class Sink {
  public:
    Sink(MshEncoding encoding, const Execution& execution)
        : binary_(encoding == MshEncoding::binary), execution_(execution), text_(execution) {}

    [[nodiscard]] bool binary() const { return binary_; }

    /// Text in either kind of file.
    void text(std::string_view text) { pending_ += text; }

    /// Numbers one after the other.
    template <class... Numbers>
    void words(Numbers... numbers) {
        (append(numbers), ...);
    }
    /// After words: the end of their line, if this is a text.
    void end_line() {
        if (!binary_) pending_.back() = '\n';
    }
    template <class... Numbers>
    void line(Numbers... numbers) {
        words(numbers...);
        end_line();
    }

    /// n rows by row(i), in parallel.
    template <class RowType>
    [[nodiscard]] Outcome<Done> rows(std::size_t n, const auto& row) {
        flush();
        if (n == 0) return Done{};
        if (binary_) return packed_rows<RowType>(n, row);
        return text_.lines(n, RowType::words, [&](std::size_t i, char* to) { return written(row(i), to); });
    }

    void flush() {
        if (!pending_.empty()) put(pending_);
        pending_.clear();
    }
    void section(std::string_view name) { text("$" + std::string(name) + "\n"); }
    void end_section(std::string_view name) { text((binary_ ? "\n$End" : "$End") + std::string(name) + "\n"); }

    [[nodiscard]] Chunks finish() && {
        flush();
        return binary_ ? std::move(packed_) : std::move(text_).finish();
    }

  private:
    void put(std::string_view text) {
        if (!binary_) return text_.put(text);
        Buffer<std::byte> bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        packed_.push_back(std::move(bytes));
    }
    template <class RowType>
    [[nodiscard]] Outcome<Done> packed_rows(std::size_t n, const auto& row) {
        Buffer<std::byte> bytes(n * RowType::bytes);
        auto done = each(execution_, n, [&](std::size_t i) { pack(row(i), bytes.data() + i * RowType::bytes); }, 8192);
        packed_.push_back(std::move(bytes));
        return done;
    }
    template <class Number>
    void append(Number number) {
        if (binary_) {
            pending_.append(reinterpret_cast<const char*>(&number), sizeof number);
            return;
        }
        std::array<char, word_room> word{};
        pending_.append(word.data(), static_cast<std::size_t>(write_word(word.data(), number, ' ') - word.data()));
    }
    template <class RowType>
    static void pack(const RowType& row, std::byte* to) {
        if constexpr (RowType::integer_bytes > 0) std::memcpy(to, row.integers.data(), RowType::integer_bytes);
        if constexpr (RowType::real_bytes > 0)
            std::memcpy(to + RowType::integer_bytes, row.reals.data(), RowType::real_bytes);
    }
    template <class RowType>
    static char* written(const RowType& row, char* to) {
        for (const auto integer : row.integers) to = write_word(to, integer, ' ');
        for (const double real : row.reals) to = write_word(to, real, ' ');
        to[-1] = '\n';
        return to;
    }

    bool binary_;
    const Execution& execution_;
    std::string pending_;
    TextWriter text_;  ///< of a text
    Chunks packed_;    ///< of a binary file
};

}  // namespace camber::msh
