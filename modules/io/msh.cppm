module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
export module camber.io:msh;
import camber.core;
import :gmf_file;
import :meshes;
import :text;

export namespace camber {

enum class MshVersion : std::uint8_t {
    v2,  ///< 2.2: each element has its group and entity; most solvers read it
    v4,  ///< 4.1: each entity has its groups; elements are in blocks, one block for an entity and type
};
enum class MshEncoding : std::uint8_t { ascii, binary };

struct MshOptions {
    MshVersion version = MshVersion::v4;
    MshEncoding encoding = MshEncoding::binary;
};

/// Decodes a Gmsh mesh (.msh, versions 1, 2.0 to 2.2, 4.0 and 4.1, text or binary in either byte order). The mesh is in
/// space, with z = 0 in 2D. Vertices and simplices are in tag order.
/// - The reference of a simplex is its first physical tag, without its sign; its entity is Gmsh's. Without physical
///   groups the references are the entities.
/// - The reference of simplices in several groups has the names of all these groups. Sets of groups with the same first
///   tag get different references.
/// - A node's entity and parameters become an association, except for nodes in volumes and mid nodes.
/// - A point element gives its node a reference.
/// - Partitions are joined: an entity of a partition is replaced by the entity that was divided. Elements between
///   partitions are dropped.
/// - NodeData and ElementData become fields if they have a value for each vertex or each simplex.
///
/// Notices report omitted data. Further errors: input (missing nodes).
[[nodiscard]] Outcome<DecodedMesh> decode_msh(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_msh(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_msh(bytes, name, {}, execution);
}

/// Recognises MSH files of a version and encoding. An unsupported version counts as the nearest supported one.
[[nodiscard]] bool is_msh(std::span<const std::byte> bytes, MshOptions kind);

/// Encodes the mesh as an MSH file.
/// - Node tags are 1, 2 … for vertices, then for edge nodes.
/// - Elements are numbered in this order: point elements, edges, facets, elements. A vertex is a point element if it is
///   on a geometric point and has a reference. Reading the file restores the mesh's order.
/// - The physical tag of a simplex is its reference, or the first free positive number if the reference is not
///   positive.
/// - The entity of a simplex is the one that the mesh states, else it has the number of the reference. All simplices of
///   an entity in the file have the same reference.
/// - Nodes (4.1 only) are classified on the point, curve or surface of lowest dimension with which they are associated,
///   else on the entity of the simplices of lowest dimension that contain them.
///
/// Further errors: unsupported (2.2: more nodes or elements than 31 bits can number).
template <int D>
[[nodiscard]] Outcome<Chunks> encode_msh(const Mesh<D>& mesh, const MeshFields& fields, MshOptions options,
                                         const Execution& execution);

template <int D>
[[nodiscard]] std::vector<Notice> not_in_msh(const Mesh<D>& mesh, MshVersion version);

}  // namespace camber

namespace camber::msh {

struct ElementType {
    std::int32_t number;
    int dimension;
    std::uint32_t nodes;
    std::string_view plural;
    int degree;
};

inline constexpr std::string_view lines = "edges", triangles = "triangles", quadrangles = "quadrangles",
                                  tetrahedra = "tetrahedra", hexahedra = "hexahedra", prisms = "prisms",
                                  pyramids = "pyramids";

inline constexpr auto element_types = std::to_array<ElementType>({
    {15, 0, 1, "points", 0},    {1, 1, 2, lines, 1},         {8, 1, 3, lines, 2},         {26, 1, 4, lines, 3},
    {27, 1, 5, lines, 4},       {28, 1, 6, lines, 5},        {2, 2, 3, triangles, 1},     {9, 2, 6, triangles, 2},
    {20, 2, 9, triangles, 3},   {21, 2, 10, triangles, 3},   {22, 2, 12, triangles, 4},   {23, 2, 15, triangles, 4},
    {24, 2, 15, triangles, 5},  {25, 2, 21, triangles, 5},   {3, 2, 4, quadrangles, 1},   {16, 2, 8, quadrangles, 2},
    {10, 2, 9, quadrangles, 2}, {36, 2, 16, quadrangles, 3}, {37, 2, 25, quadrangles, 4}, {38, 2, 36, quadrangles, 5},
    {4, 3, 4, tetrahedra, 1},   {11, 3, 10, tetrahedra, 2},  {29, 3, 20, tetrahedra, 3},  {30, 3, 35, tetrahedra, 4},
    {31, 3, 56, tetrahedra, 5}, {5, 3, 8, hexahedra, 1},     {17, 3, 20, hexahedra, 2},   {12, 3, 27, hexahedra, 2},
    {92, 3, 64, hexahedra, 3},  {93, 3, 125, hexahedra, 4},  {6, 3, 6, prisms, 1},        {18, 3, 15, prisms, 2},
    {13, 3, 18, prisms, 2},     {90, 3, 40, prisms, 3},      {91, 3, 75, prisms, 4},      {7, 3, 5, pyramids, 1},
    {19, 3, 13, pyramids, 2},   {14, 3, 14, pyramids, 2},    {118, 3, 30, pyramids, 3},   {119, 3, 55, pyramids, 4},
});

[[nodiscard]] constexpr const ElementType* find_type(std::int64_t number) {
    const auto* const found = std::find_if(element_types.begin(), element_types.end(),
                                           [&](const ElementType& type) { return type.number == number; });
    return found == element_types.end() ? nullptr : found;
}

[[nodiscard]] constexpr bool is_supported(const ElementType& type) {
    return type.degree <= 2 &&
           (type.plural == lines || type.plural == triangles || type.plural == tetrahedra || type.dimension == 0);
}

[[nodiscard]] inline std::string name_of(const ElementType& type) {
    return std::string(type.plural) + (type.degree > 1 ? " of degree " + std::to_string(type.degree) : "");
}

template <int K, int Nodes>
inline constexpr std::int32_t simplex_type = [] {
    constexpr std::array<std::int32_t, 3> straight{1, 2, 4}, curved{8, 9, 11};
    return Nodes == K + 1 ? straight[K - 1] : curved[K - 1];
}();

/// Position of node i in Gmsh's row. Gmsh has the last two nodes of quadratic tetrahedra in the opposite order.
template <int Nodes>
[[nodiscard]] constexpr int place_in_row(int i) {
    return Nodes == 10 && i >= 8 ? 17 - i : i;
}

/// A row has integers, then 8-byte reals. `integer_bytes`: bytes of an integer in binary files.
struct RowShape {
    std::size_t integers = 0, integer_bytes = 4, reals = 0;
    [[nodiscard]] std::size_t words() const { return integers + reals; }
    [[nodiscard]] std::size_t bytes() const { return integers * integer_bytes + reals * sizeof(double); }
};

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

struct TextRow {
    std::vector<std::int64_t> integers;
    std::vector<double> reals;
    [[nodiscard]] std::int64_t integer(std::size_t i) const { return integers[i]; }
    [[nodiscard]] double real(std::size_t i) const { return reals[i]; }
};

/// Reads a file from begin to end. In binary files, integers have 4 bytes, counts and tags 8, reals are double.
/// Functions return false if no valid number follows.
class Source {
  public:
    Source(std::span<const std::byte> bytes, std::string_view name) : bytes_(bytes), name_(name) {}

    bool binary = false, swapped = false;

    [[nodiscard]] std::size_t at() const { return at_; }
    void seek(std::size_t at) { at_ = at; }
    [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
    [[nodiscard]] std::string_view rest() const { return {reinterpret_cast<const char*>(bytes_.data()) + at_, left()}; }
    [[nodiscard]] const std::string& name() const { return name_; }

    [[nodiscard]] std::string place() const {
        if (binary) return name_ + ": byte " + std::to_string(at_);
        const auto before =
            std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_), std::byte{'\n'});
        return name_ + ": line " + std::to_string(before + 1);
    }
    [[nodiscard]] auto error(std::string what, std::string remedy = {}) const {
        return fail(ErrorKind::input, std::move(what), place(), {}, std::move(remedy));
    }

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
    /// Returns the rest of the line; moves to the next line.
    std::string_view line() {
        std::string_view text = rest();
        const std::size_t end = text.find('\n');
        at_ += end == std::string_view::npos ? text.size() : end + 1;
        text = text.substr(0, end);
        return text.ends_with('\r') ? text.substr(0, text.size() - 1) : text;
    }

    /// Reads a number that is text even in binary files.
    template <class Number>
    bool text_number(Number& value) {
        const std::string_view text = rest();
        Words words{text.data(), text.data() + text.size()};
        const bool read = read_number(words, value);
        at_ = bytes_.size() - static_cast<std::size_t>(words.end - words.at);
        return read;
    }
    /// Reads an integer from −(2^31 − 1) to 2^31 − 1, so that its negative also fits 32 bits.
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

    [[nodiscard]] bool can_contain_rows(std::uint64_t n, RowShape shape) const {
        return n <= (left() + 1) / std::max<std::size_t>(1, binary ? shape.bytes() : 2 * shape.words()) &&
               n <= max_entities;
    }

    /// Calls store(i, row) for n rows, in parallel if the file is binary. Precondition: `can_contain_rows` accepts n.
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
        if (read < n) return error("a number of a table is missing here", "the file is cut off or damaged");
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

enum class Generation : std::uint8_t { v1, v2, v40, v41 };

struct FormatLine {
    std::string version;  ///< for example "4.1"; "1" for files that begin with $NOD
    bool binary = false;
    long data_size = 0;
    std::size_t end = 0;  ///< position after the line
};

/// Finds the line with the version, before which only comments may occur; none if the file is not MSH.
[[nodiscard]] std::optional<FormatLine> find_format(std::span<const std::byte> bytes);

[[nodiscard]] std::optional<Generation> generation(const FormatLine& format);

/// Moves into the next section and returns its name without `$`; empty at the end of the file.
[[nodiscard]] Outcome<std::string> next_section(Source& source);
[[nodiscard]] Outcome<Done> end_section(Source& source, std::string_view name);
[[nodiscard]] Outcome<Done> skip_section(Source& source, std::string_view name);

}  // namespace camber::msh
