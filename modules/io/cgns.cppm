module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>
export module camber.io:cgns;
import camber.core;
import :any_mesh;
import :decode_options;
import :mesh_fields;
import :notice;

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
[[nodiscard]] Outcome<Chunks> encode_cgns(const LinearMesh<D>& mesh, const MeshFields& fields,
                                          const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_cgns(const QuadraticMesh<D>& mesh, const MeshFields& fields,
                                          const Execution& execution);

/// Whether the bytes begin as a CGNS file's do: those of HDF5 or ADF.
[[nodiscard]] bool is_cgns(std::span<const std::byte> bytes);

/// What of the mesh a CGNS file has no place for; the order of simplices whose references are not in one run each.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_cgns(const LinearMesh<D>& mesh);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_cgns(const QuadraticMesh<D>& mesh) {
    return not_in_cgns(mesh.linear);
}

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
