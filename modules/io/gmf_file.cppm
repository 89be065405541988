module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io:gmf_file;
import camber.core;
import :any_mesh;
import :gmf;
import :gmf_keywords;
import :gmf_row;
import :notice;

namespace camber::gmf {

enum class ByteOrder : std::uint8_t { native, swapped };

/// A stretch of an ASCII block that ends with a line; decoded by one thread.
struct Piece {
    std::size_t begin = 0;       ///< in the file
    std::size_t first_word = 0;  ///< words of the block's body before it
};

/// Where one block with rows lies in the file. Nothing of its rows has been looked at.
struct Block {
    const KeywordInfo* info = nullptr;
    std::size_t start = 0;                  ///< of the keyword; a byte, as all below
    std::size_t body = 0, end = 0;          ///< the rows
    std::uint64_t count = 0;                ///< as the file says: not to be trusted before `check_size`
    std::vector<std::int32_t> fields = {};  ///< SolAtVertices: types of the fields
    std::size_t words = 0;                  ///< ASCII: in the body
    std::vector<Piece> pieces = {};         ///< ASCII: of the body
    std::size_t rows_per_entity = 1;        ///< rows that one numbered entity takes
};

struct Skipped {
    std::string name;
    std::size_t blocks = 0;
};

/// A GMF file's blocks, in the file's order.
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
    std::vector<Notice> notices = {};  ///< of what is unusual, but does no harm

    [[nodiscard]] const Block* find(Keyword keyword) const;
};

/// Finds the blocks of a file by its headers. Errors: no GMF, cut off, a block twice, no or a wrong Dimension.
[[nodiscard]] Outcome<File> open_file(std::span<const std::byte> bytes, std::string_view name,
                                      const Execution& execution);
[[nodiscard]] Outcome<File> index_binary(File file);
[[nodiscard]] Outcome<File> index_ascii(File file, const Execution& execution);

/// Enters what a value keyword says.
void set_value(File& file, Keyword keyword, std::int64_t value);
/// Counts a block that is not read.
void skip_block(File& file, std::string_view word);
[[nodiscard]] std::vector<Notice> notices_of(const File& file);

/// `name: line N`, `name: byte N`.
[[nodiscard]] std::string place(const File& file, std::size_t at);
[[nodiscard]] inline auto fail_at(const File& file, std::size_t at, std::string what, std::string remedy = {}) {
    return fail(ErrorKind::input, std::move(what), place(file, at), {}, std::move(remedy));
}
/// The block's count × `words` fit between its header and its end (and, in ASCII, fill it).
[[nodiscard]] Outcome<Done> check_size(const File& file, const Block& block, int integers, int reals);
/// Words in each row of a block of integers as its length tells; 0 when it is no whole number.
[[nodiscard]] std::size_t words_per_row(const File& file, const Block& block);
/// Where row `row` of a checked block begins.
[[nodiscard]] std::size_t row_begin(const File& file, const Block& block, std::size_t row, int integers, int reals);
/// The error that a fault in row `row`, which begins at byte `at`, makes.
[[nodiscard]] Error fault_error(const File& file, const Block& block, std::size_t row, std::size_t at,
                                const Fault& fault);

/// Bytes of a row in a binary file of this version.
[[nodiscard]] inline std::size_t row_bytes(int version, int integers, int reals) {
    const std::size_t integer_size = version == 4 ? 8 : 4, real_size = version == 1 ? 4 : 8;
    return static_cast<std::size_t>(integers) * integer_size + static_cast<std::size_t>(reals) * real_size;
}

}  // namespace camber::gmf
