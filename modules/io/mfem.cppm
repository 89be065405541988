module;
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>
export module camber.io:mfem;
import camber.core;
import :any_mesh;
import :decode_options;
import :notice;

export namespace camber {

/// The mesh of a file of "MFEM mesh v1.0", v1.2 or v1.3 (named sets of attributes become names of references):
/// triangles (in 2D, or a surface in space) or tetrahedra, with their boundary, of degree 1, or 2 where `nodes` are an
/// H1 field of that order. Attributes are the references; vertices have 0. `where` in errors is `name: line N`;
/// elements, boundary elements and vertices are counted from 1. Errors: input (malformed, truncated, not finite,
/// indices out of range), unsupported (other versions and kinds of MFEM's meshes, other elements, nodes of other
/// spaces), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_mfem(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_mfem(std::span<const std::byte> bytes, std::string_view name,
                                                      const Execution& execution) {
    return decode_mfem(bytes, name, {}, execution);
}

/// Whether the bytes begin as MFEM's files of meshes do, of whichever version and kind.
[[nodiscard]] bool is_mfem(std::span<const std::byte> bytes);

/// The mesh as "MFEM mesh v1.0", where elements or boundary have names of references as v1.3. Elements are the
/// tetrahedra, in 2D and of a surface the triangles; the boundary is the facets, of a surface the edges, that are faces
/// of elements: MFEM knows no others. Of degree 2, `nodes` are an H1 field of order 2: first those of the vertices,
/// then those of the edges, as the elements name these, in MFEM's order of local edges. References that are not
/// positive become the least positive numbers that no simplex and no name has. The same bytes for any number of
/// threads. Errors: unsupported (facets or edges without any element), internal (columns of the mesh that do not fit
/// each other), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_mfem(const LinearMesh<D>& mesh, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_mfem(const QuadraticMesh<D>& mesh, const Execution& execution);

/// What of the mesh an MFEM file has no place for, facets that are no element's face among it, and which references
/// become others.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_mfem(const LinearMesh<D>& mesh);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_mfem(const QuadraticMesh<D>& mesh) {
    return not_in_mfem(mesh.linear);
}

}  // namespace camber
