module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io:msh_source;
import camber.core;
import :gmf_binary;
import :gmf_file;
import :text;

namespace camber::msh {

/// What the rows of a table consist of: whole numbers of so many bytes (in binary files), then reals of 8.
struct RowShape {
    std::size_t integers = 0, integer_bytes = 4, reals = 0;
    [[nodiscard]] std::size_t words() const { return integers + reals; }
    [[nodiscard]] std::size_t bytes() const { return integers * integer_bytes + reals * sizeof(double); }
};

/// A row of a binary file, read where it lies.
template <class Integer, gmf::ByteOrder Order>
struct PackedRow {
    const std::byte* from;
    std::size_t integers;
    [[nodiscard]] std::int64_t integer(std::size_t i) const {
        return gmf::load<Integer, Order>(from + i * sizeof(Integer));
    }
    [[nodiscard]] double real(std::size_t i) const {
        return gmf::load<double, Order>(from + integers * sizeof(Integer) + i * sizeof(double));
    }
};

/// A row of a text file.
struct TextRow {
    std::vector<std::int64_t> integers;
    std::vector<double> reals;
    [[nodiscard]] std::int64_t integer(std::size_t i) const { return integers[i]; }
    [[nodiscard]] double real(std::size_t i) const { return reals[i]; }
};

/// Walks an MSH file from its begin to its end. Numbers are words of text, or in binary files int32, 8-byte counts and
/// tags, and double; each function is false where there is no such number.
class Source {
  public:
    Source(std::span<const std::byte> bytes, std::string_view name) : bytes_(bytes), name_(name) {}

    bool binary = false, swapped = false;

    [[nodiscard]] std::size_t at() const { return at_; }
    void go_to(std::size_t at) { at_ = at; }
    [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
    [[nodiscard]] std::string_view rest() const { return {reinterpret_cast<const char*>(bytes_.data()) + at_, left()}; }
    [[nodiscard]] const std::string& name() const { return name_; }

    /// `name: line N`, `name: byte N` of here.
    [[nodiscard]] std::string place() const {
        if (binary) return name_ + ": byte " + std::to_string(at_);
        const auto before =
            std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_), std::byte{'\n'});
        return name_ + ": line " + std::to_string(before + 1);
    }
    [[nodiscard]] auto error(std::string what, std::string remedy = {}) const {
        return fail(ErrorKind::input, std::move(what), place(), {}, std::move(remedy));
    }

    /// This source at row i of a table that begins at `begin`.
    [[nodiscard]] Source at_row(std::size_t begin, std::size_t i, RowShape shape) const {
        Source row = *this;
        row.at_ = begin + (binary ? i * shape.bytes() : 0);
        if (binary) return row;
        const std::string_view text = row.rest();
        Words words{text.data(), text.data() + text.size()};
        words.skip(i * shape.words());
        static_cast<void>(words.find());
        row.at_ = bytes_.size() - static_cast<std::size_t>(words.end - words.at);
        return row;
    }

    void skip_blanks() {
        const std::string_view text = rest();
        std::size_t n = 0;
        while (n < text.size() && is_blank(text[n])) ++n;
        at_ += n;
    }
    /// What is left of this line, without its end; goes to the next one.
    std::string_view line() {
        std::string_view text = rest();
        const std::size_t end = text.find('\n');
        at_ += end == std::string_view::npos ? text.size() : end + 1;
        text = text.substr(0, end);
        return text.ends_with('\r') ? text.substr(0, text.size() - 1) : text;
    }

    /// Of text, in files of either kind.
    template <class Number>
    bool text_number(Number& value) {
        const std::string_view text = rest();
        Words words{text.data(), text.data() + text.size()};
        const bool read = read_number(words, value);
        at_ = bytes_.size() - static_cast<std::size_t>(words.end - words.at);
        return read;
    }
    /// Between ±(2^31 − 1): its magnitude is one too.
    bool integer(std::int64_t& value) {
        const bool read = binary ? packed<std::int32_t>(value) : text_number(value);
        constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
        return read && value >= -most && value <= most;
    }
    bool count(std::uint64_t& value) {
        std::int64_t number = 0;
        if (!(binary ? packed<std::int64_t>(number) : text_number(number)) || number < 0) return false;
        value = static_cast<std::uint64_t>(number);
        return true;
    }
    bool real(double& value) { return binary ? packed<double>(value) : text_number(value); }

    /// Whether n rows can be in what is left of the file.
    [[nodiscard]] bool has_room(std::uint64_t n, RowShape shape) const {
        return n <= (left() + 1) / std::max<std::size_t>(1, binary ? shape.bytes() : 2 * shape.words()) &&
               n <= max_entities;
    }

    /// store(i, row) for each of n rows that have room; in parallel if the file is binary. Errors: input (what is no
    /// number), stopped.
    template <class Store>
    [[nodiscard]] Outcome<Done> rows(std::size_t n, RowShape shape, const Execution& execution, Store&& store) {
        if (!binary) return text_rows(n, shape, store);
        if (n * shape.bytes() > left()) return error("the file ends within a table", "it seems to be cut off");
        if (shape.integer_bytes == 8) return packed_rows<std::int64_t>(n, shape, execution, store);
        return packed_rows<std::int32_t>(n, shape, execution, store);
    }

  private:
    template <class T>
    bool packed(auto& value) {
        if (left() < sizeof(T)) return false;
        const std::byte* const from = bytes_.data() + at_;
        value = swapped ? gmf::load<T, gmf::ByteOrder::swapped>(from) : gmf::load<T, gmf::ByteOrder::native>(from);
        at_ += sizeof(T);
        return true;
    }

    template <class Store>
    Outcome<Done> text_rows(std::size_t n, RowShape shape, Store& store) {
        TextRow row{std::vector<std::int64_t>(shape.integers), std::vector<double>(shape.reals)};
        const std::string_view text = rest();
        Words words{text.data(), text.data() + text.size()};
        std::size_t read = 0;
        for (bool sound = true; read < n; ++read) {
            for (std::int64_t& value : row.integers) sound = sound && read_number(words, value);
            for (double& value : row.reals) sound = sound && read_number(words, value);
            if (!sound) break;
            store(read, std::as_const(row));
        }
        at_ = bytes_.size() - static_cast<std::size_t>(words.end - words.at);
        if (read < n) return error("here should be a number of a table", "the file is cut off or damaged");
        return Done{};
    }

    template <class Integer, class Store>
    Outcome<Done> packed_rows(std::size_t n, RowShape shape, const Execution& execution, Store& store) {
        if (swapped) return packed_rows<Integer, gmf::ByteOrder::swapped>(n, shape, execution, store);
        return packed_rows<Integer, gmf::ByteOrder::native>(n, shape, execution, store);
    }
    template <class Integer, gmf::ByteOrder Order, class Store>
    Outcome<Done> packed_rows(std::size_t n, RowShape shape, const Execution& execution, Store& store) {
        const std::byte* const from = bytes_.data() + at_;
        const std::size_t step = shape.bytes();
        at_ += n * step;
        return each(
            execution, n, [&](std::size_t i) { store(i, PackedRow<Integer, Order>{from + i * step, shape.integers}); },
            8192);
    }

    std::span<const std::byte> bytes_;
    std::string name_;
    std::size_t at_ = 0;
};

}  // namespace camber::msh
