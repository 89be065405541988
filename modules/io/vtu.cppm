module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>
export module camber.io:vtu;
import camber.core;
import :any_mesh;
import :decode_options;
import :mesh_fields;

export namespace camber {

/// What elements of degree 2 become; elements of degree 1 are VTK's linear cells either way.
enum class VtuCells : std::uint8_t {
    quadratic,  ///< VTK_QUADRATIC_EDGE, _TRIANGLE, _TETRA (21, 22, 24): every reader of VTK files knows them
    lagrange,   ///< VTK_LAGRANGE_CURVE, _TRIANGLE, _TETRAHEDRON (68, 69, 71): ParaView refines them more smoothly
};
[[nodiscard]] constexpr auto words(VtuCells) {
    return words_of(Word{VtuCells::quadratic, "quadratic"}, Word{VtuCells::lagrange, "lagrange"});
}

/// How a VTU file is written.
struct VtuOptions {
    VtuCells cells = VtuCells::quadratic;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("vtu_cells", &VtuOptions::cells,
                                 "VTK's quadratic cells, which everything reads, or its Lagrange cells of degree 2"));
    }
};

/// The mesh as a VTK UnstructuredGrid file (XML, appended raw data, zlib blocks, this machine's byte order as
/// declared). Points: the vertices, then the node of each edge, each once; z = 0 in 2D. Cells: elements, facets,
/// feature edges, with the cell arrays `reference`, `dimension` (3, 2, 1), by which they can be told apart, and
/// `entity` where one is known; nodes of both degrees in the order of `local_edges`, which is VTK's. `reference` of the
/// points is as in a GMF file. Vectors are written with three components, symmetric tensors with the six XX YY ZZ XY YZ
/// XZ that ParaView expects, full ones with nine; those of a 2D mesh with zeros for z. The same bytes for any number of
/// threads. Errors: usage (a field whose rows are not those of the mesh), internal (columns of the mesh that do not fit
/// each other), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtu(const LinearMesh<D>& mesh, const MeshFields& fields, VtuOptions options,
                                         const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_vtu(const QuadraticMesh<D>& mesh, const MeshFields& fields, VtuOptions options,
                                         const Execution& execution);

/// The mesh and the fields of a VTU file: one Piece, data as text, base64 or raw, uncompressed or by zlib, in either
/// byte order.
/// - Always in space, simplices of degree 1 (3, 5, 10) and 2 (21, 22, 24; Lagrange cells of these degrees). Vertices
///   among the cells are left out, with a notice.
/// - References are those of the point array `reference` and of the cell array of that name, else of the first of
///   `medit:ref`, `gmsh:physical`, `CellEntityIds` and `MaterialID`; entities those of the cell array `entity`; each of
///   scalars that are whole numbers of 32 bits.
/// - All other arrays of points and cells with 1, 3, 6 or 9 components are fields; whole numbers that fit 32 bits stay
///   such, all others become doubles.
/// `where` in errors is `name: line N` (from 1); cells and points are counted from 1. Errors: input (malformed,
/// truncated, not finite, indices out of range), unsupported (several pieces, another compressor, cells that are no
/// simplices or of higher degree), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_vtu(bytes, name, {}, execution);
}

/// Whether the bytes begin as a VTU file does: XML, and soon a VTKFile of type UnstructuredGrid.
[[nodiscard]] bool is_vtu(std::span<const std::byte> bytes);

/// What of the mesh a VTU file has no place for: corners, ridges, required entities, given geometry.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtu(const LinearMesh<D>& mesh);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_vtu(const QuadraticMesh<D>& mesh) {
    return not_in_vtu(mesh.linear);
}

}  // namespace camber
