module;
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
export module camber.io:vtu;
import camber.core;
import :listing;
import :meshes;

export namespace camber {

/// Cell types in files of degree 2. Files of degree 1 always have VTK's linear cells.
enum class VtuCells : std::uint8_t {
    quadratic,  ///< VTK_QUADRATIC_EDGE, _TRIANGLE, _TETRA (21, 22, 24); all readers support them
    lagrange,   ///< VTK_LAGRANGE_CURVE, _TRIANGLE, _TETRAHEDRON (68, 69, 71); smoother in ParaView
};
[[nodiscard]] constexpr auto words(VtuCells) {
    return words_of(Word{VtuCells::quadratic, "quadratic"}, Word{VtuCells::lagrange, "lagrange"});
}

struct VtuOptions {
    VtuCells cells = VtuCells::quadratic;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("vtu_cells", &VtuOptions::cells,
                                 "VTK cells for degree 2. quadratic: VTK's quadratic cells, which all readers "
                                 "support; lagrange: VTK's Lagrange cells, which are smoother in ParaView"));
    }
};

/// Encodes a VTK UnstructuredGrid (XML, appended raw data, zlib blocks, native byte order).
/// - Points: the vertices, then the node of each edge; z = 0 in 2D. Their `reference` is as in a GMF file.
/// - Cells: elements, facets, feature edges. Their nodes are in the order of `local_edges`, which is VTK's.
/// - Cell arrays: `reference`, `dimension` (3, 2, 1), and `entity` if an entity is known.
/// - Vectors have three components, symmetric tensors six in ParaView's order XX YY ZZ XY YZ XZ, full tensors nine. In
///   2D the z components are zero.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtu(const Mesh<D>& mesh, const MeshFields& fields, VtuOptions options,
                                         const Execution& execution);

/// Decodes a VTU file: text, base64 or raw data, uncompressed or compressed by zlib, LZ4 or LZMA, in either byte order.
/// - The mesh is in space. It has the simplices of VTK's types 3, 5, 10 (degree 1) and 21, 22, 24 (degree 2), or
///   Lagrange cells of these degrees. Vertex cells are dropped with a notice. Several pieces are joined at coincident
///   points.
/// - References of points are the point array `reference`. References of cells are the cell array `reference`, else the
///   first array with a known name such as `medit:ref`, `gmsh:physical`, `CellEntityIds` or `MaterialID`.
/// - Entities are the cell array `entity`. All these arrays must be scalar 32-bit integers.
/// - Other arrays of points and cells with 1, 3, 6 or 9 components become fields. Integers that fit 32 bits stay
///   integers, other values become double.
///
/// Further errors: unsupported (another compressor).
[[nodiscard]] Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_vtu(bytes, name, {}, execution);
}

[[nodiscard]] bool is_vtu(std::span<const std::byte> bytes);

/// Lists lost data: corners, ridges, required entities, CAD associations and directions.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtu(const Mesh<D>& mesh);

/// Node field with the global number of each node, by which `decode_pvtu` joins pieces. VTU files store 64-bit
/// integers, marked as VTK's global ids.
inline constexpr std::string_view global_nodes = "GlobalNodeId";
/// Cell field with the global number of each cell. It has no effect on joining.
inline constexpr std::string_view global_cells = "GlobalElementId";

/// Decodes a PVTU file, whose pieces are VTU files that `DecodeOptions::beside` reads.
/// - Points of several pieces with the same number in `global_nodes` are merged, and points are sorted by number. If a
///   piece has no such numbers, coincident points are merged.
/// - Cells are in the order of pieces, without ghost cells. Fields are those that all pieces have.
///
/// Errors: those of `decode_vtu`, input (no pieces), unsupported (`beside` is null).
[[nodiscard]] Outcome<DecodedMesh> decode_pvtu(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);

[[nodiscard]] bool is_pvtu(std::span<const std::byte> bytes);

/// Encodes a PVTU file. `names`: files of the pieces; `first`: content of one of them, written by `encode_vtu`. All
/// pieces must have the same arrays. Errors: input (not a VTU file).
[[nodiscard]] Outcome<std::string> encode_pvtu(std::span<const std::byte> first, std::span<const std::string> names);

}  // namespace camber

namespace camber::vtu {

enum class Encoding : std::uint8_t { raw, base64 };

/// Compressor of arrays that are not stored as text.
enum class Compressor : std::uint8_t { none, zlib, lz4, lzma };

using Numbers = std::variant<Buffer<double>, Buffer<float>, Buffer<std::int8_t>, Buffer<std::uint8_t>,
                             Buffer<std::int16_t>, Buffer<std::uint16_t>, Buffer<std::int32_t>, Buffer<std::uint32_t>,
                             Buffer<std::int64_t>, Buffer<std::uint64_t>>;

struct DataArray {
    std::string name;
    std::string type;
    std::size_t components = 1;
    std::string format;
    std::size_t offset = 0;      ///< position in the appended data
    std::string_view text = {};  ///< the data, if it is not appended
    std::size_t at = 0;          ///< position in the file of the XML element (bytes)
    std::vector<DataArray> other_pieces = {};
    std::shared_ptr<const Numbers> numbers = {};  ///< the numbers, if already read (legacy VTK files)
};

struct PieceSize {
    std::uint64_t points = 0, cells = 0;
};

/// Parsed XML; the data is not checked yet.
struct File {
    std::span<const std::byte> bytes;
    std::string name;
    bool swapped = false;  ///< the byte order is not the native one
    std::size_t word = 4;  ///< number of bytes of an integer in array headers
    Compressor compressor = Compressor::none;
    std::string_view appended = {};
    Encoding encoding = Encoding::raw;  ///< encoding of `appended`
    std::uint64_t points = 0,
                  cells = 0;  ///< sums of all pieces; not yet compared with the arrays
    std::vector<PieceSize> pieces = {};
    std::vector<DataArray> point_data = {}, cell_data = {}, point_arrays = {}, cell_arrays = {};
    std::size_t field_data_arrays = 0;
    std::shared_ptr<const void> document = {};  ///< owner of the `text` of arrays
};

[[nodiscard]] Outcome<File> open_file(std::span<const std::byte> bytes, std::string_view name);

/// Returns the name without control characters, so that damaged files cannot send them to a terminal.
[[nodiscard]] std::string printable(std::string_view name);

[[nodiscard]] std::string place(const File& file, std::size_t at);

[[nodiscard]] bool is_number(const DataArray& array);

/// Reads an array of at most `rows` rows. If its header announces more, nothing is uncompressed.
[[nodiscard]] Outcome<Numbers> read_array(const File& file, const DataArray& array, std::uint64_t rows,
                                          const Execution& execution);

/// Converts numbers to references; none if a number is not a 32-bit integer.
[[nodiscard]] Outcome<std::optional<Buffer<Reference>>> as_references(const Numbers& numbers,
                                                                      const Execution& execution);

/// Converts numbers to rows of field values. Row i is row `order[i]` of the file, or row i if `order` is null.
/// Component k of a row moves to position `places[k]`. Integers that fit 32 bits stay integers.
[[nodiscard]] Outcome<FieldValues> field_values(const Numbers& numbers, const Column<std::uint32_t>* order,
                                                const std::vector<int>& places, const Execution& execution);

/// Uncompresses a block. Returns false if this fails, or if the result does not have the size of `to`.
[[nodiscard]] bool uncompress_block(Compressor compressor, std::span<const std::byte> packed, std::span<std::byte> to);

[[nodiscard]] Outcome<DecodedMesh> mesh_of(const File& file, const DecodeOptions& options, const Execution& execution);

/// The attribute `type` of a VTK XML file; empty for other files.
[[nodiscard]] std::string_view type_of_file(std::span<const std::byte> bytes);
inline constexpr std::string_view own_byte_order =
    std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// Checks the total size of point and cell arrays, because damaged headers may refer to the same data many times.
/// Stored bytes are limited by the file size, uncompressed ones by UnpackedBudget; nothing is uncompressed.
[[nodiscard]] Outcome<Done> check_sizes(const File& file);

/// Converts a number to an integer type; none if it has a fraction or is out of range.
template <class To, class From>
[[nodiscard]] std::optional<To> whole_number(From value) {
    if constexpr (std::is_floating_point_v<From>) {
        constexpr double most = 9.2e18;  // just below 2^63; all indices and references are smaller
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

/// Values from 64 on mark characters that are not among the 64 of base64.
inline constexpr std::uint8_t padding = 64, blank = 65, no_letter = 66;
inline constexpr auto base64 = [] {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint8_t, 256> values{};
    values.fill(no_letter);
    for (std::size_t i = 0; i < letters.size(); ++i)
        values[static_cast<unsigned char>(letters[i])] = static_cast<std::uint8_t>(i);
    for (const char c : {' ', '\t', '\r', '\n'}) values[static_cast<unsigned char>(c)] = blank;
    values[static_cast<unsigned char>('=')] = padding;
    return values;
}();

/// Reads the bytes of an array from begin to end. VTK encodes the header of compressed data separately, so base64
/// padding may occur between groups of four characters.
class Bytes {
  public:
    Bytes(std::string_view text, Encoding encoding) : text_(text), encoding_(encoding) {}

    [[nodiscard]] std::size_t most() const {
        return encoding_ == Encoding::raw ? text_.size() : text_.size() / 4 * 3 + pending_bytes_;
    }

    [[nodiscard]] std::optional<Buffer<std::byte>> take(std::size_t n) {
        if (n > most()) return std::nullopt;
        Buffer<std::byte> out(n);
        if (encoding_ == Encoding::raw) {
            if (n > 0) std::memcpy(out.data(), text_.data(), n);
            text_.remove_prefix(n);
            return out;
        }
        for (std::size_t i = 0; i < n; ++i) {
            while (pending_bytes_ == 0)
                if (!next_group()) return std::nullopt;
            out[i] = group_[size_ - pending_bytes_--];
        }
        return out;
    }

  private:
    bool next_group() {
        std::uint32_t bits = 0;
        std::size_t letters = 0, padded = 0;
        while (letters < 4) {
            if (text_.empty()) return false;
            const std::uint8_t value = base64[static_cast<unsigned char>(text_.front())];
            text_.remove_prefix(1);
            if (value == blank) continue;
            if (value == no_letter || (value != padding && padded > 0)) return false;
            padded += value == padding ? 1 : 0;
            bits = bits << 6U | (value == padding ? 0U : value);
            ++letters;
        }
        if (padded > 2) return false;
        for (std::size_t i = 0; i < 3; ++i) group_[i] = static_cast<std::byte>(bits >> (16 - 8 * i) & 0xffU);
        size_ = pending_bytes_ = 3 - padded;
        return true;
    }

    std::string_view text_;
    Encoding encoding_;
    std::array<std::byte, 3> group_{};
    std::size_t size_ = 0, pending_bytes_ = 0;  ///< number of bytes in `group_`, and of those that are not read yet
};

/// Cell array that marks the cells of a piece that belong to other pieces.
inline constexpr std::string_view ghost_array = "vtkGhostType";

struct Cells {
    static constexpr std::size_t kinds = 6;
    /// Numbers of the file's cells, for each kind of cells. The kinds are elements, facets, edges, each first with
    /// degree 2, then with degree 1.
    std::array<Column<std::uint32_t>, kinds> of_kind;
    Column<std::uint32_t> order;
    Buffer<std::uint64_t> starts;  ///< for each cell of the file its begin in `connectivity`, then the end of the last
    Buffer<std::uint32_t> connectivity;  ///< numbers of points; that of an invalid VertexId marks a missing point
    std::size_t at = 0;                  ///< position in the file, for messages
    std::vector<CellCount> unsupported_cells = {};

    [[nodiscard]] static constexpr int dimension(std::size_t kind) { return 3 - static_cast<int>(kind / 2); }
};

struct ListedPieces {
    listing::Mesh<3> mesh;
    std::vector<Notice> notices = {};
    std::vector<CellCount> unsupported_cells = {};
};
[[nodiscard]] Outcome<ListedPieces> listing_of(const File& file, const DecodeOptions& options,
                                               const Execution& execution);

[[nodiscard]] Outcome<Buffer<Vec<3>>> read_points(const File& file, const Execution& execution);

[[nodiscard]] Outcome<Cells> read_cells(const File& file, UnsupportedCells unsupported_cells,
                                        std::vector<Notice>& notices, const Execution& execution);

[[nodiscard]] Outcome<Done> place_cells(const File& file, const Cells& cells, listing::Mesh<3>& mesh,
                                        const Execution& execution);

}  // namespace camber::vtu
