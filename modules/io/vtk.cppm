module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>
export module camber.io:vtk;
import camber.core;
import :any_mesh;
import :decode_options;
import :mesh_fields;
import :notice;

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
[[nodiscard]] Outcome<Chunks> encode_vtk(const LinearMesh<D>& mesh, const MeshFields& fields, VtkEncoding encoding,
                                         const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtk(const QuadraticMesh<D>& mesh, const MeshFields& fields, VtkEncoding encoding,
                                         const Execution& execution);

/// What of the mesh a VTK file has no place for: as of a VTU file.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtk(const LinearMesh<D>& mesh);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtk(const QuadraticMesh<D>& mesh) {
    return not_in_vtk(mesh.linear);
}

}  // namespace camber
