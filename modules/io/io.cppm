module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
/// Encodes and decodes meshes and solutions; the table of formats; flat meshes in 2D and in space. The module accesses
/// no files: the shell reads and writes them.
///
/// Conventions of all formats:
/// - Functions that return an Outcome may also fail with memory, and with stopped if they take an Execution.
/// - Decoders: `name` is the file name for messages; `where` in errors is `name: line N` (from 1) or, for binary data,
///   `name: byte N` (from 0). Items are counted from 1. Errors: input (malformed, truncated, not finite, indices out of
///   range), unsupported (elements that are not simplices of degree 1 or 2, other kinds and versions of files).
/// - Encoders: the bytes do not depend on the number of threads. Errors: usage (a field whose rows do not match the
///   mesh), internal (inconsistent columns of the mesh).
/// - `is_…` recognises a file by its first bytes. `not_in_…` lists mesh data that the format loses or changes.
export module camber.io;
import camber.core;
import camber.bezier;
// Partitions that are imported without export contain parts of readers and writers.
export import :gmf;
import :gmf_file;
import :gmf_write;
import :listing;
export import :meshes;
export import :mfem;
export import :msh;
import :msh_file;
export import :other_formats;
import :text;
export import :vtu;
import :writers;

/// Tables of formats: the only source of decoders, encoders, messages and help. Functions have the table as a
/// parameter, so programs can add rows. A decoder's `name` is the file's path, because some decoders open the file.
export namespace camber {

/// Options for writing; a format ignores those that do not apply to it.
struct EncodeOptions {
    VtuCells cells = VtuOptions{}.cells;  ///< only for formats with `chooses_cells`
};

struct FormatName {
    std::string_view name;  ///< one word, unique in the table
    std::string_view what;
    /// File endings with the dot, unique in the table. A format without endings is recognised by content, and selected
    /// by name for writing.
    std::vector<std::string_view> endings;
    /// Ending of another row that files of this format may also have. A mesh from such a file is written back in this
    /// format.
    std::string_view shared_extension = {};
    /// Recognises the format by the first bytes of a file. At most one row of the table accepts a file.
    bool (*sniff)(std::span<const std::byte> bytes);
};

/// A format without decoder cannot be read, a format without encoder cannot be written.
struct MeshFormat : FormatName {
    Outcome<DecodedMesh> (*decode)(std::span<const std::byte> bytes, std::string_view name,
                                   const DecodeOptions& options, const Execution& execution) = nullptr;
    /// Encodes a mesh without the fields that the format cannot hold.
    Outcome<Chunks> (*encode)(const AnyMesh& mesh, const MeshFields& fields, EncodeOptions options,
                              const Execution& execution) = nullptr;
    /// Lists mesh data other than fields that the format cannot hold.
    std::vector<Notice> (*losses)(const AnyMesh& mesh) = nullptr;
    bool has_fields = false;
    /// True if the format can hold the field. Null: the format can hold all fields if it `has_fields`, else none.
    bool (*can_store)(const MeshField& field) = nullptr;
    /// Lists fields that get other names in the file. Null: the format has no fields.
    std::vector<Notice> (*renames)(const MeshFields& fields) = nullptr;
    bool chooses_cells = false;
    bool for_viewers = false;   ///< true if files of this format also contain the fields that a run computes
    bool is_always_3d = false;  ///< see `DecodedMesh::is_always_3d`
};

struct SolutionFormat : FormatName {
    Outcome<DecodedSolution> (*decode)(std::span<const std::byte> bytes, std::string_view name,
                                       const Execution& execution) = nullptr;
    Outcome<Chunks> (*encode)(const Solution& solution, const Execution& execution) = nullptr;
};

[[nodiscard]] std::span<const MeshFormat> mesh_formats();
[[nodiscard]] std::span<const SolutionFormat> solution_formats();

template <class Format>
[[nodiscard]] const Format* find_format(std::span<const Format> formats, auto&& accepts) {
    for (const Format& format : formats)
        if (accepts(format)) return &format;
    return nullptr;
}
template <class Format>
[[nodiscard]] const Format* format_with_name(std::span<const Format> formats, std::string_view name) {
    return find_format(formats, [&](const Format& format) { return format.name == name; });
}
template <class Format>
[[nodiscard]] const Format* format_with_extension(std::span<const Format> formats, std::string_view path) {
    return find_format(formats, [&](const Format& format) {
        for (const std::string_view ending : format.endings)
            if (path.ends_with(ending)) return true;
        return false;
    });
}
template <class Format>
[[nodiscard]] const Format* format_with_content(std::span<const Format> formats, std::span<const std::byte> bytes) {
    return find_format(formats, [&](const Format& format) { return format.sniff(bytes); });
}

[[nodiscard]] std::string conversion_command(std::string_view path);

[[nodiscard]] std::string listed(std::span<const std::string_view> words, std::string_view before_last = " or ",
                                 std::string_view between = ", ");

template <class Format>
[[nodiscard]] std::vector<std::string_view> readable_extensions(std::span<const Format> formats) {
    std::vector<std::string_view> endings;
    for (const Format& format : formats)
        if (format.decode) endings.insert(endings.end(), format.endings.begin(), format.endings.end());
    return endings;
}
template <class Format>
[[nodiscard]] std::vector<std::string_view> writable_extensions(std::span<const Format> formats, auto&& accepts) {
    std::vector<std::string_view> endings;
    for (const Format& format : formats)
        if (format.encode && accepts(format))
            endings.insert(endings.end(), format.endings.begin(), format.endings.end());
    return endings;
}
template <class Format>
[[nodiscard]] std::vector<std::string_view> writable_extensions(std::span<const Format> formats) {
    return writable_extensions(formats, [](const Format&) { return true; });
}
template <class Format>
[[nodiscard]] std::vector<std::string_view> writable_formats(std::span<const Format> formats) {
    std::vector<std::string_view> names;
    for (const Format& format : formats)
        if (format.encode) names.push_back(format.name);
    return names;
}

/// Returns the format of the content, else that of the path's ending. Errors: input (no such format), unsupported (it
/// has no decoder).
template <class Format>
[[nodiscard]] Outcome<const Format*> format_to_read(std::span<const Format> formats, std::span<const std::byte> bytes,
                                                    std::string_view path) {
    const Format* format = format_with_content(formats, bytes);
    if (!format) format = format_with_extension(formats, path);
    if (format && format->decode) return format;
    const std::string command = conversion_command(path);
    const std::string remedy =
        command.empty() ? "give a " + listed(readable_extensions(formats)) + " file" : "convert it: " + command;
    if (format)
        return fail(ErrorKind::unsupported, std::string(format->what) + " can be written, but not read",
                    std::string(path), {}, remedy);
    return fail(ErrorKind::input,
                bytes.empty() ? "the file is empty"
                              : "neither its first bytes nor its extension belongs to a known "
                                "format",
                std::string(path), {}, remedy);
}

/// Returns the format `name`; if `name` is empty, the format of the path's ending. Errors: usage.
template <class Format>
[[nodiscard]] Outcome<const Format*> format_to_write(std::span<const Format> formats, std::string_view path,
                                                     std::string_view name = {}) {
    const Format* const format = name.empty() ? format_with_extension(formats, path) : format_with_name(formats, name);
    if (format && format->encode) return format;
    if (name.empty())
        return fail(ErrorKind::usage, "no format known for this ending", std::string(path), {},
                    "use " + listed(writable_extensions(formats)));
    return fail(ErrorKind::usage, "is not an output format", std::string(name), {},
                "use " + listed(writable_formats(formats)));
}

/// Selects the format for writing a mesh that was read in the format `source` (may be empty):
/// 1. the format `name`, if not empty;
/// 2. `source`, if it uses the path's ending, so that encoding and version stay the same;
/// 3. the format of the path's ending.
///
/// Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_to_rewrite(std::span<const MeshFormat> formats, std::string_view path,
                                                           std::string_view name, std::string_view source);

/// Decodes a mesh of any format. `path` serves to find the ending, and for messages. Errors: those of `format_to_read`
/// and of the decoder.
[[nodiscard]] Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path,
                                               const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path,
                                                      const Execution& execution) {
    return decode_mesh(bytes, path, {}, execution);
}
[[nodiscard]] Outcome<DecodedSolution> decode_solution(std::span<const std::byte> bytes, std::string_view path,
                                                       const Execution& execution);

/// Decodes an SU2 mesh (degree 1, NDIME 2 or 3; NELEM, NPOIN and NMARK in any order).
/// - Several zones are joined, unless the options select one. Elements then have their zone's number as reference,
///   otherwise 0.
/// - Each MARKER_TAG becomes a group of facets with reference 1, 2 … in file order. Vertices have reference 0.
/// - Indices at the ends of rows are ignored, as in SU2. SEND_RECEIVE markers and unknown blocks are skipped with a
///   notice.
///
/// Further errors: unsupported (zones of different dimensions).
[[nodiscard]] Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_su2(bytes, name, {}, execution);
}

/// True if the first keyword after any comments is NDIME=, NZONE=, NELEM=, NPOIN= or NMARK=.
[[nodiscard]] bool is_su2(std::span<const std::byte> bytes);

template <int K, int Degree>
inline constexpr int nodes_of_degree = Degree == 1 ? K + 1 : quadratic_nodes<K>;

/// Consecutive points of a mesh. `first`: number of the first one, from 0.
template <int D>
struct PointRun {
    std::uint64_t first = 0;
    Buffer<Vec<D>> points = {};
    Buffer<Reference> references = {};
};
/// Consecutive K-simplices of a mesh. Nodes are numbers of points, from 0: first all vertices, then all edge nodes. A
/// simplex has its edge nodes in the order of `local_edges`.
template <int K, int Degree>
struct SimplexRun {
    std::uint64_t first = 0;
    Buffer<std::array<std::uint64_t, nodes_of_degree<K, Degree>>> nodes = {};
    Buffer<Reference> references = {};
};

/// The rows of a file that one of several writers encodes.
template <int D, int Degree>
struct FilePart {
    PointRun<D> vertices = {};
    PointRun<D> mid_nodes = {};  ///< edge nodes; `first` counts only edge nodes
    SimplexRun<D, Degree> elements = {};
    SimplexRun<D - 1, Degree> facets = {};
    SimplexRun<1, Degree> edges = {};
};

struct PartTotals {
    std::uint64_t vertices = 0, mid_nodes = 0, elements = 0, facets = 0, edges = 0;
};

struct GmfFrame {
    int version = 0;
    std::uint64_t bytes = 0;
    std::uint64_t points = 0, elements = 0, facets = 0, edges = 0;  ///< bytes at which the rows of these blocks begin
    PartTotals totals = {};
};

struct FilePiece {
    std::uint64_t offset = 0;
    Buffer<std::byte> bytes;
};

/// Several writers write a file in parts. `gmf_frame` computes the positions of blocks. `encode_gmf_frame` encodes
/// everything except the rows of points and simplices; `encode_gmf_part` encodes rows. Together the pieces are the
/// bytes of `encode_gmf_mesh`. Errors: usage (the version).
template <int D, int Degree>
[[nodiscard]] Outcome<GmfFrame> gmf_frame(const PartTotals& totals, const LinearMesh<D>& lists, int version = 0);
template <int D, int Degree>
[[nodiscard]] Outcome<std::vector<FilePiece>> encode_gmf_frame(const GmfFrame& frame, const LinearMesh<D>& lists,
                                                               const Execution& execution);
template <int D, int Degree>
[[nodiscard]] Outcome<std::vector<FilePiece>> encode_gmf_part(const GmfFrame& frame, const FilePart<D, Degree>& part,
                                                              const Execution& execution);

struct GmfCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// Reads ranges of rows of a binary GMF mesh, in any order and concurrently; only the bytes of a range are accessed.
/// Rows are checked as by `decode_gmf_mesh`. A range begins at row `begin`, has as many rows as the output, and must
/// end within the block. Points include edge nodes for degree 2. Errors: input, for the first faulty row.
template <int D, int Degree = 1>
class GmfRuns {
  public:
    template <int K>
    using Nodes = std::array<VertexId, nodes_of_degree<K, Degree>>;

    explicit GmfRuns(std::shared_ptr<const gmf::File> file) : file_(std::move(file)) {}

    [[nodiscard]] GmfCounts counts() const;
    [[nodiscard]] Outcome<Done> points(std::size_t begin, std::span<Vec<D>> points,
                                       std::span<Reference> references) const;
    /// Reads simplices of dimension K: D, D − 1, or 1 for feature edges in 3D. Edge nodes are in the order of
    /// `local_edges`.
    template <int K>
    [[nodiscard]] Outcome<Done> simplices(std::size_t begin, std::span<Nodes<K>> nodes,
                                          std::span<Reference> references) const;
    /// Returns a mesh that has only corners, ridges, required entities, directions and CAD associations.
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const;

  private:
    std::shared_ptr<const gmf::File> file_;
};

/// Dimension and degree that the headers of a binary GMF file state. Errors: input.
struct GmfShape {
    int dimension = 0, degree = 1;
};
[[nodiscard]] Outcome<GmfShape> gmf_shape(std::span<const std::byte> bytes, std::string_view name);

/// Locates the blocks of a binary GMF file. `bytes` must outlive the result. Errors: input (not GMF, truncated, counts
/// that do not fit), unsupported (a text file, another degree or dimension, other elements, nodes that are Bézier
/// control points).
template <int D, int Degree = 1>
[[nodiscard]] Outcome<GmfRuns<D, Degree>> gmf_runs(std::span<const std::byte> bytes, std::string_view name);

}  // namespace camber
