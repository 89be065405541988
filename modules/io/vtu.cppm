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

/// What elements of degree 2 become; elements of degree 1 are VTK's linear cells either way.
enum class VtuCells : std::uint8_t {
    quadratic,  ///< VTK_QUADRATIC_EDGE, _TRIANGLE, _TETRA (21, 22, 24): every reader of VTK files knows them
    lagrange,   ///< VTK_LAGRANGE_CURVE, _TRIANGLE, _TETRAHEDRON (68, 69, 71): ParaView refines them more smoothly
};
[[nodiscard]] constexpr auto words(VtuCells) {
    return words_of(Word{VtuCells::quadratic, "quadratic"}, Word{VtuCells::lagrange, "lagrange"});
}

/// How a VTU file is written.
struct VtuOptions {
    VtuCells cells = VtuCells::quadratic;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("vtu_cells", &VtuOptions::cells,
                                 "VTK's quadratic cells, which everything reads, or its Lagrange cells of degree 2"));
    }
};

/// The mesh as a VTK UnstructuredGrid file (XML, appended raw data, zlib blocks, this machine's byte order as
/// declared). Points: the vertices, then the node of each edge, each once; z = 0 in 2D. Cells: elements, facets,
/// feature edges, with the cell arrays `reference`, `dimension` (3, 2, 1), by which they can be told apart, and
/// `entity` where one is known; nodes of both degrees in the order of `local_edges`, which is VTK's. `reference` of the
/// points is as in a GMF file. Vectors are written with three components, symmetric tensors with the six XX YY ZZ XY YZ
/// XZ that ParaView expects, full ones with nine; those of a 2D mesh with zeros for z. The same bytes for any number of
/// threads. Errors: usage (a field whose rows are not those of the mesh), internal (columns of the mesh that do not fit
/// each other), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtu(const Mesh<D>& mesh, const MeshFields& fields, VtuOptions options,
                                         const Execution& execution);

/// The mesh and the fields of a VTU file: one Piece, data as text, base64 or raw, uncompressed or by zlib, in either
/// byte order.
/// - Always in space, simplices of degree 1 (3, 5, 10) and 2 (21, 22, 24; Lagrange cells of these degrees). Vertices
///   among the cells are left out, with a notice.
/// - References are those of the point array `reference` and of the cell array of that name, else of the first of
///   `medit:ref`, `gmsh:physical`, `CellEntityIds` and `MaterialID`; entities those of the cell array `entity`; each of
///   scalars that are whole numbers of 32 bits.
/// - All other arrays of points and cells with 1, 3, 6 or 9 components are fields; whole numbers that fit 32 bits stay
///   such, all others become doubles.
/// `where` in errors is `name: line N` (from 1); cells and points are counted from 1. Errors: input (malformed,
/// truncated, not finite, indices out of range), unsupported (several pieces, another compressor, cells that are no
/// simplices or of higher degree), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_vtu(bytes, name, {}, execution);
}

/// Whether the bytes begin as a VTU file does: XML, and soon a VTKFile of type UnstructuredGrid.
[[nodiscard]] bool is_vtu(std::span<const std::byte> bytes);

/// What of the mesh a VTU file has no place for: corners, ridges, required entities, given geometry.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtu(const Mesh<D>& mesh);

/// The nodal field of a part of a mesh by which parts are joined: the number of each node in the whole. Written to VTU
/// files as whole numbers of 64 bits, and said to be VTK's global ids.
inline constexpr std::string_view global_nodes = "GlobalNodeId";
/// The same of cells, by which nothing is joined.
inline constexpr std::string_view global_cells = "GlobalElementId";

/// The mesh of a PVTU file, which names VTU files that each hold a piece of it; `DecodeOptions::beside` reads those.
/// Points of several pieces with the same number in `global_nodes` are one, and come in the order of these numbers;
/// where not all pieces have such numbers those at the very same place are. Cells come piece by piece, ghosts left out;
/// fields are those that all pieces have. Errors: input (as decode_vtu, of any piece; no pieces), unsupported (nobody
/// reads the pieces), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_pvtu(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);

/// Whether the bytes begin as a PVTU file does.
[[nodiscard]] bool is_pvtu(std::span<const std::byte> bytes);

/// The PVTU file of such pieces, named as it is to name them; `first` is the file of one of them, as encode_vtu makes
/// it: the others have its arrays. Errors: input (it is no VTU file).
[[nodiscard]] Outcome<std::string> encode_pvtu(std::span<const std::byte> first, std::span<const std::string> names);

}  // namespace camber

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

/// The scalars as references; none where one of them is no whole number of 32 bits.
[[nodiscard]] Outcome<std::optional<Buffer<Reference>>> as_references(const Numbers& numbers,
                                                                      const Execution& execution);

/// The values of a field: row `order[i]` of the file's (without an order, row i), its component k at `places[k]`. Whole
/// numbers that fit 32 bits stay such.
[[nodiscard]] Outcome<FieldValues> field_values(const Numbers& numbers, const Column<std::uint32_t>* order,
                                                const std::vector<int>& places, const Execution& execution);

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

/// The value of each letter of base64; 64 and above: none.
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

/// The bytes of an array from its first on. Of base64 each group of four letters stands by itself: VTK encodes the
/// header of compressed data apart from them, so that padding may stand anywhere.
class Bytes {
  public:
    Bytes(std::string_view text, Encoding encoding) : text_(text), encoding_(encoding) {}

    /// No more than this are left.
    [[nodiscard]] std::size_t most() const {
        return encoding_ == Encoding::raw ? text_.size() : text_.size() / 4 * 3 + held_;
    }

    /// The next n; none where there are not so many.
    [[nodiscard]] std::optional<Buffer<std::byte>> take(std::size_t n) {
        if (n > most()) return std::nullopt;
        Buffer<std::byte> out(n);
        if (encoding_ == Encoding::raw) {
            if (n > 0) std::memcpy(out.data(), text_.data(), n);
            text_.remove_prefix(n);
            return out;
        }
        for (std::size_t i = 0; i < n; ++i) {
            while (held_ == 0)
                if (!next_group()) return std::nullopt;
            out[i] = group_[size_ - held_--];
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
        size_ = held_ = 3 - padded;
        return true;
    }

    std::string_view text_;
    Encoding encoding_;
    std::array<std::byte, 3> group_{};
    std::size_t size_ = 0, held_ = 0;  ///< bytes of the group, and those of it that were not taken yet
};

/// The array that marks cells of other pieces.
inline constexpr std::string_view ghost_array = "vtkGhostType";

/// The cells that a mesh has, and where they stand in the file.
struct Cells {
    static constexpr std::size_t kinds = 6;
    /// By kind: elements, facets, edges, of each those of degree 2 first.
    std::array<Column<std::uint32_t>, kinds> of_kind;
    Column<std::uint32_t> order;         ///< all of them behind one another
    Buffer<std::uint64_t> starts;        ///< of each cell of the file, in `connectivity`; one more for the end
    Buffer<std::uint32_t> connectivity;  ///< points; those of an invalid VertexId are none
    std::size_t at = 0;                  ///< where in the file
    std::vector<CellCount> unheld = {};  ///< kinds that were left out

    /// The dimension of the simplices of a kind.
    [[nodiscard]] static constexpr int dimension(std::size_t kind) { return 3 - static_cast<int>(kind / 2); }
};

/// The mesh as the file lists it, in all its pieces behind one another.
struct Listed {
    listing::Mesh<3> mesh;
    std::vector<Notice> notices = {};
    std::vector<CellCount> unheld = {};  ///< kinds of cells that were left out
};
/// Errors: as decode_vtu.
[[nodiscard]] Outcome<Listed> listing_of(const File& file, const DecodeOptions& options, const Execution& execution);

/// The points of a file. Errors: input (arrays that contradict each other), unsupported (more than 32 bits number).
[[nodiscard]] Outcome<Buffer<Vec<3>>> read_points(const File& file, const Execution& execution);

/// The cells of a file, nodes as they are; vertices among them are left out, with a notice. Errors: input (arrays that
/// contradict each other), unsupported (cells that are no simplices, or of another degree than 1 and 2).
[[nodiscard]] Outcome<Cells> read_cells(const File& file, Unheld unheld, std::vector<Notice>& notices,
                                        const Execution& execution);

/// Puts the nodes of the cells into the mesh.
[[nodiscard]] Outcome<Done> place_cells(const File& file, const Cells& cells, listing::Mesh<3>& mesh,
                                        const Execution& execution);

}  // namespace camber::vtu
