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

/// Content of an MSH file before a mesh is built.
namespace camber::msh {

struct EntityKey {
    int dimension = 0;
    Reference tag = 0;
    friend auto operator<=>(const EntityKey&, const EntityKey&) = default;
};

struct EntityInfo {
    Reference physical = 0;              ///< first physical tag without its sign; 0: none
    std::vector<Reference> others = {};  ///< further physical tags without signs
    bool of_partition = false;
    EntityKey parent = {};  ///< entity that was divided, for an entity of a partition
};

struct NodeBlock {
    EntityKey entity;
    std::size_t begin = 0, end = 0;  ///< range of rows in `Nodes`
    int parameters = 0;              ///< number of parameters of each node
    std::size_t first_parameter = 0;
};

struct Nodes {
    Buffer<std::uint64_t> tags;
    Buffer<Vec<3>> points;
    Buffer<std::uint32_t> vertex_of;  ///< for each row of the file the position of its node in tag order; empty if the
                                      ///< rows are in tag order
    std::vector<NodeBlock> blocks;
    Buffer<double> parameters;
    TagIndex index;
    bool listed = false;
};

/// K-simplices with N nodes. Entities and tags are stored for each row in version 2, for each block in version 4.
template <int K, int N>
struct Elements {
    static constexpr int dimension = K, width = N;
    Buffer<std::uint64_t> tags;
    Buffer<std::array<VertexId, N>> nodes;  ///< in the order of `local_edges`; an id is invalid if the file has no such
                                            ///< node
    Buffer<Reference> physicals, entities;
    Buffer<std::uint32_t> further;  ///< for each row: number of its set of further physical tags in `TagSets`
};

struct TagSets {
    std::vector<std::vector<Reference>> list{{}};
    std::map<std::vector<Reference>, std::uint32_t> numbers{{{}, 0}};

    std::uint32_t number_of(const std::vector<Reference>& tags) {
        const auto [at, is_new] = numbers.try_emplace(tags, static_cast<std::uint32_t>(list.size()));
        if (is_new) list.push_back(tags);
        return at->second;
    }
};

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

/// Dimension of groups in files that state none. Later it is replaced by that of the group's elements.
inline constexpr int unknown_dimension = -1;

struct File {
    Nodes nodes;
    std::tuple<Elements<0, 1>, Elements<1, 2>, Elements<1, 3>, Elements<2, 3>, Elements<2, 6>, Elements<3, 4>,
               Elements<3, 10>>
        elements;
    std::map<EntityKey, EntityInfo> entities;
    std::vector<ElementBlock> blocks;  ///< for version 4 only
    bool elements_listed = false;
    std::vector<Group> groups;
    TagSets further_groups;
    std::vector<Field> fields;
    std::map<std::pair<bool, std::string>, std::size_t> field_rows;  ///< index in `fields` for each pair (`of_nodes`,
                                                                     ///< name)
    std::map<std::string, std::size_t> skipped;
    std::map<std::int32_t, std::uint64_t> refused;
    std::size_t partitioned = 0;  ///< number of partitioned elements (version 2) or entities (version 4)
    std::size_t skipped_steps = 0;
    std::size_t trailing_bytes = 0;
    bool by_row = false;  ///< true for version 2, see Elements
};

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
    return fail(ErrorKind::unsupported, "holds elements of type " + std::to_string(type) + ", which is unknown",
                source.place(), {}, simplices_remedy);
}
[[nodiscard]] inline auto cut_off(const Source& source, const char* section) {
    return source.error(std::string(section) + ": a valid number is missing here", "the file is cut off or damaged");
}
/// Returns a tag without its sign, which only states an orientation.
[[nodiscard]] constexpr Reference magnitude(std::int64_t tag) {
    constexpr std::int64_t most = std::numeric_limits<Reference>::max();
    tag = std::clamp(tag, -most, most);
    return static_cast<Reference>(tag < 0 ? -tag : tag);
}

[[nodiscard]] Outcome<Done> check_positive(const Source& source, std::size_t begin, RowShape shape,
                                           std::span<const std::uint64_t> tags);

/// Sorts nodes by tag and builds the index of tags.
[[nodiscard]] Outcome<Done> order_nodes(const Source& source, Nodes& nodes);

/// These functions read a section between its first and last line.
[[nodiscard]] Outcome<Done> read_nodes_2(Source& source, bool parametric, Nodes& nodes, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_2(Source& source, File& file, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_1(Source& source, File& file);
[[nodiscard]] Outcome<Done> read_entities_4(Source& source, bool of_partitions, Generation version, File& file);
[[nodiscard]] Outcome<Done> read_nodes_4(Source& source, Generation version, Nodes& nodes, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_4(Source& source, Generation version, File& file, const Execution& execution);
[[nodiscard]] Outcome<Done> read_names(Source& source, File& file);
[[nodiscard]] Outcome<Done> read_data(Source& source, bool of_nodes, File& file, const Execution& execution);

/// Reads all sections. Errors: those of `decode_msh`, but unsupported elements are only counted.
[[nodiscard]] Outcome<File> read_file(Source& source, Generation version, const Execution& execution);

/// Fields that have a value for each node or each cell; notices report the others. Cells are elements, facets, edges,
/// in each dimension with degree 2 first.
[[nodiscard]] MeshFields fields_of(const File& file, std::span<const std::uint64_t> cell_tags,
                                   std::vector<Notice>& notices);

/// Groups of unknown dimension get the highest dimension of their elements. Groups without elements are removed.
void find_dimensions(const File& file, Buffer<Group>& groups);
/// Drops the names of groups if references are entity tags, because the names belong to physical tags.
void drop_names(Buffer<Group>& groups, std::vector<Notice>& notices);
[[nodiscard]] Column<std::uint64_t> explicit_tags(std::initializer_list<const Buffer<std::uint64_t>*> parts);
/// Tags of the mesh's vertices; empty if they are 1, 2, 3 … `nodes`: tags of all nodes in the file.
[[nodiscard]] Column<std::uint64_t> tags_of_vertices(const DecodedMesh& decoded, const Buffer<std::uint64_t>& nodes);

[[nodiscard]] Outcome<DecodedMesh> mesh_of(File file, const std::string& name, const Execution& execution);

// Physical tags and entities of simplices and vertices in an MSH file.

/// All simplices of one dimension with this entity and reference.
struct Class {
    Reference entity = 0, reference = 0;
    std::size_t count = 0;
    Reference tag = 0, physical = 0;  ///< positive numbers of the entity and of the physical group in the file;
                                      ///< `physical` 0: in no group
};

struct Classes {
    std::vector<Class> list;
    Buffer<std::uint32_t> of;
    /// Positive numbers that replace references (`physical_of`) and entities (`tag_of`) that are not positive.
    std::map<Reference, Reference> physical_of, tag_of;
    std::set<Reference> tags;  ///< tags of all entities in the file

    [[nodiscard]] Reference physical(Reference reference) const {
        return reference > 0 ? reference : physical_of.at(reference);
    }
    [[nodiscard]] Reference tag(Reference entity) const { return entity > 0 ? entity : tag_of.at(entity); }
};

/// Treatment of reference 0 without a name.
enum class Unnumbered : std::uint8_t {
    grouped,     ///< it gets a free number, like negative references
    in_no_group  ///< its simplices are in no group
};

/// Divides the simplices of one dimension into classes. `entities`: entity of each simplex, or empty. `named`:
/// references that have a group. `places`: entities with which vertices are associated.
[[nodiscard]] Classes classes_of(std::span<const Reference> references, std::span<const Reference> entities,
                                 std::span<const Reference> named, std::span<const Reference> places,
                                 Unnumbered unnumbered = Unnumbered::grouped);

/// Association of a vertex in the file, which can store only one.
struct Place {
    int dimension = 3;      ///< dimension of the entity; 3: no association
    std::uint32_t row = 0;  ///< row in the mesh's list of associations with entities of this dimension
};

/// For each vertex its first association with an entity of the lowest dimension; empty if the mesh has no associations.
template <int D>
[[nodiscard]] Buffer<Place> places_of(const LinearMesh<D>& mesh);

struct Numbers {
    Buffer<Place> places;
    std::vector<Classes> of_dimension;
    Buffer<std::uint32_t> points;  ///< ascending numbers of vertices that are point elements
};
template <int D>
[[nodiscard]] Numbers numbers_of(const LinearMesh<D>& mesh);

template <int D>
[[nodiscard]] Reference entity_at(const LinearMesh<D>& mesh, Place place) {
    if (place.dimension == 0) return mesh.geometry.on_points[place.row].entity;
    if (place.dimension == 1) return mesh.geometry.on_curves[place.row].entity;
    return mesh.geometry.on_surfaces[place.row].entity;
}

template <int D, class F>
void with_each_dimension(const LinearMesh<D>& mesh, F&& f) {
    if constexpr (D == 3) f(std::integral_constant<int, 1>{}, mesh.edges);
    f(std::integral_constant<int, D - 1>{}, mesh.facets);
    f(std::integral_constant<int, D>{}, mesh.elements);
}

// Simplices in several physical groups. In a file, a simplex may be in any number of groups, and each group has a tag.
// In a mesh, a simplex has one reference, and a reference may have the names of several groups. Its main name is that
// of the first group in `LinearMesh::groups` with this reference. The tag of a name is the lowest reference with this
// main name.

/// Replaces first tags by references, so that each set of tags has its own reference. If sets have the same first tag,
/// the lexicographically lowest set keeps it, and the others get numbers above all tags. Adds the names of all groups
/// of a set to `groups`; an unnamed group that shares simplices with another gets a name.
void assign_references(File& file, Buffer<Group>& groups, std::vector<Notice>& notices);

/// Rule for names: on one line and without double quotes; empty names are allowed.
[[nodiscard]] inline NameRule name_rule() { return {.legal = quotable_name, .unnamed = {}}; }
[[nodiscard]] inline FieldNames field_names() { return {name_rule(), name_rule()}; }

struct NamedTag {
    int dimension = 0;
    Reference tag = 0;
    std::string name;
};

class GroupTags {
  public:
    GroupTags(const Column<Group>& groups, const Numbers& numbers);

    [[nodiscard]] const std::vector<NamedTag>& named() const { return named_; }
    /// Physical tags of a class, the main tag first; empty if it is in no group.
    [[nodiscard]] std::vector<Reference> of(int dimension, const Class& simplices) const;

  private:
    std::vector<NamedTag> named_;
    std::map<std::pair<int, Reference>, std::vector<Reference>> of_several_;  ///< tags of references that have several
                                                                              ///< names
};

[[nodiscard]] std::vector<Reference> main_tags(const GroupTags& groups, const Numbers& numbers, int dimension);

struct FileEntity {
    int dimension = 0;
    Reference tag = 0;
    std::vector<Reference> physicals = {};  ///< tags of its groups; empty if it has no simplices or no group
    Box<3> box = {};
};

/// Items sorted by group. The order of items within a group is preserved.
struct Grouped {
    Buffer<std::uint32_t> items;
    std::vector<std::size_t> starts;  ///< begin of each group in `items`, then the end of the last
};

struct Layout {
    std::vector<FileEntity> entities;
    /// For each dimension and class, the index of its entity. Point elements have dimension 0.
    std::array<std::vector<std::uint32_t>, 4> entity_of_class;
    /// Nodes grouped by entity. For the entity with index e, group 2 e contains the nodes without parameters, and group
    /// 2 e + 1 those with parameters.
    Grouped nodes;
};

[[nodiscard]] Grouped grouped(std::size_t n, std::size_t groups, const auto& group_of) {
    Grouped result{Buffer<std::uint32_t>(n), std::vector<std::size_t>(groups + 1, 0)};
    for (std::size_t i = 0; i < n; ++i) ++result.starts[group_of(i) + 1];
    for (std::size_t g = 0; g < groups; ++g) result.starts[g + 1] += result.starts[g];
    std::vector<std::size_t> next(result.starts.begin(), result.starts.end() - 1);
    for (std::size_t i = 0; i < n; ++i) result.items[next[group_of(i)]++] = static_cast<std::uint32_t>(i);
    return result;
}

template <class Mesh>
[[nodiscard]] Outcome<Layout> layout_of(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups,
                                        const Execution& execution);

void put_names(const GroupTags& groups, Sink& sink);
void put_entities(const Layout& layout, Sink& sink);

}  // namespace camber::msh
