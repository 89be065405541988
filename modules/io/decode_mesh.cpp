module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;
import :cgns_names;

/// A mesh of whichever format; files of programs that share an ending with another's.
namespace camber {

namespace {

/// Programs whose files are none that are read, known by how they begin.
struct Namesake {
    std::string_view what, remedy;
};

/// The first line that says something.
std::string_view first_line(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return {};
    text.remove_prefix(begin);
    return text.substr(0, text.find('\n'));
}

/// Three counts, of vertices, triangles and edges, and behind them rows of a place and a label.
bool is_freefem(std::string_view text) {
    const std::string_view line = first_line(text);
    Words words{line.data(), line.data() + line.size()};
    for (int i = 0; i < 3; ++i)
        if (std::int64_t count = 0; !read_number(words, count) || count < 0) return false;
    if (words.find()) return false;
    const std::string_view rest = first_line({line.data() + line.size(), text.data() + text.size()});
    Words row{rest.data(), rest.data() + rest.size()};
    std::size_t numbers = 0;
    for (double value = 0; row.find(); ++numbers)
        if (!read_number(row, value)) return false;
    return numbers == 3 || numbers == 4;
}

/// Sections in parentheses that begin with their number.
bool is_fluent(std::string_view text) {
    const std::string_view line = first_line(text);
    return line.size() > 1 && line[0] == '(' && line[1] >= '0' && line[1] <= '9';
}

bool is_ansys(std::string_view text) {
    const std::string_view line = first_line(text);
    return std::ranges::any_of(std::array{"/COM", "/PREP7", "/BATCH", "/NOPR", "*IF,_CDRDOFF", "NBLOCK"},
                               [&](std::string_view word) { return line.starts_with(word); });
}

std::optional<Namesake> namesake_of(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 4096;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), soon));
    const std::string_view line = first_line(text);
    if (is_med(bytes)) return Namesake{"Salome (.med)", "meshio convert --input-format med FILE NEW.vtu"};
    if (is_freefem(text)) return Namesake{"FreeFEM", "in FreeFEM: savemesh(Th, \"FILE.mesh\")"};
    if (is_fluent(text)) return Namesake{"Fluent", "meshio convert --input-format ansys FILE NEW.vtu, or export CGNS"};
    if (is_ansys(text)) return Namesake{"ANSYS (a .cdb archive)", "export it from ANSYS as CGNS or Nastran (.bdf)"};
    if (line.starts_with("MESH dimension") || line.starts_with("MESH \""))
        return Namesake{"GiD", "export it from GiD as Gmsh's .msh"};
    if (line.starts_with("mesh3d")) return Namesake{"Netgen (.vol)", "export it from Netgen as Gmsh2 format"};
    if (line.starts_with("*Heading") || line.starts_with("*HEADING") || line.starts_with("*NODE"))
        return Namesake{"Abaqus (.inp)", "meshio convert --input-format abaqus FILE NEW.vtu"};
    return std::nullopt;
}

}  // namespace

Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path, const DecodeOptions& options,
                                 const Execution& execution) {
    const bool is_known = format_with_content(mesh_formats(), bytes) != nullptr;
    if (const auto namesake = is_known ? std::nullopt : namesake_of(bytes))
        return fail(ErrorKind::unsupported, "is a mesh of " + std::string(namesake->what) + ", which is not read",
                    std::string(path), {}, std::string(namesake->remedy));
    const auto format = format_to_read(mesh_formats(), bytes, path);
    if (!format) return fail(format.error());
    auto decoded = (*format)->decode(bytes, path, options, execution);
    if (decoded) {
        decoded->always_in_space = (*format)->always_in_space;
        decoded->format = (*format)->name;
    }
    return decoded;
}

}  // namespace camber
