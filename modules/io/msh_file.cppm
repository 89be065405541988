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

/// File content before assembly, for versions 2 and 4.
namespace camber::msh {

struct EntityKey {
    int dimension = 0;
    Reference tag = 0;
    friend auto operator<=>(const EntityKey&, const EntityKey&) = default;
};

/// From $Entities and $PartitionedEntities.
struct EntityInfo {
    Reference physical = 0;              ///< first tag without its sign; 0: none
    std::vector<Reference> others = {};  ///< further tags without signs
    bool of_partition = false;
    EntityKey parent = {};  ///< for entities of partitions
};

struct NodeBlock {
    EntityKey entity;
    std::size_t begin = 0, end = 0;  ///< rows of Nodes
    int parameters = 0;              ///< of each node
    std::size_t first_parameter = 0;
};

struct Nodes {
    Buffer<std::uint64_t> tags;
    Buffer<Vec<3>> points;
    Buffer<std::uint32_t> vertex_of;  ///< position of each file row in tag order; empty if in order
    std::vector<NodeBlock> blocks;
    Buffer<double> parameters;
    TagIndex index;
    bool listed = false;
};

/// Entity data is by block in version 4, by row in version 2.
template <int K, int N>
struct Elements {
    static constexpr int dimension = K, width = N;
    Buffer<std::uint64_t> tags;
    Buffer<std::array<VertexId, N>> nodes;  ///< in the order of `local_edges`; invalid if missing
    Buffer<Reference> physicals, entities;
    Buffer<std::uint32_t> further;  ///< `TagSets` number of the tags after the first, by row
};

/// Number 0 is the empty set.
struct TagSets {
    std::vector<std::vector<Reference>> list{{}};
    std::map<std::vector<Reference>, std::uint32_t> numbers{{{}, 0}};

    std::uint32_t number_of(const std::vector<Reference>& tags) {
        const auto [at, is_new] = numbers.try_emplace(tags, static_cast<std::uint32_t>(list.size()));
        if (is_new) list.push_back(tags);
        return at->second;
    }
};

/// Elements of one type on one entity.
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

/// For groups without a dimension, which get that of their elements.
inline constexpr int unknown_dimension = -1;

struct File {
    Nodes nodes;
    std::tuple<Elements<0, 1>, Elements<1, 2>, Elements<1, 3>, Elements<2, 3>, Elements<2, 6>, Elements<3, 4>,
               Elements<3, 10>>
        elements;
    std::map<EntityKey, EntityInfo> entities;
    std::vector<ElementBlock> blocks;  ///< version 4 only
    bool elements_listed = false;
    std::vector<Group> groups;
    TagSets further_groups;
    std::vector<Field> fields;
    std::map<std::pair<bool, std::string>, std::size_t> field_rows;  ///< index in `fields`, by `of_nodes` and name
    std::map<std::string, std::size_t> skipped;
    std::map<std::int32_t, std::uint64_t> refused;
    std::size_t partitioned = 0;  ///< elements (2) or entities (4) with partitions
    std::size_t skipped_steps = 0;
    std::size_t trailing_bytes = 0;  ///< bytes after the last section
    bool by_row = false;             ///< tags and entities are by row
};

/// Calls f(elements) for a supported type.
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
/// Tag without its sign, which is an orientation.
[[nodiscard]] constexpr Reference magnitude(std::int64_t tag) {
    constexpr std::int64_t most = std::numeric_limits<Reference>::max();
    tag = std::clamp(tag, -most, most);
    return static_cast<Reference>(tag < 0 ? -tag : tag);
}

/// Tags of nodes must be positive. `tags`: those of a table from `begin`, one a row. Errors: input.
[[nodiscard]] Outcome<Done> check_positive(const Source& source, std::size_t begin, RowShape shape,
                                           std::span<const std::uint64_t> tags);

/// Sorts nodes by tag and builds the index, when all are read. Errors: input (duplicate tag).
[[nodiscard]] Outcome<Done> order_nodes(const Source& source, Nodes& nodes);

/// Section bodies, without first and last lines.
[[nodiscard]] Outcome<Done> read_nodes_2(Source& source, bool parametric, Nodes& nodes, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_2(Source& source, File& file, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_1(Source& source, File& file);
[[nodiscard]] Outcome<Done> read_entities_4(Source& source, bool of_partitions, Generation version, File& file);
[[nodiscard]] Outcome<Done> read_nodes_4(Source& source, Generation version, Nodes& nodes, const Execution& execution);
[[nodiscard]] Outcome<Done> read_elements_4(Source& source, Generation version, File& file, const Execution& execution);
[[nodiscard]] Outcome<Done> read_names(Source& source, File& file);
[[nodiscard]] Outcome<Done> read_data(Source& source, bool of_nodes, File& file, const Execution& execution);

/// Errors: as decode_msh, but unsupported elements are only counted.
[[nodiscard]] Outcome<File> read_file(Source& source, Generation version, const Execution& execution);

/// Fields with a value for each node or each cell (elements, facets, edges, each with degree 2 first); notices report
/// the others.
[[nodiscard]] MeshFields fields_of(const File& file, std::span<const std::uint64_t> cell_tags,
                                   std::vector<Notice>& notices);

/// Sets unknown dimensions to the highest one of the group's elements; groups without elements are removed.
void find_dimensions(const File& file, Buffer<Group>& groups);
/// Called if references are tags of entities, to which group names do not apply.
void drop_names(Buffer<Group>& groups, std::vector<Notice>& notices);
/// Concatenates tags; empty if they are 1, 2, 3 …
[[nodiscard]] Column<std::uint64_t> explicit_tags(std::initializer_list<const Buffer<std::uint64_t>*> parts);
/// `nodes`: tags of all nodes of the file.
[[nodiscard]] Column<std::uint64_t> tags_of_vertices(const DecodedMesh& decoded, const Buffer<std::uint64_t>& nodes);

[[nodiscard]] Outcome<DecodedMesh> mesh_of(File file, const std::string& name, const Execution& execution);

// Physical tags and entities of simplices and vertices in an MSH file.

/// Simplices of one dimension, entity and reference.
struct Class {
    Reference entity = 0, reference = 0;
    std::size_t count = 0;
    Reference tag = 0, physical = 0;  ///< in the file: positive; physical 0: no group
};

struct Classes {
    std::vector<Class> list;
    Buffer<std::uint32_t> of;  ///< class of each simplex
    /// New numbers of those ≤ 0.
    std::map<Reference, Reference> physical_of, tag_of;
    std::set<Reference> tags;  ///< tags in use

    [[nodiscard]] Reference physical(Reference reference) const {
        return reference > 0 ? reference : physical_of.at(reference);
    }
    [[nodiscard]] Reference tag(Reference entity) const { return entity > 0 ? entity : tag_of.at(entity); }
};

/// Policy for reference 0.
enum class Unnumbered : std::uint8_t {
    grouped,     ///< a free number, as for negative ones
    in_no_group  ///< unless a name belongs to 0
};

/// `entities`: like `references`, or empty. `named`: references of groups; `places`: entities of vertices.
[[nodiscard]] Classes classes_of(std::span<const Reference> references, std::span<const Reference> entities,
                                 std::span<const Reference> named, std::span<const Reference> places,
                                 Unnumbered unnumbered = Unnumbered::grouped);

/// The one association of a vertex that the file can store.
struct Place {
    int dimension = 3;      ///< 3: no association
    std::uint32_t row = 0;  ///< in the associations of that dimension
};

/// First association of each vertex with an entity of the lowest dimension; empty without associations.
template <int D>
[[nodiscard]] Buffer<Place> places_of(const LinearMesh<D>& mesh);

/// Numbers in the file.
struct Numbers {
    Buffer<Place> places;
    std::vector<Classes> of_dimension;
    Buffer<std::uint32_t> points;  ///< point elements, ascending
};
template <int D>
[[nodiscard]] Numbers numbers_of(const LinearMesh<D>& mesh);

template <int D>
[[nodiscard]] Reference entity_at(const LinearMesh<D>& mesh, Place place) {
    if (place.dimension == 0) return mesh.geometry.on_points[place.row].entity;
    if (place.dimension == 1) return mesh.geometry.on_curves[place.row].entity;
    return mesh.geometry.on_surfaces[place.row].entity;
}

/// Calls f(dimension, simplices), lowest dimension first.
template <int D, class F>
void with_each_dimension(const LinearMesh<D>& mesh, F&& f) {
    if constexpr (D == 3) f(std::integral_constant<int, 1>{}, mesh.edges);
    f(std::integral_constant<int, D - 1>{}, mesh.facets);
    f(std::integral_constant<int, D>{}, mesh.elements);
}

// Simplices in several physical groups. In a file a simplex may be in any number of groups, each with a tag. In a mesh
// a simplex has one reference, which has a name for each group; the main name is that of the first group in
// `LinearMesh::groups` with this reference. The tag of a name is the lowest reference with this main name.

/// Replaces first tags by references, so that different tag sets have different references. Among sets with the same
/// first tag the lowest keeps it; each other set gets the next number after all tags. Adds names of further groups to
/// `groups`; unnamed groups that share simplices with others get a name.
void assign_references(File& file, Buffer<Group>& groups, std::vector<Notice>& notices);

/// Quoted names on one line; the empty name is legal.
[[nodiscard]] inline NameRule name_rule() { return {.legal = quotable_name, .unnamed = {}}; }
[[nodiscard]] inline FieldNames field_names() { return {name_rule(), name_rule()}; }

/// A named physical group.
struct NamedTag {
    int dimension = 0;
    Reference tag = 0;
    std::string name;
};

class GroupTags {
  public:
    GroupTags(const Column<Group>& groups, const Numbers& numbers);

    /// Each tag once.
    [[nodiscard]] const std::vector<NamedTag>& named() const { return named_; }
    /// The main tag first; empty if in no group.
    [[nodiscard]] std::vector<Reference> of(int dimension, const Class& simplices) const;

  private:
    std::vector<NamedTag> named_;
    std::map<std::pair<int, Reference>, std::vector<Reference>> of_several_;  ///< for references with several names
};

/// One tag for each class; 0: none.
[[nodiscard]] std::vector<Reference> main_tags(const GroupTags& groups, const Numbers& numbers, int dimension);

struct FileEntity {
    int dimension = 0;
    Reference tag = 0;
    std::vector<Reference> physicals = {};  ///< empty: no group or no simplices
    Box<3> box = {};
};

/// Items by group, in order within each group.
struct Grouped {
    Buffer<std::uint32_t> items;
    std::vector<std::size_t> starts;  ///< one entry more than groups
};

/// Entities of nodes and simplices in version 4.
struct Layout {
    std::vector<FileEntity> entities;  ///< ascending by dimension and tag
    /// Entity of each class, by dimension; 0: point elements.
    std::array<std::vector<std::uint32_t>, 4> entity_of_class;
    /// Group 2 × entity, plus 1 for nodes with parameters.
    Grouped nodes;
};

/// Items 0 to n − 1 by group_of(item) < `groups`.
[[nodiscard]] Grouped grouped(std::size_t n, std::size_t groups, const auto& group_of) {
    Grouped result{Buffer<std::uint32_t>(n), std::vector<std::size_t>(groups + 1, 0)};
    for (std::size_t i = 0; i < n; ++i) ++result.starts[group_of(i) + 1];
    for (std::size_t g = 0; g < groups; ++g) result.starts[g + 1] += result.starts[g];
    std::vector<std::size_t> next(result.starts.begin(), result.starts.end() - 1);
    for (std::size_t i = 0; i < n; ++i) result.items[next[group_of(i)]++] = static_cast<std::uint32_t>(i);
    return result;
}

/// Errors: stopped, memory.
template <class Mesh>
[[nodiscard]] Outcome<Layout> layout_of(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups,
                                        const Execution& execution);

/// Write physical group names (if there are any) and entities.
void put_names(const GroupTags& groups, Sink& sink);
void put_entities(const Layout& layout, Sink& sink);

}  // namespace camber::msh
