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

/// Decodes a legacy VTK file (.vtk, versions 1 to 5.1) with an UNSTRUCTURED_GRID, as text or binary. Cells and arrays
/// are treated as in `decode_vtu`. In binary files the position of an error is the line of the last keyword. Further
/// errors: unsupported (other data sets, string arrays in binary files).
[[nodiscard]] Outcome<DecodedMesh> decode_vtk(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);

[[nodiscard]] bool is_vtk(std::span<const std::byte> bytes, VtkEncoding encoding);

/// Encodes version 4.2, which old readers support. Points, cells and arrays are those of `encode_vtu` with quadratic
/// cells. Further errors: unsupported (more points or cell entries than 31 bits can number).
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtk(const Mesh<D>& mesh, const MeshFields& fields, VtkEncoding encoding,
                                         const Execution& execution);

/// See `not_in_vtu`.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtk(const Mesh<D>& mesh);

}  // namespace camber

namespace camber::vtk {

/// The rules for names in VTU files; METADATA is also reserved.
[[nodiscard]] FieldNames field_names();

inline constexpr const char* damaged = "the file is cut off or damaged";
using Failure = decltype(fail(std::declval<Error>()));

[[nodiscard]] inline std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

struct Source {
    std::string name;
    std::string_view text;
    std::size_t at = 0, keyword = 0;  ///< current position; begin of the current section, for messages
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

    [[nodiscard]] Outcome<vtu::Numbers> numbers(const std::string& type, std::uint64_t rows, std::uint64_t components);
};

}  // namespace camber::vtk

export namespace camber {

enum class StlEncoding : std::uint8_t { ascii, binary };

/// Decodes an STL surface, text or binary.
/// - Triangles become facets; those with two coincident corners are dropped with a notice.
/// - Corners at exactly the same position become one vertex, numbered by first occurrence.
/// - Solids of text files get references 1, 2 …, one for each name, and groups with the names. In binary files all
///   triangles have reference 1.
/// - Normals and binary attributes are ignored.
///
/// Further errors: input (a different number of triangles than announced), unsupported (facets that are not triangles,
/// more than 32 bits can number).
[[nodiscard]] Outcome<DecodedMesh> decode_stl(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);

/// Encodes the boundary of the mesh as triangles.
/// - For a mesh of tetrahedra: the faces of exactly one tetrahedron, with outward normals.
/// - For a surface in space or a 2D mesh (z = 0): all its triangles, with their orientation.
/// - A curved triangle becomes four triangles between its nodes. Triangles with two coincident corners are dropped.
/// - Text has a solid for each reference, with its name or `reference_N`. Binary is one solid with 32-bit coordinates.
///
/// Errors: unsupported (more triangles or larger coordinates than 32 bits hold).
template <int D>
[[nodiscard]] Outcome<Chunks> encode_stl(const Mesh<D>& mesh, StlEncoding encoding, const Execution& execution);

/// Binary files have the size that follows from their number of triangles; their header may begin with `solid`. Other
/// files that begin with `solid` are text.
[[nodiscard]] bool is_stl(std::span<const std::byte> bytes, StlEncoding encoding);

template <int D>
[[nodiscard]] std::vector<Notice> not_in_stl(const Mesh<D>& mesh, StlEncoding encoding);

}  // namespace camber

namespace camber::stl {

/// A binary file is a header, the number of triangles, and a row for each triangle: normal, three corners, attribute.
inline constexpr std::size_t header_bytes = 80, count_bytes = 4, row_bytes = 50;

struct Triangle {
    std::array<Vec<3>, 3> corners;
    Reference reference = 1;
};
[[nodiscard]] inline bool has_equal_corners(const Triangle& t) {
    return t.corners[0] == t.corners[1] || t.corners[1] == t.corners[2] || t.corners[2] == t.corners[0];
}
using Triangles = Buffer<Triangle>;

/// References of solids. Solids with the same name share a reference; each unnamed solid gets a new one.
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

struct Written {
    Triangles triangles = {};            ///< sorted by solid; no triangle has equal corners
    Buffer<Group> groups = {};           ///< named solids of a text file
    std::vector<Renaming> renamed = {};  ///< groups whose solid has another name
    std::size_t left_out = 0;            ///< number of triangles with equal corners
    std::size_t rounded = 0;             ///< number of coordinates that binary files round to 32 bits; too large ones
                                         ///< become infinite
};
template <class Mesh>
[[nodiscard]] Written written(const Mesh& mesh, const Column<Group>& groups, StlEncoding encoding);

/// Merges corners at the same position into one vertex (−0 equals 0). Precondition: no triangle has equal corners.
[[nodiscard]] listing::Mesh<3> welded(const Triangles& triangles);

[[nodiscard]] std::map<Reference, std::string> solid_names(const Triangles& triangles, const Column<Group>& groups,
                                                           std::vector<Renaming>& renamed);

}  // namespace camber::stl

export namespace camber {

/// True if this build was configured with the CGNS library (Debian: libcgns-dev). The library is located and loaded at
/// the first read or write.
[[nodiscard]] bool has_cgns_support();

/// Decodes a CGNS file (HDF5 or ADF) with one base and unstructured zones.
/// - All zones are joined, unless the options select one. Coincident vertices are merged if the file has zone
///   connectivities.
/// - Elements: TETRA_4, TETRA_10, TRI_3, TRI_6, BAR_2, BAR_3, also in MIXED sections.
/// - Facets take the reference of the boundary condition that lists them (a point set of faces, elements or vertices),
///   other simplices that of their section. Conditions and sections become named groups.
/// - The reference of a condition or section is its descriptor `reference` (written by `encode_cgns`), else 1, 2, 3 …
///   in file order.
/// - Scalars of a flow solution at vertices become fields; three (in 2D two) named …X …Y …Z become a vector.
///
/// `name` is the file's path. The library opens that file if it has the size of `bytes`, else a temporary copy of
/// `bytes`. Errors: input, unsupported (structured zones, other cells, with their counts; the library is missing).
[[nodiscard]] Outcome<DecodedMesh> decode_cgns(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_cgns(std::span<const std::byte> bytes, std::string_view name,
                                                      const Execution& execution) {
    return decode_cgns(bytes, name, {}, execution);
}

/// Encodes a section for each dimension and reference, and a boundary condition for each facet reference. Their names
/// are those of groups, else `tetrahedra_N`, `triangles_N`, `edges_N`. Scalars and vectors at nodes become a flow
/// solution. The library writes to a file in the folder for temporary files. Errors: write, unsupported (the library is
/// missing).
template <int D>
[[nodiscard]] Outcome<Chunks> encode_cgns(const Mesh<D>& mesh, const MeshFields& fields, const Execution& execution);

/// True for HDF5 (but not MED) and ADF files.
[[nodiscard]] bool is_cgns(std::span<const std::byte> bytes);

/// Lists lost data. The order of simplices is lost if simplices with the same reference are not consecutive.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_cgns(const Mesh<D>& mesh);

[[nodiscard]] bool is_in_cgns(const MeshField& field);

}  // namespace camber

namespace camber::cgns {

/// Name in the file of a reference without a group.
[[nodiscard]] std::string plain_name(int dimension, Reference reference);

[[nodiscard]] Error error_of(const char* said, ErrorKind kind, std::string_view doing, std::string_view name);
[[nodiscard]] Error no_library(std::string_view cause);
[[nodiscard]] Error no_folder(std::string_view root);

}  // namespace camber::cgns

namespace camber {

/// True for MED files of Salome, which are HDF5 files like CGNS but with other HDF5 nodes.
[[nodiscard]] bool is_med(std::span<const std::byte> bytes);

}  // namespace camber

namespace camber::cgns {

[[nodiscard]] MeshFields fields_in_file(const MeshFields& fields);
[[nodiscard]] FieldNames field_names();

using ReferenceNames = std::map<std::pair<int, Reference>, std::string>;
/// Names of sections (one for each reference) and of boundary conditions (one for each facet reference; none in a
/// surface mesh).
struct GroupNames {
    ReferenceNames sections, conditions;
};
template <int D>
[[nodiscard]] GroupNames group_names(const LinearMesh<D>& mesh);

}  // namespace camber::cgns

export namespace camber {

/// Encodes an XDMF 3 file with one grid and all numbers as text. Degree 1 is a mixed grid of elements, facets and
/// feature edges. Degree 2 has only the elements (for a surface its triangles), since readers do not support mixed
/// grids of degree 2. Fields and the `reference` of nodes and cells become attributes; symmetric tensors become full
/// ones.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_xdmf(const Mesh<D>& mesh, const MeshFields& fields, const Execution& execution);

[[nodiscard]] bool is_xdmf(std::span<const std::byte> bytes);

template <int D>
[[nodiscard]] std::vector<Notice> not_in_xdmf(const Mesh<D>& mesh);

}  // namespace camber
