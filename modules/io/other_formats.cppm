module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
export module camber.io:other_formats;
import camber.core;
import :listing;
import :meshes;
import :text;
import :vtu;

export namespace camber {

enum class VtkEncoding : std::uint8_t { ascii, binary };

/// The mesh and the fields of a legacy VTK file (.vtk, versions 1 to 5.1) of an UNSTRUCTURED_GRID, as text or binary:
/// what `decode_vtu` makes of the same cells and arrays. `where` in errors is `name: line N` (of binary files the line
/// of the keyword). Errors: input (malformed, cut off, not finite, indices out of range), unsupported (other data sets,
/// cells that are no simplices or of higher degree, arrays of texts in binary files), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_vtk(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);

/// Whether the bytes begin as a legacy VTK file does; `encoding` is told by its third line.
[[nodiscard]] bool is_vtk(std::span<const std::byte> bytes, VtkEncoding encoding);

/// The mesh as a legacy VTK file of version 4.2, which old readers know: points, cells and arrays as in `encode_vtu`
/// with quadratic cells. Errors: usage (a field whose rows are not those of the mesh), unsupported (more points or
/// entries of cells than 31 bits can number), internal (columns of the mesh that do not fit each other), memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtk(const Mesh<D>& mesh, const MeshFields& fields, VtkEncoding encoding,
                                         const Execution& execution);

/// What of the mesh a VTK file has no place for: as of a VTU file.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtk(const Mesh<D>& mesh);

}  // namespace camber

namespace camber::vtk {

/// Names of fields: as in VTU, and none that is a keyword among arrays.
[[nodiscard]] FieldNames field_names();

inline constexpr const char* damaged = "the file is cut off or damaged";
using Failure = decltype(fail(std::declval<Error>()));

[[nodiscard]] inline std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

/// Walks a legacy VTK file from its begin to its end: words and lines of text, and numbers, which may be binary.
struct Source {
    std::string name;  ///< the file's
    std::string_view text;
    std::size_t at = 0, keyword = 0;  ///< here, and where the section began: the place of errors
    bool binary = false;

    [[nodiscard]] std::string place() const { return line_place(name, text, text.data() + keyword); }
    [[nodiscard]] bool at_end() const { return at == text.size(); }
    void skip_blanks() {
        while (at < text.size() && is_blank(text[at])) ++at;
    }
    std::string_view word() {
        skip_blanks();
        const std::size_t begin = at;
        while (at < text.size() && !is_blank(text[at])) ++at;
        return text.substr(begin, at - begin);
    }
    std::string_view line() {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string_view found = text.substr(at, end - at);
        at = std::min(end + 1, text.size());
        if (found.ends_with('\r')) found.remove_suffix(1);
        return found;
    }
    std::optional<std::uint64_t> count() {
        const std::string_view digits = word();
        std::uint64_t value = 0;
        const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc{} || stop != digits.data() + digits.size() || value > text.size() * 8 + 8)
            return std::nullopt;
        return value;
    }
    [[nodiscard]] Failure wrong(std::string what, std::string remedy = damaged) const {
        return fail(ErrorKind::input, std::move(what), place(), {}, std::move(remedy));
    }
    [[nodiscard]] Failure refused(std::string what, std::string remedy) const {
        return fail(ErrorKind::unsupported, std::move(what), place(), {}, std::move(remedy));
    }

    /// So many rows of numbers of VTK's type. Errors: input (more than follow, malformed), unsupported (no numbers).
    [[nodiscard]] Outcome<vtu::Numbers> numbers(const std::string& type, std::uint64_t rows, std::uint64_t components);
};

}  // namespace camber::vtk

export namespace camber {

enum class StlEncoding : std::uint8_t { ascii, binary };

/// The surface of an STL file, text or binary: its triangles as facets, corners at the very same place one vertex, in
/// the order in which they come. Solids of a text are references 1, 2 … with their names as groups, those of one name
/// one reference; all of a binary file has reference 1. Normals and the attributes of binary triangles are not read.
/// Triangles with two corners at one place are left out, with a notice. `where` in errors is `name: line N` or
/// `name: byte N`; triangles are counted from 1. Errors: input (malformed, cut off, not as many triangles as announced,
/// not finite), unsupported (facets that are no triangles, more than 32 bits can number), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_stl(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);

/// The boundary of the mesh as an STL file, triangles with normals that point outwards: the faces that one tetrahedron
/// alone has; of a surface in space its triangles, of a mesh in 2D all of it at z = 0, as they are turned. A curved
/// triangle becomes four between its nodes; those with two corners at one place are left out. As text each reference is
/// a solid, by its name or `reference_N`; in binary there is one, in coordinates of 32 bits. Errors: unsupported (more
/// triangles or larger coordinates than 32 bits hold), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_stl(const Mesh<D>& mesh, StlEncoding encoding, const Execution& execution);

/// Whether the bytes are an STL file of this kind: as many as its count says (binary, also where they begin with
/// `solid`), or else text that begins so.
[[nodiscard]] bool is_stl(std::span<const std::byte> bytes, StlEncoding encoding);

/// What of the mesh is another once it has been an STL file.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_stl(const Mesh<D>& mesh, StlEncoding encoding);

}  // namespace camber

/// What an STL file holds, for its readers and writers.
namespace camber::stl {

/// A binary file: a header, the number of triangles in 4 bytes, and rows of a normal, three corners and an attribute.
inline constexpr std::size_t header_bytes = 80, count_bytes = 4, row_bytes = 50;

struct Triangle {
    std::array<Vec<3>, 3> corners;
    Reference reference = 1;
};
[[nodiscard]] inline bool has_equal_corners(const Triangle& t) {
    return t.corners[0] == t.corners[1] || t.corners[1] == t.corners[2] || t.corners[2] == t.corners[0];
}
using Triangles = Buffer<Triangle>;

/// References of solids: of the same name the same, else the next; a solid without a name has one of its own.
class Solids {
  public:
    [[nodiscard]] Reference of(const std::string& name) {
        if (name.empty()) return ++last_;
        const auto [place, is_new] = known_.try_emplace(name, last_ + 1);
        if (is_new) groups_.push_back({2, ++last_, name});
        return place->second;
    }
    [[nodiscard]] Buffer<Group> groups() && { return std::move(groups_); }

  private:
    Reference last_ = 0;
    std::map<std::string, Reference> known_;
    Buffer<Group> groups_;
};

/// What is written of a mesh, as it is read again but for the vertices.
struct Written {
    Triangles triangles = {};            ///< solid by solid; none has equal corners
    Buffer<Group> groups = {};           ///< the solids, of a text
    std::vector<Renaming> renamed = {};  ///< names of groups and of their solids
    std::size_t left_out = 0;            ///< triangles with equal corners
    std::size_t rounded = 0;  ///< coordinates that 32 bits do not hold, in binary: infinite where they are too large
};
template <class Mesh>
[[nodiscard]] Written written(const Mesh& mesh, const Column<Group>& groups, StlEncoding encoding);

/// The surface: corners at the very same place (−0 is 0) are one vertex. No triangle has equal corners.
[[nodiscard]] listing::Mesh<3> welded(const Triangles& triangles);

/// A solid's name for each reference of triangles: that of its group, else one with its number.
[[nodiscard]] std::map<Reference, std::string> solid_names(const Triangles& triangles, const Column<Group>& groups,
                                                           std::vector<Renaming>& renamed);

}  // namespace camber::stl

export namespace camber {

/// Whether CGNS files can be read and written: this build knows the library (Debian: libcgns-dev). It is looked for,
/// and loaded, when the first file is to be read or written.
[[nodiscard]] bool knows_cgns();

/// A CGNS file (HDF5 or ADF) of one base and unstructured zones, which are joined (at vertices of one place where the
/// file has connectivities of zones), or of which one is chosen: TETRA_4, TETRA_10, TRI_3, TRI_6, BAR_2, BAR_3, also
/// in MIXED sections. Facets take the reference of the boundary condition that lists them (a point set of faces,
/// elements or vertices), all other simplices that of their section; both are groups by their names. The number is
/// that of the descriptor `reference` below the node, as `encode_cgns` writes it, else 1, 2, 3 … in the file's order.
/// Scalars of a flow solution at vertices are fields; three (in 2D two) named …X …Y …Z are a vector.
/// `name` is the file's path, which the library opens itself where it has these bytes; else they are put into a
/// temporary file. Errors: input, unsupported (structured zones, other cells, with their counts; the
/// library is not there), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_cgns(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_cgns(std::span<const std::byte> bytes, std::string_view name,
                                                      const Execution& execution) {
    return decode_cgns(bytes, name, {}, execution);
}

/// The mesh as a CGNS file: a section for each dimension and reference, of facets with a boundary condition; named by
/// their groups, else `tetrahedra_N`, `triangles_N`, `edges_N`. Scalars and vectors at nodes are a flow solution. The
/// library writes files only: it is given one in the folder for temporary files. Errors: write, unsupported (the
/// library is not there), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_cgns(const Mesh<D>& mesh, const MeshFields& fields, const Execution& execution);

/// Whether the bytes begin as a CGNS file's do: those of HDF5 or ADF.
[[nodiscard]] bool is_cgns(std::span<const std::byte> bytes);

/// What of the mesh a CGNS file has no place for; the order of simplices whose references are not in one run each.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_cgns(const Mesh<D>& mesh);

/// Whether a CGNS file has a place for the field.
[[nodiscard]] bool is_in_cgns(const MeshField& field);

}  // namespace camber

namespace camber::cgns {

/// What simplices of a reference without a name are called.
[[nodiscard]] std::string plain_name(int dimension, Reference reference);

/// An error, with what the library said.
[[nodiscard]] Error error_of(const char* said, ErrorKind kind, std::string_view doing, std::string_view name);
[[nodiscard]] Error no_library(std::string_view why);
[[nodiscard]] Error no_folder(std::string_view root);

}  // namespace camber::cgns

/// MED files, and names of fields, sections and boundary conditions in CGNS files.
namespace camber {

/// Whether the bytes begin as a MED file of Salome does: HDF5, as CGNS, with other nodes.
[[nodiscard]] bool is_med(std::span<const std::byte> bytes);

}  // namespace camber

namespace camber::cgns {

/// The fields that a file has a place for, and their names there.
[[nodiscard]] MeshFields fields_in_file(const MeshFields& fields);
[[nodiscard]] FieldNames field_names();

/// Names of references, by the dimension of their simplices.
using ReferenceNames = std::map<std::pair<int, Reference>, std::string>;
/// The names of sections, each of another reference, and of boundary conditions (of references of facets, none in a
/// surface alone).
struct GroupNames {
    ReferenceNames sections, conditions;
};
template <int D>
[[nodiscard]] GroupNames group_names(const LinearMesh<D>& mesh);

}  // namespace camber::cgns

export namespace camber {

/// The mesh as an XDMF 3 file, in which all numbers stand as text: one grid, of degree 1 a mixed one of elements,
/// facets and feature edges, of degree 2 of the elements alone (readers know no mixed grids of that), of a surface its
/// triangles. `reference` of nodes and cells, and the fields; symmetric tensors are written as full ones. Errors: usage
/// (a field whose rows are not those of the mesh), internal (columns of the mesh that do not fit each other), memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_xdmf(const Mesh<D>& mesh, const MeshFields& fields, const Execution& execution);

/// Whether the bytes begin as an XDMF file does.
[[nodiscard]] bool is_xdmf(std::span<const std::byte> bytes);

/// What of the mesh an XDMF file has no place for.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_xdmf(const Mesh<D>& mesh);

}  // namespace camber
