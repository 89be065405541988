module;
#include <cstddef>
#include <string>
#include <vector>
module camber.commands:in_parts;
import camber.core;
import camber.distributed;
import camber.io;
import :ending;
import :given;

namespace camber::app {

/// Whether the path is that of a file that names its pieces (.pvtu): written in parts only.
[[nodiscard]] bool names_its_pieces(const std::string& path);
/// What is said where such a file is asked for, and not in how many parts.
[[nodiscard]] Outcome<Done> in_parts_alone(const std::string& path);
/// The format of the files that are written there in parts: that of that name, else by the ending; of a .pvtu VTU.
/// Errors: usage.
[[nodiscard]] Outcome<const MeshFormat*> format_of_parts(const std::string& path, const std::string& name);

/// The mesh in so many parts for a solver, each a file `OUT.1.EXT` … with its nodes' and cells' numbers in the whole as
/// fields (global_nodes, global_cells; from 1), where the format has fields. A .pvtu names them; of other formats the
/// whole is written beside them, with the field `partition` of its cells. Errors: usage, unsupported, write, memory,
/// stopped.
[[nodiscard]] Outcome<Done> write_in_parts(const MeshFormat& format, const DecodedMesh& mesh, std::size_t parts,
                                           EncodeOptions options, const std::string& path, Written& written,
                                           const Execution& execution);

/// What ranks have of a mesh in parts (of `whole` rows), as pieces that a .pvtu names: all ranks call it. The names of
/// the pieces. Errors, of any rank: usage, write, memory, stopped.
template <class Mesh>
[[nodiscard]] Outcome<std::vector<std::string>> write_parts_of_ranks(Ranks& ranks, const RowCounts& whole,
                                                                     const PartsOfRank<Mesh>& own, std::size_t parts,
                                                                     EncodeOptions options, const std::string& path,
                                                                     const Execution& execution);

/// The same of a binary .meshb that several ranks read, into a .pvtu whose pieces each of them writes some
/// of: all ranks call it. The names of the pieces. Errors: of any rank; usage, unsupported.
[[nodiscard]] Outcome<std::vector<std::string>> write_in_parts_on_ranks(const Host& host, const std::string& input,
                                                                        std::size_t parts, EncodeOptions options,
                                                                        const std::string& path,
                                                                        const Execution& execution);

}  // namespace camber::app
