module;
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>
export module camber.run:file_numbers;
import camber.core;
import camber.io;

/// How the file that a mesh is from calls its vertices, elements and references. One numbering for all reports: a
/// vertex has the number of its file (of Gmsh's the tag), an element its place among the file's, from 1; a tag that
/// differs from it stands beside.
export namespace camber::run {

struct FileNumbers {
    Column<std::uint32_t> nodes = {};  ///< DecodedMesh::node_numbers
    FileTags tags = {};

    /// Of a vertex, or of one of the nodes that follow them.
    [[nodiscard]] std::size_t operator()(std::size_t node) const {
        if (!nodes.empty()) return nodes[node];
        return node < tags.vertices.size() ? tags.vertices[node] : node + 1;
    }
    /// Of a simplex of a dimension, by its place from 1; 0: it has none beside its place.
    [[nodiscard]] std::uint64_t tag(int dimension, std::size_t place) const {
        const auto& all = tags.simplices[static_cast<std::size_t>(dimension)];
        return place > 0 && place <= all.size() ? all[place - 1] : 0;
    }
};

/// "71", "71 (tag 323)".
[[nodiscard]] std::string called(std::size_t place, std::uint64_t tag);

/// Names of references, by the dimension of what has them.
using Groups = std::vector<Group>;
/// Empty where it has none.
[[nodiscard]] std::string name_in(const Groups& groups, int dimension, Reference reference);
/// "3", "3 wall".
[[nodiscard]] std::string called(const Groups& groups, int dimension, Reference reference);

[[nodiscard]] FileNumbers numbers_of(const DecodedMesh& mesh);
[[nodiscard]] Groups groups_of(const AnyMesh& mesh);

}  // namespace camber::run
