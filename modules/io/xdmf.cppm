module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.io:xdmf;
import camber.core;
import :mesh_fields;
import :notice;

export namespace camber {

/// The mesh as an XDMF 3 file, in which all numbers stand as text: one grid, of degree 1 a mixed one of elements,
/// facets and feature edges, of degree 2 of the elements alone (readers know no mixed grids of that), of a surface its
/// triangles. `reference` of nodes and cells, and the fields; symmetric tensors are written as full ones. Errors: usage
/// (a field whose rows are not those of the mesh), internal (columns of the mesh that do not fit each other), memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_xdmf(const LinearMesh<D>& mesh, const MeshFields& fields,
                                          const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_xdmf(const QuadraticMesh<D>& mesh, const MeshFields& fields,
                                          const Execution& execution);

/// Whether the bytes begin as an XDMF file does.
[[nodiscard]] bool is_xdmf(std::span<const std::byte> bytes);

/// What of the mesh an XDMF file has no place for.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_xdmf(const LinearMesh<D>& mesh);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_xdmf(const QuadraticMesh<D>& mesh);

}  // namespace camber
