module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
module camber.io:gmf_binary_writer;
import camber.core;
import :any_mesh;
import :gmf;
import :gmf_binary;
import :gmf_file;
import :gmf_keywords;
import :gmf_row;
import :text_writer;

namespace camber::gmf {

/// The version asked for, or the least when none is. Errors: usage.
[[nodiscard]] Outcome<int> chosen_version(GmfOptions options, int least);

/// A sink that finds how large the file would be, and the least version that holds it.
class BinarySizer {
  public:
    Outcome<Done> value(Keyword, std::int64_t) {
        narrow_ += 12;
        return Done{};
    }
    template <class RowType>
    Outcome<Done> rows(Keyword keyword, std::size_t n, const auto&) {
        if (n > 0 || keyword == Keyword::vertices) narrow_ += 12 + n * row_bytes(2, RowType::integers, RowType::reals);
        largest_ = std::max(largest_, n);
        words_ += n * RowType::words;
        return Done{};
    }
    void more(std::size_t bytes) { narrow_ += bytes; }
    [[nodiscard]] std::size_t words() const { return words_; }  ///< in all rows

    /// 2 below 2 GiB, 3 beyond, 4 when indices or counts need 64 bits (no index exceeds the largest count).
    [[nodiscard]] int min_version() const {
        constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
        if (largest_ > most) return 4;
        return narrow_ > most ? 3 : 2;
    }

  private:
    std::size_t narrow_ = 8 + 8;  // in version 2: mark and version; End and its position
    std::size_t words_ = 0;
    std::size_t largest_ = 0;
};

template <class LayoutType, class RowType>
inline void store_row(const RowType& row, std::byte* to) {
    using Integer = typename LayoutType::Integer;
    constexpr bool reals_first = RowType::order == RowOrder::reals_first;
    std::byte* const integers = reals_first ? to + RowType::reals * sizeof(double) : to;
    std::byte* const reals = reals_first ? to : to + RowType::integers * sizeof(Integer);
    for (int i = 0; i < RowType::integers; ++i) {
        const Integer integer = static_cast<Integer>(row.integer[i]);
        std::memcpy(integers + i * sizeof(Integer), &integer, sizeof integer);
    }
    for (int i = 0; i < RowType::reals; ++i) std::memcpy(reals + i * sizeof(double), &row.real[i], sizeof(double));
}

/// Calls f(Layout{}) with that of files of the version that this machine writes.
template <class F>
auto with_written_layout(int version, F&& f) {
    if (version == 4) return f(Layout<double, std::int64_t, ByteOrder::native>{});
    return f(Layout<double, std::int32_t, ByteOrder::native>{});
}

/// A sink that makes a binary file in this machine's byte order.
template <class LayoutType>
class BinaryWriter {
  public:
    using Integer = typename LayoutType::Integer;

    /// `words`: in the rows of all blocks, for the progress.
    BinaryWriter(int version, std::size_t words, const Execution& execution)
        : version_(version), words_(words), execution_(execution) {
        put_header({1, version});
    }

    Outcome<Done> value(Keyword keyword, std::int64_t value) {
        // Dimension keeps 4 bytes in every version.
        begin(keyword, 4);
        put(static_cast<std::int32_t>(value));
        return Done{};
    }

    template <class RowType>
    Outcome<Done> rows(Keyword keyword, std::size_t n, const auto& row) {
        if (n == 0 && keyword != Keyword::vertices) return Done{};
        constexpr std::size_t step = stride<RowType, LayoutType>;
        begin_rows(keyword, n, n * step);
        Buffer<std::byte> bytes(n * step);
        auto done = each_chunk(
            next_part(execution_, n * RowType::words, written_, words_), n,
            [&](std::size_t first, std::size_t last) {
                for (std::size_t i = first; i < last; ++i) store_row<LayoutType>(row(i), bytes.data() + i * step);
            },
            8192);
        position_ += bytes.size();
        chunks_.push_back(std::move(bytes));
        return done;
    }

    /// A count, integers of 4 bytes (field types), and reals as they are.
    Outcome<Done> solution(std::size_t rows, std::span<const std::int32_t> header, std::span<const double> values) {
        begin(Keyword::sol_at_vertices, sizeof(Integer) + header.size_bytes() + values.size_bytes());
        put(static_cast<Integer>(rows));
        for (const std::int32_t word : header) put(word);
        Buffer<std::byte> bytes(values.size_bytes());
        auto done = each_chunk(
            execution_, values.size(),
            [&](std::size_t first, std::size_t last) {
                std::memcpy(bytes.data() + first * sizeof(double), values.data() + first,
                            (last - first) * sizeof(double));
            },
            65536);
        position_ += bytes.size();
        chunks_.push_back(std::move(bytes));
        return done;
    }

    [[nodiscard]] Chunks finish() && {
        end();
        return std::move(chunks_);
    }

  protected:
    /// What comes before so many bytes of rows.
    void begin_rows(Keyword keyword, std::size_t n, std::size_t bytes) {
        begin(keyword, sizeof(Integer) + bytes);
        put(static_cast<Integer>(n));
    }
    void end() {
        put(static_cast<std::int32_t>(Keyword::end));
        put_position(0);
    }
    [[nodiscard]] std::size_t position() const { return position_; }
    void skip(std::size_t bytes) { position_ += bytes; }
    [[nodiscard]] Chunks take_chunks() { return std::exchange(chunks_, {}); }

  private:
    /// Keyword and the next block's position, `body` bytes (count included) on.
    void begin(Keyword keyword, std::size_t body) {
        put(static_cast<std::int32_t>(keyword));
        put_position(position_ + (version_ >= 3 ? 8 : 4) + body);
    }
    void put_position(std::size_t position) {
        if (version_ >= 3)
            put(static_cast<std::int64_t>(position));
        else
            put(static_cast<std::int32_t>(position));
    }
    void put_header(std::array<std::int32_t, 2> words) {
        for (const std::int32_t word : words) put(word);
    }
    template <class T>
    void put(T value) {
        Buffer<std::byte> bytes(sizeof value);
        std::memcpy(bytes.data(), &value, sizeof value);
        position_ += bytes.size();
        chunks_.push_back(std::move(bytes));
    }

    int version_;
    std::size_t words_, written_ = 0;
    const Execution& execution_;
    std::size_t position_ = 0;
    Chunks chunks_;
};

}  // namespace camber::gmf
