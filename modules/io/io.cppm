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
/// Meshes and solutions to and from bytes; the table of formats, one row each; flat meshes to 2D and back. Nothing here
/// touches files: the shell reads and writes them.
export module camber.io;
import camber.core;
import camber.bezier;
// Partitions that are not exported have the parts that readers and writers are made of.
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

/// The formats as tables of values, one row a format. All that knows of formats asks them: which decoder a file needs,
/// which encoder an ending means, what messages and help list. Functions take the table, so that others may have rows
/// of their own beside these (`name` in a decoder is the file's path, for rows that must open it themselves).
export namespace camber {

/// What a caller may choose of how a mesh is written; each format takes what is its own.
struct EncodeOptions {
    VtuCells cells = VtuOptions{}.cells;  ///< of formats that have both kinds (`chooses_cells`)
};

/// How a format is called, and by what its files are known.
struct FormatName {
    std::string_view name;  ///< one word, as options take it; no other row's
    std::string_view what;  ///< a few words for lists
    /// Of its files, with the dot; no other row's. None: it is written only by its name, and read only by its content.
    std::vector<std::string_view> endings;
    /// The ending of another row that its files go by too: what is read from one is written so again. Empty: none.
    std::string_view shared_ending = {};
    /// Whether a file begins as those of this format do, and no other row's. It looks at the first words only.
    bool (*sniff)(std::span<const std::byte> bytes);
};

/// A format of meshes. A decoder or an encoder that is not there: it is not read, or not written.
struct MeshFormat : FormatName {
    Outcome<DecodedMesh> (*decode)(std::span<const std::byte> bytes, std::string_view name,
                                   const DecodeOptions& options, const Execution& execution) = nullptr;
    /// The fields are given to any format; those that do not hold them leave them out.
    Outcome<Chunks> (*encode)(const AnyMesh& mesh, const MeshFields& fields, EncodeOptions options,
                              const Execution& execution) = nullptr;
    /// What of this mesh it cannot hold, but for fields.
    std::vector<Notice> (*losses)(const AnyMesh& mesh) = nullptr;
    bool holds_fields = false;
    /// Whether it has a place for this field; none: for all, if it `holds_fields`.
    bool (*holds)(const MeshField& field) = nullptr;
    /// Which of the fields' names become others in its files; none: it has no place for fields.
    std::vector<Notice> (*renames)(const MeshFields& fields) = nullptr;
    bool chooses_cells = false;    ///< `EncodeOptions::cells` means something to it
    bool for_viewers = false;      ///< its files are for looking at: a run puts its fields there
    bool always_in_space = false;  ///< its files have three coordinates of every mesh: see DecodedMesh
};

/// A format of solutions.
struct SolutionFormat : FormatName {
    Outcome<DecodedSolution> (*decode)(std::span<const std::byte> bytes, std::string_view name,
                                       const Execution& execution) = nullptr;
    Outcome<Chunks> (*encode)(const Solution& solution, const Execution& execution) = nullptr;
};

[[nodiscard]] std::span<const MeshFormat> mesh_formats();
[[nodiscard]] std::span<const SolutionFormat> solution_formats();

/// The row of the table that `accepts(row)`, or null.
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
/// By the ending of a file's name or path.
template <class Format>
[[nodiscard]] const Format* format_with_ending(std::span<const Format> formats, std::string_view path) {
    return find_format(formats, [&](const Format& format) {
        for (const std::string_view ending : format.endings)
            if (path.ends_with(ending)) return true;
        return false;
    });
}
/// By what a file holds.
template <class Format>
[[nodiscard]] const Format* format_with_content(std::span<const Format> formats, std::span<const std::byte> bytes) {
    return find_format(formats, [&](const Format& format) { return format.sniff(bytes); });
}

/// The command that makes a file of that ending one which is read; empty: none is known.
[[nodiscard]] std::string how_to_convert(std::string_view path);

/// "a, b or c".
[[nodiscard]] std::string listed(std::span<const std::string_view> words, std::string_view before_last = " or ",
                                 std::string_view between = ", ");

/// The endings of formats that are read, and of those that are written, in the order of the table.
template <class Format>
[[nodiscard]] std::vector<std::string_view> endings_read(std::span<const Format> formats) {
    std::vector<std::string_view> endings;
    for (const Format& format : formats)
        if (format.decode) endings.insert(endings.end(), format.endings.begin(), format.endings.end());
    return endings;
}
/// Of those that are written only the ones that `accepts(row)`.
template <class Format>
[[nodiscard]] std::vector<std::string_view> endings_written(std::span<const Format> formats, auto&& accepts) {
    std::vector<std::string_view> endings;
    for (const Format& format : formats)
        if (format.encode && accepts(format))
            endings.insert(endings.end(), format.endings.begin(), format.endings.end());
    return endings;
}
template <class Format>
[[nodiscard]] std::vector<std::string_view> endings_written(std::span<const Format> formats) {
    return endings_written(formats, [](const Format&) { return true; });
}
/// The names of formats that are written.
template <class Format>
[[nodiscard]] std::vector<std::string_view> names_written(std::span<const Format> formats) {
    std::vector<std::string_view> names;
    for (const Format& format : formats)
        if (format.encode) names.push_back(format.name);
    return names;
}

/// The row that reads a file: by its content, and only where that is no format's by its ending. Errors: input (neither
/// is known), unsupported (a format that is written only).
template <class Format>
[[nodiscard]] Outcome<const Format*> format_to_read(std::span<const Format> formats, std::span<const std::byte> bytes,
                                                    std::string_view path) {
    const Format* format = format_with_content(formats, bytes);
    if (!format) format = format_with_ending(formats, path);
    if (format && format->decode) return format;
    const std::string command = how_to_convert(path);
    const std::string remedy =
        command.empty() ? "give a " + listed(endings_read(formats)) + " file" : "make it one: " + command;
    if (format)
        return fail(ErrorKind::unsupported, std::string(format->what) + " is written, but not read", std::string(path),
                    {}, remedy);
    return fail(ErrorKind::input,
                bytes.empty() ? "the file is empty" : "it begins as no known format does, nor is its ending known",
                std::string(path), {}, remedy);
}

/// The row that writes a file: the one of that name, or where none is given (empty) by its ending. Errors: usage.
template <class Format>
[[nodiscard]] Outcome<const Format*> format_to_write(std::span<const Format> formats, std::string_view path,
                                                     std::string_view name = {}) {
    const Format* const format = name.empty() ? format_with_ending(formats, path) : format_with_name(formats, name);
    if (format && format->encode) return format;
    if (name.empty())
        return fail(ErrorKind::usage, "no format known for this ending", std::string(path), {},
                    "use " + listed(endings_written(formats)));
    return fail(ErrorKind::usage, "is no format that is written", std::string(name), {},
                "use " + listed(names_written(formats)));
}

/// The row in which the mesh of a file of the row `source` (a name; empty: of none) is written: the one of that name,
/// or the row of the ending, but the source's own where its files go by that ending too: text stays text, and a version
/// that version. Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_to_write_again(std::span<const MeshFormat> formats,
                                                               std::string_view path, std::string_view name,
                                                               std::string_view source);

/// A mesh file's content, in whichever format it is. `path`: the file's, for its ending and for messages. Errors: those
/// of `format_to_read` and of the decoder.
[[nodiscard]] Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path,
                                               const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path,
                                                      const Execution& execution) {
    return decode_mesh(bytes, path, {}, execution);
}
[[nodiscard]] Outcome<DecodedSolution> decode_solution(std::span<const std::byte> bytes, std::string_view path,
                                                       const Execution& execution);

/// The mesh of an SU2 file (degree 1, NDIME 2 or 3; NELEM, NPOIN and NMARK in any order). Several zones are joined, and
/// the references of elements are their numbers; or the one that is asked for is read. Each MARKER_TAG is
/// a group of facets with a reference of its own, 1, 2 … in the file's order; elements of one zone and vertices have
/// reference 0. Indices at the ends of rows are not read, as SU2 does not; SEND_RECEIVE markers and blocks that Camber
/// does not know are left out, with a notice. `where` in errors is `name: line N`; elements and points are counted
/// from 1. Errors: input (malformed, truncated, not finite, indices out of range), unsupported (zones of different
/// dimensions, elements that are no simplices), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_su2(bytes, name, {}, execution);
}

/// Whether the bytes begin as an SU2 file does: with NDIME=, NZONE=, NELEM=, NPOIN= or NMARK=, after comments.
[[nodiscard]] bool is_su2(std::span<const std::byte> bytes);

/// Nodes of a K-simplex of a degree.
template <int K, int Degree>
inline constexpr int nodes_of_degree = Degree == 1 ? K + 1 : quadratic_nodes<K>;

/// Points that follow each other in a file, `first` being the number of the first of them.
template <int D>
struct PointRun {
    std::uint64_t first = 0;
    Buffer<Vec<D>> points = {};
    Buffer<Reference> references = {};
};
/// K-simplices that follow each other in a file. Their nodes are the numbers of points there, from 0: of degree 2 those
/// of edges, in the order of `local_edges`, after all vertices.
template <int K, int Degree>
struct SimplexRun {
    std::uint64_t first = 0;
    Buffer<std::array<std::uint64_t, nodes_of_degree<K, Degree>>> nodes = {};
    Buffer<Reference> references = {};
};

/// What one of several holders has of a mesh: runs of its rows.
template <int D, int Degree>
struct FilePart {
    PointRun<D> vertices = {};
    PointRun<D> mid_nodes = {};  ///< of edges; `first` counts these alone. Of degree 1 none.
    SimplexRun<D, Degree> elements = {};
    SimplexRun<D - 1, Degree> facets = {};
    SimplexRun<1, Degree> edges = {};  ///< feature edges in 3D
};

/// The rows of all parts.
struct PartTotals {
    std::uint64_t vertices = 0, mid_nodes = 0, elements = 0, facets = 0, edges = 0;
};

/// Where a file's rows are to be: a plain value, the same for all who write to it.
struct GmfFrame {
    int version = 0;
    std::uint64_t bytes = 0;                                        ///< of the whole file
    std::uint64_t points = 0, elements = 0, facets = 0, edges = 0;  ///< where the rows of each begin
    PartTotals totals = {};
};

/// Bytes for a place in a file.
struct FilePiece {
    std::uint64_t offset = 0;
    Buffer<std::byte> bytes;
};

/// The frame of a binary file, and all of it that is no part's: headers, and what `lists` says beside the rows. Put in
/// place, they and the pieces of all parts are the file of `encode_gmf_mesh` of the whole. Errors: usage (the version).
template <int D, int Degree>
[[nodiscard]] Outcome<GmfFrame> gmf_frame(const PartTotals& totals, const LinearMesh<D>& lists, int version = 0);
template <int D, int Degree>
[[nodiscard]] Outcome<std::vector<FilePiece>> encode_gmf_frame(const GmfFrame& frame, const LinearMesh<D>& lists,
                                                               const Execution& execution);
template <int D, int Degree>
[[nodiscard]] Outcome<std::vector<FilePiece>> encode_gmf_part(const GmfFrame& frame, const FilePart<D, Degree>& part,
                                                              const Execution& execution);

/// So many rows of each kind.
struct GmfCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// A binary GMF mesh that is read by runs of its rows, any run at a time and several at once: of its bytes only those
/// are touched. Runs are checked as the whole file is (finite coordinates, points that exist, none twice in a simplex),
/// and begin + the size of what is to be filled is at most the count. Points are those of the file: of degree 2 also
/// the nodes of edges. Errors: input, of the first row at fault.
template <int D, int Degree = 1>
class GmfRuns {
  public:
    template <int K>
    using Nodes = std::array<VertexId, nodes_of_degree<K, Degree>>;

    explicit GmfRuns(std::shared_ptr<const gmf::File> file) : file_(std::move(file)) {}

    [[nodiscard]] GmfCounts counts() const;
    [[nodiscard]] Outcome<Done> points(std::size_t begin, std::span<Vec<D>> points,
                                       std::span<Reference> references) const;
    /// K is D, D − 1 or, of feature edges in 3D, 1. Nodes of edges are in the order of `local_edges`, whatever the
    /// file's.
    template <int K>
    [[nodiscard]] Outcome<Done> simplices(std::size_t begin, std::span<Nodes<K>> nodes,
                                          std::span<Reference> references) const;
    /// What is said beside the rows: corners, ridges, required entities, given geometry; without rows.
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const;

  private:
    std::shared_ptr<const gmf::File> file_;
};

/// What a file's simplices are, as its headers say. Errors: input.
struct GmfShape {
    int dimension = 0, degree = 1;
};
[[nodiscard]] Outcome<GmfShape> gmf_shape(std::span<const std::byte> bytes, std::string_view name);

/// Finds where the rows are; the bytes must outlive what is given. Errors: input (no GMF, cut off, counts that do not
/// fit), unsupported (text, another degree or dimension, elements that are no simplices, nodes that are control
/// points), memory.
template <int D, int Degree = 1>
[[nodiscard]] Outcome<GmfRuns<D, Degree>> gmf_runs(std::span<const std::byte> bytes, std::string_view name);

}  // namespace camber
