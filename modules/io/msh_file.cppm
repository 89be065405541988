module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io:msh_file;
import camber.core;
import camber.bezier;
import :listing;
import :meshes;
import :msh;
import :text;
import :writers;

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

/// Groups of no known dimension have that of the elements in them, the highest of several; those without are none.
void find_dimensions(const File& file, Buffer<Group>& groups);
/// Names of physical tags, where references are tags of entities: they would stick to whatever has that number.
void drop_names(Buffer<Group>& groups, std::vector<Notice>& notices);
/// The tags of rows one after the other; empty where they count from 1.
[[nodiscard]] Column<std::uint64_t> told_tags(std::initializer_list<const Buffer<std::uint64_t>*> parts);
/// The tags of a mesh's vertices among those of all nodes of the file.
[[nodiscard]] Column<std::uint64_t> tags_of_vertices(const DecodedMesh& decoded, const Buffer<std::uint64_t>& nodes);

/// The file's lists as one mesh. Errors: as decode_msh.
[[nodiscard]] Outcome<DecodedMesh> mesh_of(File file, const std::string& name, const Execution& execution);

// Which physical tags and entities the simplices and vertices of a mesh get in an MSH file.

/// Simplices of one dimension that share entity and reference.
struct Class {
    Reference entity = 0, reference = 0;  ///< the mesh's
    std::size_t count = 0;
    Reference tag = 0, physical = 0;  ///< the file's: positive; physical 0: in no group
};

/// The simplices of one dimension.
struct Classes {
    std::vector<Class> list;
    Buffer<std::uint32_t> of;  ///< one a simplex
    /// What references, entities that are 0 or negative become.
    std::map<Reference, Reference> physical_of, tag_of;
    std::set<Reference> tags;  ///< of this dimension that are in use

    [[nodiscard]] Reference physical(Reference reference) const {
        return reference > 0 ? reference : physical_of.at(reference);
    }
    [[nodiscard]] Reference tag(Reference entity) const { return entity > 0 ? entity : tag_of.at(entity); }
};

/// What becomes of simplices with reference 0.
enum class Unnumbered : std::uint8_t {
    grouped,     ///< they get a free number, as all that are not positive do
    in_no_group  ///< they stay out of groups, if no name speaks of 0
};

/// Columns of simplices: entities as many as references, or none. `named`: references of groups; `places`: entities
/// that vertices lie on.
[[nodiscard]] Classes classes_of(std::span<const Reference> references, std::span<const Reference> entities,
                                 std::span<const Reference> named, std::span<const Reference> places,
                                 Unnumbered unnumbered = Unnumbered::grouped);

/// A vertex on an entity of the geometry, as the file can say it once for each.
struct Place {
    int dimension = 3;      ///< 3: on none
    std::uint32_t row = 0;  ///< of the associations with entities of that dimension
};

/// The place of each vertex: on the lowest entity that it has an association with, of those the first; empty where the
/// mesh has no associations.
template <int D>
[[nodiscard]] Buffer<Place> places_of(const LinearMesh<D>& mesh);

/// The numbers of all dimensions.
struct Numbers {
    Buffer<Place> places;
    std::vector<Classes> of_dimension;  ///< 0 to 3; of dimension 0 the point elements
    Buffer<std::uint32_t> points;       ///< vertices that are point elements, in turn
};
template <int D>
[[nodiscard]] Numbers numbers_of(const LinearMesh<D>& mesh);

/// The entity that a vertex's place is on, as the mesh has it.
template <int D>
[[nodiscard]] Reference entity_at(const LinearMesh<D>& mesh, Place place) {
    if (place.dimension == 0) return mesh.geometry.on_points[place.row].entity;
    if (place.dimension == 1) return mesh.geometry.on_curves[place.row].entity;
    return mesh.geometry.on_surfaces[place.row].entity;
}

/// f(dimension, simplices) for those of each dimension, the lowest first.
template <int D, class F>
void with_each_dimension(const LinearMesh<D>& mesh, F&& f) {
    if constexpr (D == 3) f(std::integral_constant<int, 1>{}, mesh.edges);
    f(std::integral_constant<int, D - 1>{}, mesh.facets);
    f(std::integral_constant<int, D>{}, mesh.elements);
}

// Simplices in several physical groups. In a file each group has a tag, and a simplex is in any number of them. In a
// mesh a simplex has one reference, and a reference has a name for each group that its simplices are in: the first
// group of `LinearMesh::groups` with a reference is its main one. A name stands for one tag: the lowest reference that
// it is the main name of.

/// Replaces the first physical tags by references: simplices with other sets of tags have other references. The lowest
/// set of those with the same first tag has that as its reference, each of the others the next number after all tags.
/// Adds the names of further groups to `groups`; groups without a name that share simplices with others get one.
void give_references(File& file, Buffer<Group>& groups, std::vector<Notice>& notices);

/// Names in quotes, which end in their line. None at all is one too.
[[nodiscard]] inline NameRule name_rule() { return {.legal = quotable_name, .unnamed = {}}; }
[[nodiscard]] inline FieldNames field_names() { return {name_rule(), name_rule()}; }

/// A physical group of the file with its name.
struct NamedTag {
    int dimension = 0;
    Reference tag = 0;
    std::string name;
};

/// The physical tags of a file, by the mesh's references.
class GroupTags {
  public:
    GroupTags(const Column<Group>& groups, const Numbers& numbers);

    /// The groups that have a name, each tag once.
    [[nodiscard]] const std::vector<NamedTag>& named() const { return named_; }
    /// The tags of a class of simplices of that dimension: none in no group, the main one first.
    [[nodiscard]] std::vector<Reference> of(int dimension, const Class& simplices) const;

  private:
    std::vector<NamedTag> named_;
    std::map<std::pair<int, Reference>, std::vector<Reference>> of_several_;  ///< references with several names
};

/// The one physical tag that each class of simplices has in this version; 0: none.
[[nodiscard]] std::vector<Reference> main_tags(const GroupTags& groups, const Numbers& numbers, int dimension);

/// An entity of the file, with what is on it.
struct FileEntity {
    int dimension = 0;
    Reference tag = 0;
    std::vector<Reference> physicals = {};  ///< of its simplices; none: in no group, or no simplices
    Box<3> box = {};
};

/// The items of each group, group after group, each group's in their order.
struct Grouped {
    Buffer<std::uint32_t> items;
    std::vector<std::size_t> starts;  ///< one more than there are groups
};

/// What version 4 says of where nodes and simplices lie.
struct Layout {
    std::vector<FileEntity> entities;  ///< in ascending order of dimension and tag
    /// Of each dimension 1 to 3, and of the point elements (0): the entity of each class.
    std::array<std::vector<std::uint32_t>, 4> entity_of_class;
    /// Of nodes by 2 × entity, and 1 more for nodes that have parameters.
    Grouped nodes;
};

/// Items 0 to n − 1 by group_of(item), which is below `groups`.
[[nodiscard]] Grouped grouped(std::size_t n, std::size_t groups, const auto& group_of) {
    Grouped made{Buffer<std::uint32_t>(n), std::vector<std::size_t>(groups + 1, 0)};
    for (std::size_t i = 0; i < n; ++i) ++made.starts[group_of(i) + 1];
    for (std::size_t g = 0; g < groups; ++g) made.starts[g + 1] += made.starts[g];
    std::vector<std::size_t> next(made.starts.begin(), made.starts.end() - 1);
    for (std::size_t i = 0; i < n; ++i) made.items[next[group_of(i)]++] = static_cast<std::uint32_t>(i);
    return made;
}

/// Errors: stopped, memory.
template <class Mesh>
[[nodiscard]] Outcome<Layout> layout_of(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups,
                                        const Execution& execution);

/// Write the section of names of physical groups, if there are any, and that of entities.
void put_names(const GroupTags& groups, Sink& sink);
void put_entities(const Layout& layout, Sink& sink);

}  // namespace camber::msh
