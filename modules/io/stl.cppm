module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>
export module camber.io:stl;
import camber.core;
import :any_mesh;
import :decode_options;
import :notice;

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
[[nodiscard]] Outcome<Chunks> encode_stl(const LinearMesh<D>& mesh, StlEncoding encoding, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding,
                                         const Execution& execution);

/// Whether the bytes are an STL file of this kind: as many as its count says (binary, also where they begin with
/// `solid`), or else text that begins so.
[[nodiscard]] bool is_stl(std::span<const std::byte> bytes, StlEncoding encoding);

/// What of the mesh is another once it has been an STL file.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_stl(const LinearMesh<D>& mesh, StlEncoding encoding);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding);

}  // namespace camber
