module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
export module camber.io:stl;
import camber.core;
import :notice;

export namespace camber {

enum class StlEncoding : std::uint8_t { ascii, binary };

/// The boundary of the mesh as an STL file, triangles with normals that point outwards: the faces that one tetrahedron
/// alone has; of a surface in space its triangles, of a mesh in 2D all of it at z = 0, as they are turned. A curved
/// triangle becomes four between its nodes. As text each reference is a solid, by its name or `reference_N`; in binary
/// there is one. Errors: unsupported (more triangles than 32 bits can number), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_stl(const LinearMesh<D>& mesh, StlEncoding encoding, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding,
                                         const Execution& execution);

/// Whether the bytes are an STL file of this kind: text that begins with `solid`, or as many bytes as its count says.
[[nodiscard]] bool is_stl(std::span<const std::byte> bytes, StlEncoding encoding);

/// What of the mesh an STL file has no place for.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_stl(const LinearMesh<D>& mesh, StlEncoding encoding);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding);

}  // namespace camber
