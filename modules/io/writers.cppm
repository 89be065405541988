module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io:writers;
import camber.core;
import :gmf;
import :meshes;
import :msh;
import :text;

namespace camber {

/// Maximum number of bytes of a number and a blank. The longest is a real such as −1.2345678901234567e−308, in the
/// shortest decimal form that restores it.
inline constexpr std::size_t word_room = 26;

/// Writes a number and the separator; returns the position after them. `to` must have space for `word_room` bytes.
template <class Number>
[[nodiscard]] inline char* write_word(char* to, Number value, char separator) {
    to = std::to_chars(to, to + word_room - 1, value).ptr;
    *to = separator;
    return to + 1;
}

/// Part of the progress for writing the next `words` words, out of `all` words of the file. Adds `words` to `written`.
[[nodiscard]] inline Execution next_part(const Execution& execution, std::size_t words, std::size_t& written,
                                         std::size_t all) {
    if (all == 0) return without_progress(execution);
    const auto share = [all](std::size_t n) { return static_cast<double>(n) / static_cast<double>(all); };
    const double from = share(written);
    return part_of(execution, from, share(written += words));
}

class TextWriter {
  public:
    /// `words`: number of words in all lines, to which the progress is relative; 0: no progress.
    explicit TextWriter(const Execution& execution, std::size_t words = 0) : execution_(execution), words_(words) {}

    void put(std::string_view text) {
        Buffer<std::byte> bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        chunks_.push_back(std::move(bytes));
    }

    /// Writes n lines of at most `words` words, in parallel. write(line number, to) writes a line and returns its end.
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

namespace camber::gmf {

/// Writes ASCII files: a line for each row, with the shortest decimals that restore the reals.
class AsciiWriter {
  public:
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

namespace camber::msh {

template <class Integer, std::size_t Integers, std::size_t Reals>
struct Row {
    static constexpr std::size_t words = Integers + Reals;
    static constexpr std::size_t integer_bytes = Integers * sizeof(Integer), real_bytes = Reals * sizeof(double);
    static constexpr std::size_t bytes = integer_bytes + real_bytes;
    std::array<Integer, Integers> integers = {};
    std::array<double, Reals> reals = {};
};

/// Writes MSH files. Numbers are words of text, or in binary files int32, uint64 and double in native byte order.
class Sink {
  public:
    Sink(MshEncoding encoding, const Execution& execution)
        : binary_(encoding == MshEncoding::binary), execution_(execution), text_(execution) {}

    [[nodiscard]] bool binary() const { return binary_; }

    void text(std::string_view text) { pending_ += text; }

    template <class... Numbers>
    void words(Numbers... numbers) {
        (append(numbers), ...);
    }
    void end_line() {
        if (!binary_) pending_.back() = '\n';
    }
    template <class... Numbers>
    void line(Numbers... numbers) {
        words(numbers...);
        end_line();
    }

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
    TextWriter text_;  ///< used for text files only
    Chunks packed_;
};

}  // namespace camber::msh

namespace camber::vtu {

template <class T>
inline constexpr std::string_view type_name = [] {
    if constexpr (std::is_same_v<T, double>) return std::string_view("Float64");
    if constexpr (std::is_same_v<T, std::int64_t>) return std::string_view("Int64");
    if constexpr (std::is_same_v<T, std::int32_t>) return std::string_view("Int32");
    if constexpr (std::is_same_v<T, std::uint8_t>) return std::string_view("UInt8");
}();

struct ArrayName {
    std::string name;
    std::vector<std::string> components = {};
};

/// Appended data of a VTU file. Each array has a header and its blocks, which are compressed separately. The header has
/// UInt64 numbers: number of blocks, bytes of a block, bytes of a shorter last block (0: none), compressed bytes of
/// each block.
class AppendedArrays {
  public:
    explicit AppendedArrays(const Execution& execution) : execution_(execution) {}

    /// Appends n numbers value(i), computed in parallel. Returns the XML element DataArray.
    template <class T, class Value>
    [[nodiscard]] Outcome<std::string> add(const ArrayName& name, std::size_t n, Value&& value) {
        const auto fill = [&](std::size_t first, std::size_t last, std::byte* to) {
            for (std::size_t i = first; i < last; ++i, to += sizeof(T)) {
                const T number = value(i);
                std::memcpy(to, &number, sizeof number);
            }
        };
        return append(type_name<T>, name, n, sizeof(T), fill);
    }

    [[nodiscard]] Chunks finish(std::string_view xml) &&;

  private:
    [[nodiscard]] Outcome<std::string> append(
        std::string_view type, const ArrayName& name, std::size_t n, std::size_t size,
        const std::function<void(std::size_t first, std::size_t last, std::byte* to)>& fill);

    const Execution& execution_;
    Chunks chunks_;
    std::size_t bytes_ = 0;
};

/// Names of components in VTK. The value of component k is component `sources[k]` of the field, or zero if `sources[k]`
/// is −1.
struct Components {
    std::vector<std::string> names;
    std::vector<int> sources;
};
[[nodiscard]] Components components_of(FieldKind kind, int dimension);

/// Rules for names in VTU files: not empty, not reserved, and legal in XML.
[[nodiscard]] FieldNames field_names();

[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace camber::vtu
