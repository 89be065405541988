module;
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io:vtu_file;
import camber.core;
import :any_mesh;
import :decode_options;

namespace camber::vtu {

/// How the data that stand behind the XML are written.
enum class Encoding : std::uint8_t { raw, base64 };

/// How blocks of data are compressed, where the format is not ascii.
enum class Compressor : std::uint8_t { none, zlib, lz4, lzma };

/// The numbers of an array, of the type that they have in the file.
using Numbers = std::variant<Buffer<double>, Buffer<float>, Buffer<std::int8_t>, Buffer<std::uint8_t>,
                             Buffer<std::int16_t>, Buffer<std::uint16_t>, Buffer<std::int32_t>, Buffer<std::uint32_t>,
                             Buffer<std::int64_t>, Buffer<std::uint64_t>>;

/// A DataArray element.
struct DataArray {
    std::string name;
    std::string type;                             ///< VTK's word: "Float64"
    std::size_t components = 1;                   ///< as the file says
    std::string format;                           ///< ascii, binary or appended
    std::size_t offset = 0;                       ///< appended: in the appended data
    std::string_view text = {};                   ///< the others: the data
    std::size_t at = 0;                           ///< where the element stands in the file; a byte
    std::vector<DataArray> of_other_pieces = {};  ///< the same array, piece by piece
    std::shared_ptr<const Numbers> numbers = {};  ///< of files that are read at once (legacy VTK)
};

/// What a Piece says of itself.
struct PieceSize {
    std::uint64_t points = 0, cells = 0;
};

/// What the XML of a VTU file says. Nothing of its data has been looked at.
struct File {
    std::span<const std::byte> bytes;
    std::string name;
    bool swapped = false;  ///< its numbers are in the other byte order than this machine's
    std::size_t word = 4;  ///< bytes of each number in the headers of arrays
    Compressor compressor = Compressor::none;
    std::string_view appended = {};
    Encoding encoding = Encoding::raw;  ///< of `appended`
    std::uint64_t points = 0,
                  cells = 0;  ///< of all pieces; not to be trusted before they were compared with the arrays
    std::vector<PieceSize> pieces = {};
    std::vector<DataArray> point_data = {}, cell_data = {}, point_arrays = {}, cell_arrays = {};
    std::size_t arrays_of_the_whole = 0;        ///< in FieldData
    std::shared_ptr<const void> document = {};  ///< what `text` of arrays points into
};

/// Finds what a file holds. Errors: input (damaged XML, cut off), unsupported (another kind of VTK file, another
/// compressor).
[[nodiscard]] Outcome<File> open_file(std::span<const std::byte> bytes, std::string_view name);

/// For messages: noise must not reach a terminal as it is.
[[nodiscard]] std::string printable(std::string_view name);

/// `name: line N`.
[[nodiscard]] std::string place(const File& file, std::size_t at);

/// Whether `read_array` knows numbers of this type.
[[nodiscard]] bool is_number(const DataArray& array);

/// As many numbers as there are, of `rows` of the array's components. Nothing is uncompressed where a header announces
/// more than these. Errors: input (malformed, cut off, more than the rows), unsupported (a type or a format that is
/// none of VTK's), memory, stopped.
[[nodiscard]] Outcome<Numbers> read_array(const File& file, const DataArray& array, std::uint64_t rows,
                                          const Execution& execution);

/// The bytes of one block, into where there is room for all that it is uncompressed to; false: they cannot be, or are
/// another number.
[[nodiscard]] bool uncompress_block(Compressor compressor, std::span<const std::byte> packed, std::span<std::byte> to);

/// The mesh of an opened file. Errors: as decode_vtu.
[[nodiscard]] Outcome<DecodedMesh> mesh_of(const File& file, const DecodeOptions& options, const Execution& execution);

/// The word of a file that begins as VTK's XML files do, of what kind it is; empty: it does not.
[[nodiscard]] std::string_view type_of_file(std::span<const std::byte> bytes);
/// As files have it, of this machine.
inline constexpr std::string_view own_byte_order =
    std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// Whether the arrays of points and cells are no more bytes together than the file has: they may point to the same
/// place, and each alone is then as large as what stands there. Compressed ones are no more numbers together than is
/// believed of a file (UnpackedBudget), as their headers say before anything is uncompressed. Errors: input (they are
/// more, a header is damaged).
[[nodiscard]] Outcome<Done> check_sizes(const File& file);

/// The value as a whole number of another type; none: it is not whole, or too large or small for it.
template <class To, class From>
[[nodiscard]] std::optional<To> whole_number(From value) {
    if constexpr (std::is_floating_point_v<From>) {
        constexpr double most = 9.2e18;  // any int64_t, and so any index or reference
        if (!(value > -most && value < most)) return std::nullopt;
        const auto whole = static_cast<std::int64_t>(value);
        if (static_cast<From>(whole) != value) return std::nullopt;
        return whole_number<To>(whole);
    } else {
        if (!std::in_range<To>(value)) return std::nullopt;
        return static_cast<To>(value);
    }
}

[[nodiscard]] inline std::size_t size_of(const Numbers& numbers) {
    return std::visit([](const auto& values) { return values.size(); }, numbers);
}

}  // namespace camber::vtu
