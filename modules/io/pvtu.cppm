module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>
export module camber.io:pvtu;
import camber.core;
import :any_mesh;
import :decode_options;

export namespace camber {

/// The nodal field of a part of a mesh by which parts are joined: the number of each node in the whole. Written to VTU
/// files as whole numbers of 64 bits, and said to be VTK's global ids.
inline constexpr std::string_view global_nodes = "GlobalNodeId";
/// The same of cells, by which nothing is joined.
inline constexpr std::string_view global_cells = "GlobalElementId";

/// The mesh of a PVTU file, which names VTU files that each hold a piece of it; `DecodeOptions::beside` reads those.
/// Points of several pieces with the same number in `global_nodes` are one, and come in the order of these numbers;
/// where not all pieces have such numbers those at the very same place are. Cells come piece by piece, ghosts left out;
/// fields are those that all pieces have. Errors: input (as decode_vtu, of any piece; no pieces), unsupported (nobody
/// reads the pieces), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_pvtu(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);

/// Whether the bytes begin as a PVTU file does.
[[nodiscard]] bool is_pvtu(std::span<const std::byte> bytes);

/// The PVTU file of such pieces, named as it is to name them; `first` is the file of one of them, as encode_vtu makes
/// it: the others have its arrays. Errors: input (it is no VTU file).
[[nodiscard]] Outcome<std::string> encode_pvtu(std::span<const std::byte> first, std::span<const std::string> names);

}  // namespace camber
