module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>
export module camber.io:msh;
import camber.core;
import :any_mesh;
import :decode_options;
import :mesh_fields;
import :notice;

export namespace camber {

/// Which of Gmsh's file formats a mesh is written in.
enum class MshVersion : std::uint8_t {
    v2,  ///< 2.2: physical groups and entities by element; what most solvers read
    v4,  ///< 4.1: entities with their groups, nodes and elements in blocks of entities
};
enum class MshEncoding : std::uint8_t { ascii, binary };

/// How an MSH file is written.
struct MshOptions {
    MshVersion version = MshVersion::v4;
    MshEncoding encoding = MshEncoding::binary;
};

/// A Gmsh mesh (.msh, versions 1, 2.0 to 2.2, 4.0 and 4.1, text or binary in either byte order): always one in space, a
/// 2D mesh has triangles with z = 0. Vertices and simplices stand in the order of their tags.
/// - The reference of a simplex is its first physical tag, without its sign; its entity is Gmsh's. In a file without
///   any physical group the references are the entities. Names of groups are kept: of simplices in several groups the
///   reference has all these names, and sets of groups with the same first tag have other references.
/// - A node's entity and its parameters there become an association, but for nodes in volumes. Mid nodes lose theirs.
/// - Point elements give their node its reference.
/// - Partitions are joined: what lies on a partition's entity is on the parent of that; what is between partitions only
///   is left out.
/// - NodeData and ElementData with a value for each vertex or each simplex become fields.
/// What is left out is told by notices. `name` is the file's, for messages; `where` in errors is `name: line N` or
/// `name: byte N`. Errors: input (malformed, cut off, not finite, nodes that are not there), unsupported (other
/// versions, elements that are no simplices or of higher degree), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_msh(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_msh(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_msh(bytes, name, {}, execution);
}

/// Whether the bytes begin as an MSH file of this kind. Those of versions that are not read are taken for the nearest.
[[nodiscard]] bool is_msh(std::span<const std::byte> bytes, MshOptions kind);

/// The mesh as an MSH file. Vertices have the tags 1, 2 …, then nodes of edges; vertices on points that have a
/// reference (as point elements), edges, facets and elements are numbered in turn, so that the file, when it is read,
/// gives the mesh in the same order. Each simplex has a positive physical tag: its reference, or where that is 0 or
/// negative the first that is free. Its entity is the known one, else has its reference's number; simplices of two
/// references are never on one entity. Nodes are classified (4.1 only) by their association with a point, a curve or a
/// surface, the lowest first; else by the lowest simplices that have them. The same bytes for any number of threads.
/// Errors: usage (a field whose rows are not those of the mesh), unsupported (2.2: more nodes or elements than 31 bits
/// can number), internal (columns of the mesh that do not fit each other), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_msh(const LinearMesh<D>& mesh, const MeshFields& fields, MshOptions options,
                                         const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Chunks> encode_msh(const QuadraticMesh<D>& mesh, const MeshFields& fields, MshOptions options,
                                         const Execution& execution);

/// What of the mesh an MSH file has no place for, and which references and entities get other numbers.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_msh(const LinearMesh<D>& mesh, MshVersion version);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_msh(const QuadraticMesh<D>& mesh, MshVersion version) {
    return not_in_msh(mesh.linear, version);
}

}  // namespace camber
