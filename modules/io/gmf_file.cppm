module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io:gmf_file;
import camber.core;
import camber.bezier;
import :gmf;
import :listing;
import :meshes;
import :text;

namespace camber::gmf {

enum class ByteOrder : std::uint8_t { native, swapped };

/// A part of an ASCII block, read by one thread. Parts end at line ends.
struct Piece {
    std::size_t begin = 0;       ///< byte in the file at which the part begins
    std::size_t first_word = 0;  ///< number of words of the block's rows before the part
};

/// Position of a block. The rows are not checked when the block is located.
struct Block {
    const KeywordInfo* info = nullptr;
    std::size_t start = 0;                  ///< position of the keyword (bytes)
    std::size_t body = 0, end = 0;          ///< begin and end of the rows (bytes)
    std::uint64_t count = 0;                ///< number of rows, unchecked before `check_size`
    std::vector<std::int32_t> fields = {};  ///< field types, for SolAtVertices
    std::size_t words = 0;
    std::vector<Piece> pieces = {};   ///< parts of the rows, for ASCII
    std::size_t rows_per_entity = 1;  ///< number of rows that are one entity in messages
};

struct Skipped {
    std::string name;
    std::size_t blocks = 0;
};

struct File {
    std::span<const std::byte> bytes;
    std::string name;
    GmfEncoding encoding = GmfEncoding::binary;
    int version = 0;
    ByteOrder order = ByteOrder::native;
    std::optional<std::int64_t> dimension = {};
    std::int64_t bezier_basis = 0;
    std::vector<Block> blocks = {};
    std::vector<Skipped> skipped = {};
    std::vector<Notice> notices = {};

    [[nodiscard]] const Block* find(Keyword keyword) const;
};

/// Locates the blocks of a GMF file.
[[nodiscard]] Outcome<File> open_file(std::span<const std::byte> bytes, std::string_view name,
                                      const Execution& execution);
[[nodiscard]] Outcome<File> index_binary(File file);
[[nodiscard]] Outcome<File> index_ascii(File file, const Execution& execution);

void set_value(File& file, Keyword keyword, std::int64_t value);
void skip_block(File& file, std::string_view word);
[[nodiscard]] std::vector<Notice> notices_of(const File& file);

[[nodiscard]] std::string place(const File& file, std::size_t at);
[[nodiscard]] inline auto fail_at(const File& file, std::size_t at, std::string what, std::string remedy = {}) {
    return fail(ErrorKind::input, std::move(what), place(file, at), {}, std::move(remedy));
}
/// Checks that a block has space for `count` rows of this many integers and reals. In ASCII the rows must fill the
/// block exactly.
[[nodiscard]] Outcome<Done> check_size(const File& file, const Block& block, int integers, int reals);
/// Number of words in a row of integers: words in the block divided by rows; 0 if the division has a remainder.
[[nodiscard]] std::size_t words_per_row(const File& file, const Block& block);
[[nodiscard]] std::size_t row_begin(const File& file, const Block& block, std::size_t row, int integers, int reals);
[[nodiscard]] Error row_error_message(const File& file, const Block& block, std::size_t row, std::size_t at,
                                      const RowError& row_error);

[[nodiscard]] inline std::size_t row_bytes(int version, int integers, int reals) {
    const std::size_t integer_size = version == 4 ? 8 : 4, real_size = version == 1 ? 4 : 8;
    return static_cast<std::size_t>(integers) * integer_size + static_cast<std::size_t>(reals) * real_size;
}

template <class RealType, class IntegerType, ByteOrder Order>
struct Layout {
    using Real = RealType;
    using Integer = IntegerType;
    static constexpr ByteOrder order = Order;
};

template <class T, ByteOrder Order>
[[nodiscard]] inline T load(const std::byte* from) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    Bits bits;
    std::memcpy(&bits, from, sizeof bits);
    if constexpr (Order == ByteOrder::swapped) {
        if constexpr (sizeof(T) == 4)
            bits = __builtin_bswap32(bits);
        else
            bits = __builtin_bswap64(bits);
    }
    T value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

template <class RowType, class LayoutType>
inline constexpr std::size_t stride =
    RowType::integers * sizeof(typename LayoutType::Integer) + RowType::reals * sizeof(typename LayoutType::Real);

template <class RowType, class LayoutType>
[[nodiscard]] inline RowType load_row(const std::byte* from) {
    using Integer = typename LayoutType::Integer;
    using Real = typename LayoutType::Real;
    constexpr bool reals_first = RowType::order == RowOrder::reals_first;
    const std::byte* integers = reals_first ? from + RowType::reals * sizeof(Real) : from;
    const std::byte* reals = reals_first ? from : from + RowType::integers * sizeof(Integer);
    RowType row;
    for (int i = 0; i < RowType::integers; ++i)
        row.integer[i] = load<Integer, LayoutType::order>(integers + i * sizeof(Integer));
    for (int i = 0; i < RowType::reals; ++i)
        row.real[i] = static_cast<double>(load<Real, LayoutType::order>(reals + i * sizeof(Real)));
    return row;
}

/// Calls f with the file's number types and byte order as a type, so that loops need not test them.
template <class F>
auto with_layout(const File& file, F&& f) {
    const auto with_numbers = [&]<ByteOrder Order>() {
        if (file.version == 1) return f(Layout<float, std::int32_t, Order>{});
        if (file.version == 4) return f(Layout<double, std::int64_t, Order>{});
        return f(Layout<double, std::int32_t, Order>{});
    };
    if (file.order == ByteOrder::swapped) return with_numbers.template operator()<ByteOrder::swapped>();
    return with_numbers.template operator()<ByteOrder::native>();
}

template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_binary_rows(const File& file, const Block& block, const Execution& execution,
                                             Store& store) {
    return with_layout(file, [&](auto layout) -> Outcome<Done> {
        using LayoutType = decltype(layout);
        constexpr std::size_t step = stride<RowType, LayoutType>;
        const std::byte* const rows = file.bytes.data() + block.body;
        FirstErrorRow first;
        auto done = each_chunk(
            execution, block.count,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    const RowError row_error = store(i, load_row<RowType, LayoutType>(rows + i * step));
                    if (row_error.kind != RowErrorKind::none) return first.note(i);
                }
            },
            8192);
        if (!done) return done;
        if (!first.any()) return Done{};
        const std::size_t at = block.body + first.row() * step;
        const RowError row_error = store(first.row(), load_row<RowType, LayoutType>(file.bytes.data() + at));
        return fail(row_error_message(file, block, first.row(), at, row_error));
    });
}

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

template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_ascii_rows(const File& file, const Block& block, const Execution& execution,
                                            Store& store) {
    constexpr std::size_t width = RowType::words;
    const auto read_one = [&](std::size_t i, Words& words) {
        RowType row;
        return read_row(words, row) ? store(i, row) : RowError{.kind = RowErrorKind::syntax};
    };
    FirstErrorRow first;
    auto done = each_chunk(
        execution, block.pieces.size(),
        [&](std::size_t begin, std::size_t end) {
            const std::size_t first_word = block.pieces[begin].first_word;
            const std::size_t last_word = end < block.pieces.size() ? block.pieces[end].first_word : block.words;
            std::size_t row = (first_word + width - 1) / width;
            Words words = words_between(file, block.pieces[begin].begin, block.end);
            words.skip(row * width - first_word);
            for (; row < block.count && row * width < last_word; ++row)
                if (read_one(row, words).kind != RowErrorKind::none) return first.note(row);
        },
        1);
    if (!done) return done;
    if (!first.any()) return Done{};
    const std::size_t at = row_begin(file, block, first.row(), RowType::integers, RowType::reals);
    Words words = words_between(file, at, block.end);
    return fail(row_error_message(file, block, first.row(), at, read_one(first.row(), words)));
}

/// Calls store(row number, row) → RowError for each row, in parallel and in no particular order. Errors: a count that
/// does not fit the block; the error of the first faulty row.
template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_rows(const File& file, const Block& block, const Execution& execution, Store&& store) {
    if (auto fits = check_size(file, block, RowType::integers, RowType::reals); !fits) return fits;
    if (file.encoding == GmfEncoding::ascii) return read_ascii_rows<RowType>(file, block, execution, store);
    return read_binary_rows<RowType>(file, block, execution, store);
}

/// Reads the node order of K-simplices (block …P2Ordering); none if the file has no such block.
template <int K>
[[nodiscard]] Outcome<std::optional<listing::NodeOrder<K>>> read_order(const File& file);

/// Node order of quadratic tetrahedra under a keyword of degree 1. Old Gmsh versions end with the nodes of edges 23,
/// 13, later ones with 13, 23. Selects the order with the smaller sum of squared distances between mid nodes and chord
/// midpoints.
template <int D>
[[nodiscard]] Outcome<listing::NodeOrder<3>> likely_order(const Buffer<Vec<D>>& points,
                                                          const Buffer<std::array<VertexId, 10>>& tetrahedra,
                                                          const Execution& execution);

/// Reads points and simplices. Checks that each vertex exists and occurs once in its simplex. The file must outlive the
/// result, whose messages quote the file.
template <int D>
[[nodiscard]] Outcome<listing::Mesh<D>> read_raw(const File& file, std::vector<Notice>& notices,
                                                 const Execution& execution);

/// Reads the lists other than points and simplices, for example corners and ridges.
template <int D, int Degree>
[[nodiscard]] Outcome<LinearMesh<D>> read_lists(const File& file);

/// Reads normals, tangents and associations with CAD entities. All normals are dropped with a notice if a normal has
/// length zero or an index is invalid. The same holds for tangents.
template <int D>
[[nodiscard]] Outcome<InputGeometry<D>> read_geometry(const File& file, std::size_t vertices,
                                                      std::vector<Notice>& notices, const Execution& execution);

}  // namespace camber::gmf
