module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>
module camber.io:msh_raw;
import camber.core;
import :any_mesh;
import :mesh_fields;
import :msh_format;
import :msh_source;
import :notice;
import :refused;
import :tag_index;

/// What an MSH file lists, before it is one mesh: version 4 and version 2 are both read into this.
namespace camber::msh {

/// An entity of Gmsh's model: its dimension and its tag.
struct EntityKey {
    int dimension = 0;
    Reference tag = 0;
    friend auto operator<=>(const EntityKey&, const EntityKey&) = default;
};

/// What $Entities and $PartitionedEntities say of an entity.
struct EntityInfo {
    Reference physical = 0;              ///< the first, without its sign; 0: none
    std::vector<Reference> others = {};  ///< those after the first, likewise
    bool of_partition = false;
    EntityKey parent = {};  ///< of a partition's entity
};

/// Some nodes of one entity, behind one another in the file.
struct NodeBlock {
    EntityKey entity;
    std::size_t begin = 0, end = 0;  ///< rows of Nodes
    int parameters = 0;              ///< of each
    std::size_t first_parameter = 0;
};

struct Nodes {
    Buffer<std::uint64_t> tags;
    Buffer<Vec<3>> points;
    Buffer<std::uint32_t> vertex_of;  ///< of each row of the file: where it stands by tag; none at all: where it stands
    std::vector<NodeBlock> blocks;
    Buffer<double> parameters;
    TagIndex index;  ///< of tags
    bool listed = false;
};

/// K-simplices with so many nodes. What entities say comes by block in version 4, by row in version 2.
template <int K, int N>
struct Elements {
    static constexpr int dimension = K, width = N;
    Buffer<std::uint64_t> tags;
    Buffer<std::array<VertexId, N>> nodes;  ///< in the order of `local_edges`; invalid where there is no such node
    Buffer<Reference> physicals, entities;
    Buffer<std::uint32_t> further;  ///< numbers of sets of groups after the first: one a row, as physicals
};

/// Sets of physical tags, each once; number 0 is the empty set.
struct TagSets {
    std::vector<std::vector<Reference>> list{{}};
    std::map<std::vector<Reference>, std::uint32_t> numbers{{{}, 0}};

    std::uint32_t number_of(const std::vector<Reference>& tags) {
        const auto [at, is_new] = numbers.try_emplace(tags, static_cast<std::uint32_t>(list.size()));
        if (is_new) list.push_back(tags);
        return at->second;
    }
};

/// Rows of elements of one type on one entity.
struct ElementBlock {
    std::int32_t type = 0;
    EntityKey entity;
    std::size_t begin = 0, end = 0;
};

struct Field {
    std::string name;
    bool of_nodes = true;
    std::size_t components = 0;
    Buffer<std::uint64_t> tags;
    Buffer<double> values;
};

/// Of a group whose name tells none: that of the elements which are in it.
inline constexpr int unknown_dimension = -1;

struct File {
    Nodes nodes;
    std::tuple<Elements<0, 1>, Elements<1, 2>, Elements<1, 3>, Elements<2, 3>, Elements<2, 6>, Elements<3, 4>,
               Elements<3, 10>>
        elements;
    std::map<EntityKey, EntityInfo> entities;
    std::vector<ElementBlock> blocks;  ///< version 4
    bool elements_listed = false;
    std::vector<Group> groups;
    TagSets further_groups;
    std::vector<Field> fields;
    std::map<std::pair<bool, std::string>, std::size_t> field_rows;  ///< in `fields`, by `of_nodes` and the name
    std::map<std::string, std::size_t> skipped;                      ///< sections by name
    std::map<std::int32_t, std::uint64_t> refused;                   ///< elements by their type
    std::size_t partitioned = 0;  ///< elements (2) or entities (4) that know partitions
    std::size_t steps_left_out = 0;
    std::size_t left_over = 0;  ///< bytes behind the last section
    bool by_row = false;        ///< physicals and entities are there, by row
};

/// f(elements) with those of a type that Camber holds.
template <class F>
auto with_elements(File& file, std::int32_t type, F&& f) {
    auto& all = file.elements;
    switch (type) {
        case 15: return f(std::get<0>(all));
        case 1: return f(std::get<1>(all));
        case 8: return f(std::get<2>(all));
        case 2: return f(std::get<3>(all));
        case 9: return f(std::get<4>(all));
        case 4: return f(std::get<5>(all));
        default: return f(std::get<6>(all));
    }
}

[[nodiscard]] inline auto unknown_type(const Source& source, std::int64_t type) {
    return fail(ErrorKind::unsupported, "holds elements of type " + std::to_string(type) + ", which is not known",
                source.place(), {}, simplices_remedy);
}
[[nodiscard]] inline auto cut_off(const Source& source, const char* section) {
    return source.error(std::string(section) + ": here should be a number that it can have",
                        "the file is cut off or damaged");
}
/// A physical tag without its sign, which tells an orientation.
[[nodiscard]] constexpr Reference magnitude(std::int64_t tag) {
    constexpr std::int64_t most = std::numeric_limits<Reference>::max();
    tag = std::clamp(tag, -most, most);
    return static_cast<Reference>(tag < 0 ? -tag : tag);
}

/// That tags of nodes are positive, as the format has it: those of a table that begins at `begin`, one a row. Errors:
/// input, at the first that is not.
[[nodiscard]] Outcome<Done> check_positive(const Source& source, std::size_t begin, RowShape shape,
                                           std::span<const std::uint64_t> tags);

/// Enters the nodes' order and their index once all are there. Errors: input (a tag twice).
[[nodiscard]] Outcome<Done> order_nodes(const Source& source, Nodes& nodes);

/// The bodies of sections, from after their first line to before their last.
[[nodiscard]] Outcome<Done> read_nodes_2(Source& source, bool parametric, Nodes& nodes, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_2(Source& source, File& file, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_1(Source& source, File& file);
[[nodiscard]] Outcome<Done> read_entities_4(Source& source, bool of_partitions, Generation version, File& file);
[[nodiscard]] Outcome<Done> read_nodes_4(Source& source, Generation version, Nodes& nodes, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_4(Source& source, Generation version, File& file, const Execution& execution);
[[nodiscard]] Outcome<Done> read_names(Source& source, File& file);
[[nodiscard]] Outcome<Done> read_data(Source& source, bool of_nodes, File& file, const Execution& execution);

/// All sections. Errors: as decode_msh, but for elements that no mesh holds, which are counted.
[[nodiscard]] Outcome<File> read_file(Source& source, Generation version, const Execution& execution);

/// The file's fields that have a value for each node, or for each of the cells (elements, facets, edges, of each those
/// of degree 2 first). Those that are left out are told of.
[[nodiscard]] MeshFields fields_of(const File& file, std::span<const std::uint64_t> cell_tags,
                                   std::vector<Notice>& notices);

/// The file's lists as one mesh. Errors: as decode_msh.
[[nodiscard]] Outcome<DecodedMesh> mesh_of(File file, const std::string& name, const Execution& execution);

}  // namespace camber::msh
