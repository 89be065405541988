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

/// Part of an ASCII block that ends at a line end; one thread decodes it.
struct Piece {
    std::size_t begin = 0;       ///< first byte in the file
    std::size_t first_word = 0;  ///< number of earlier words in the body
};

/// Position of a block; its rows are not checked yet.
struct Block {
    const KeywordInfo* info = nullptr;
    std::size_t start = 0;                  ///< byte of the keyword
    std::size_t body = 0, end = 0;          ///< byte range of the rows
    std::uint64_t count = 0;                ///< rows; unchecked before `check_size`
    std::vector<std::int32_t> fields = {};  ///< SolAtVertices: field types
    std::size_t words = 0;                  ///< ASCII: words in the body
    std::vector<Piece> pieces = {};         ///< ASCII: parts of the body
    std::size_t rows_per_entity = 1;        ///< rows of one numbered entity
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

/// Locates the blocks. Errors: not GMF, truncated, duplicate block, missing or wrong Dimension.
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
/// Checks that count × `words` fit between header and end (and, in ASCII, fill the block).
[[nodiscard]] Outcome<Done> check_size(const File& file, const Block& block, int integers, int reals);
/// Words in a row of an integer block, from its length; 0: the length is not a multiple.
[[nodiscard]] std::size_t words_per_row(const File& file, const Block& block);
[[nodiscard]] std::size_t row_begin(const File& file, const Block& block, std::size_t row, int integers, int reals);
[[nodiscard]] Error row_error_message(const File& file, const Block& block, std::size_t row, std::size_t at,
                                      const RowError& row_error);

/// Bytes of a row in binary files of this version.
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

/// Calls f with the layout type, so that loops need not test it.
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

/// Binary part of `read_rows`, for a checked block.
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

/// ASCII part of `read_rows`, for a checked block. Threads read the rows that begin in their part.
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

/// Calls store(row number, row) → Fault for each row, in parallel and in no particular order. Errors: a count that does
/// not fit the block, the first faulty row.
template <class RowType, class Store>
[[nodiscard]] Outcome<Done> read_rows(const File& file, const Block& block, const Execution& execution, Store&& store) {
    if (auto fits = check_size(file, block, RowType::integers, RowType::reals); !fits) return fits;
    if (file.encoding == GmfEncoding::ascii) return read_ascii_rows<RowType>(file, block, execution, store);
    return read_binary_rows<RowType>(file, block, execution, store);
}

/// Reads …P2Ordering; none if the file has no such block. Errors: input (not every node exactly once).
template <int K>
[[nodiscard]] Outcome<std::optional<listing::NodeOrder<K>>> read_order(const File& file);

/// Node order of quadratic tetrahedra under a plain keyword: old Gmsh versions end with the nodes of edges 23, 13,
/// later ones with 13, 23. Selects the order with the smaller sum of squared distances from chord midpoints.
template <int D>
[[nodiscard]] Outcome<listing::NodeOrder<3>> likely_order(const Buffer<Vec<D>>& points,
                                                          const Buffer<std::array<VertexId, 10>>& tetrahedra,
                                                          const Execution& execution);

/// Checks that each vertex exists and occurs once in a simplex. The file must outlive the result, whose messages quote
/// it.
template <int D>
[[nodiscard]] Outcome<listing::Mesh<D>> read_raw(const File& file, std::vector<Notice>& notices,
                                                 const Execution& execution);

/// Reads the lists other than points and simplices.
template <int D, int Degree>
[[nodiscard]] Outcome<LinearMesh<D>> read_lists(const File& file);

/// Reads normals, tangents and associations with CAD entities. All normals (or tangents) are dropped with a notice if
/// one is faulty (an index without its vertex or direction, length zero).
template <int D>
[[nodiscard]] Outcome<InputGeometry<D>> read_geometry(const File& file, std::size_t vertices,
                                                      std::vector<Notice>& notices, const Execution& execution);

}  // namespace camber::gmf
