module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
export module camber.io:formats;
import camber.core;
import :any_mesh;
import :decode_options;
import :mesh_fields;
import :solution;
import :vtu;

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

}  // namespace camber
