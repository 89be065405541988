// Builds a mesh from the content of an MSH file.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::msh {

namespace {

struct Counts {
    std::size_t between_partitions = 0, physicals = 0, degenerate_lines = 0;
};

struct Owner {
    EntityKey entity;
    Reference physical = 0;
    std::vector<Reference> others = {};
    bool lies_between_partitions = false;
};
Owner owner_of(const File& file, EntityKey key) {
    const auto found = file.entities.find(key);
    if (found == file.entities.end()) return {key};
    const EntityInfo& info = found->second;
    if (!info.of_partition) return {key, info.physical, info.others};
    Owner owner{info.parent, info.physical, info.others, info.parent.dimension != key.dimension};
    if (const auto parent = file.entities.find(info.parent); parent != file.entities.end() && info.physical == 0) {
        owner.physical = parent->second.physical;
        owner.others = parent->second.others;
    }
    return owner;
}

std::vector<Reference> without(Reference first, std::vector<Reference> tags) {
    std::sort(tags.begin(), tags.end());
    tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
    std::erase_if(tags, [&](Reference tag) { return tag == first || tag == 0; });
    return tags;
}

template <int K, int N>
void store_by_row(File& file, Elements<K, N>& elements, Buffer<std::uint8_t>& dropped, Counts& counts) {
    elements.physicals.resize(elements.tags.size());
    elements.entities.resize(elements.tags.size());
    for (const ElementBlock& block : file.blocks) {
        const ElementType& type = *find_type(block.type);
        if (type.dimension != K || type.nodes != N) continue;
        const Owner owner = owner_of(file, block.entity);
        const auto fill = [&](auto& column, auto value) {
            std::fill(column.begin() + static_cast<std::ptrdiff_t>(block.begin),
                      column.begin() + static_cast<std::ptrdiff_t>(block.end), value);
        };
        fill(elements.physicals, owner.physical);
        fill(elements.further, file.further_groups.number_of(without(owner.physical, owner.others)));
        fill(elements.entities, owner.entity.dimension == K ? owner.entity.tag : 0);
        if (owner.lies_between_partitions) {
            if (dropped.empty()) dropped.resize(elements.tags.size(), std::uint8_t{0});
            fill(dropped, std::uint8_t{1});
            counts.between_partitions += block.end - block.begin;
        }
    }
}

/// True if row b is the simplex of row a in another group. Version 2 repeats a simplex for each further group; the
/// nodes are in reversed order if the group has the reversed entity.
template <int K, int N>
bool is_repetition(const Elements<K, N>& elements, std::size_t a, std::size_t b) {
    if (elements.entities[a] != elements.entities[b] || elements.physicals[a] == elements.physicals[b]) return false;
    auto first = elements.nodes[a], second = elements.nodes[b];
    std::sort(first.begin(), first.end());
    std::sort(second.begin(), second.end());
    return first == second;
}

template <int K, int N>
bool has_repetitions(const Elements<K, N>& elements) {
    for (std::size_t i = 1; i < elements.tags.size(); ++i)
        if (is_repetition(elements, i - 1, i)) return true;
    return false;
}

/// Returns the rows to preserve, in tag order; none if all rows are preserved and already in order. The group of a
/// repeated simplex is added to its first row.
template <int K, int N>
std::optional<Buffer<std::uint32_t>> selected_rows(File& file, Elements<K, N>& elements,
                                                   const Buffer<std::uint8_t>& dropped) {
    const Buffer<std::uint32_t> order = rows_by_tag(elements.tags);
    if (order.empty() && dropped.empty() && !(file.by_row && has_repetitions(elements))) return std::nullopt;
    Buffer<std::uint32_t> selected;
    for (std::size_t i = 0; i < elements.tags.size(); ++i) {
        const std::uint32_t row = order.empty() ? static_cast<std::uint32_t>(i) : order[i];
        if (!dropped.empty() && dropped[row] != 0) continue;
        if (file.by_row && !selected.empty() && is_repetition(elements, selected.back(), row)) {
            std::uint32_t& further = elements.further[selected.back()];
            std::vector<Reference> others = file.further_groups.list[further];
            others.push_back(elements.physicals[row]);
            further = file.further_groups.number_of(without(elements.physicals[selected.back()], std::move(others)));
            continue;
        }
        selected.push_back(row);
    }
    return selected;
}

/// Drops lines from a node to itself, which Gmsh writes for curves of length zero.
template <int N>
void drop_degenerate(const Elements<1, N>& elements, Buffer<std::uint8_t>& dropped, Counts& counts) {
    for (std::size_t i = 0; i < elements.tags.size(); ++i) {
        const auto& nodes = elements.nodes[i];
        if (!nodes[0].valid() || nodes[0] != nodes[1]) continue;
        if (dropped.empty()) dropped.resize(elements.tags.size(), std::uint8_t{0});
        if (dropped[i] == 0) ++counts.degenerate_lines;
        dropped[i] = 1;
    }
}

template <class T>
void gather(Buffer<T>& column, const Buffer<std::uint32_t>& rows) {
    Buffer<T> gathered(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) gathered[i] = column[rows[i]];
    column = std::move(gathered);
}

template <int K, int N>
void finish_elements(File& file, Elements<K, N>& elements, Counts& counts) {
    Buffer<std::uint8_t> dropped;
    elements.further.resize(elements.tags.size(), 0);
    if (!file.by_row) store_by_row(file, elements, dropped, counts);
    if constexpr (K == 1) drop_degenerate(elements, dropped, counts);
    if (const auto rows = selected_rows(file, elements, dropped)) {
        gather(elements.tags, *rows);
        gather(elements.nodes, *rows);
        gather(elements.physicals, *rows);
        gather(elements.entities, *rows);
        gather(elements.further, *rows);
    }
    if (K > 0)
        counts.physicals += static_cast<std::size_t>(
            std::count_if(elements.physicals.begin(), elements.physicals.end(), [](Reference p) { return p != 0; }));
}

template <int K, int N>
listing::Rows<N> rows_of(Elements<K, N>& elements, bool has_groups) {
    auto tags = std::make_shared<const Buffer<std::uint64_t>>(std::move(elements.tags));
    return {std::move(elements.nodes),
            has_groups ? std::move(elements.physicals) : elements.entities,
            std::move(elements.entities),
            {simplex_name<K>, [tags](std::size_t row) { return (*tags)[row]; }, {}}};
}

/// Collects associations of nodes. A mid node has an association only if it has parameters.
class Places {
  public:
    Places(const File& file, const listing::Mesh<3>& mesh) : file_(file), known_(mesh.points.size(), std::uint8_t{0}) {
        mid_node_ = known_;
        const auto mark = [&](const auto& rows, std::size_t corners) {
            for (const auto& nodes : rows.nodes)
                for (std::size_t n = corners; n < nodes.size(); ++n)
                    if (nodes[n].valid()) mid_node_[nodes[n].index()] = 1;
        };
        mark(mesh.elements.curved, 4);
        mark(mesh.facets.curved, 3);
        mark(mesh.edges.curved, 2);
    }

    void add_blocks() {
        for (const NodeBlock& block : file_.nodes.blocks) {
            const EntityKey entity = owner_of(file_, block.entity).entity;
            const bool with_parameters = block.parameters > 0 && entity.dimension == block.entity.dimension;
            for (std::size_t i = block.begin; i < block.end; ++i)
                add(i, entity, with_parameters ? parameters_of(block, i) : nullptr);
        }
    }
    void add_point(VertexId vertex, Reference entity) {
        if (entity == 0 || known_[vertex.index()] != 0) return;
        known_[vertex.index()] = 1;
        on_points_.push_back({vertex, entity});
    }

    void put_into(InputGeometry<3>& geometry) && {
        geometry.on_points = sorted(std::move(on_points_));
        geometry.on_curves = sorted(std::move(on_curves_));
        geometry.on_surfaces = sorted(std::move(on_surfaces_));
    }

  private:
    [[nodiscard]] const double* parameters_of(const NodeBlock& block, std::size_t i) const {
        return file_.nodes.parameters.data() + block.first_parameter +
               (i - block.begin) * static_cast<std::size_t>(block.parameters);
    }
    void add(std::size_t row, EntityKey entity, const double* parameters) {
        const auto& vertex_of = file_.nodes.vertex_of;
        const VertexId v(vertex_of.empty() ? row : std::size_t{vertex_of[row]});
        if (entity.dimension > 2 || entity.tag == 0 || (!parameters && mid_node_[v.index()] != 0)) return;
        known_[v.index()] = 1;
        if (entity.dimension == 0) on_points_.push_back({v, entity.tag});
        if (entity.dimension == 1) on_curves_.push_back({v, entity.tag, finite<1>(parameters)});
        if (entity.dimension == 2) on_surfaces_.push_back({v, entity.tag, finite<2>(parameters)});
    }
    template <std::size_t G>
    static std::optional<std::array<double, G>> finite(const double* parameters) {
        if (!parameters) return std::nullopt;
        std::array<double, G> copy{};
        std::copy_n(parameters, G, copy.begin());
        for (const double value : copy)
            if (!is_finite(Vec<2>{{value, 0}})) return std::nullopt;
        return copy;
    }
    template <class On>
    static Buffer<On> sorted(Buffer<On> all) {
        std::stable_sort(all.begin(), all.end(), [](const On& a, const On& b) { return a.item < b.item; });
        return all;
    }

    const File& file_;
    Buffer<std::uint8_t> known_, mid_node_;
    Buffer<Association<0>> on_points_;
    Buffer<Association<1>> on_curves_;
    Buffer<Association<2>> on_surfaces_;
};

Outcome<Done> add_points(const File& file, listing::Mesh<3>& mesh, Places& places) {
    const Elements<0, 1>& points = std::get<0>(file.elements);
    for (std::size_t i = 0; i < points.tags.size(); ++i) {
        const VertexId v = points.nodes[i][0];
        if (!v.valid())
            return fail(ErrorKind::input, "a node is not one of those that the file lists", mesh.name,
                        Entity{"point", points.tags[i]}, "the file is damaged, or was joined from two files");
        mesh.point_references[v.index()] = points.physicals[i];
        places.add_point(v, points.entities[i]);
    }
    return Done{};
}

void set_mid_node_references(const listing::Mesh<3>& mesh, Buffer<Reference>& references) {
    const auto append = [&]<int K>(const listing::Simplices<K>& kind) -> Outcome<Done> {
        for (const auto& nodes : kind.curved.nodes)
            for (int e = 0; e < edges_per_simplex<K>; ++e) {
                const auto& [a, b] = local_edges<K>[e];
                Reference& own = references[nodes[K + 1 + e].index()];
                if (own == 0)
                    own = listing::mid_node_reference(references[nodes[a].index()], references[nodes[b].index()]);
            }
        return Done{};
    };
    static_cast<void>(listing::for_each_dimension(mesh, append));
}

std::vector<Notice> notices_of(const File& file, const Counts& counts, bool has_groups) {
    std::vector<Notice> notices;
    if (!has_groups) notices.push_back({"no simplex is in a physical group: references are the tags of entities"});
    if (counts.degenerate_lines > 0)
        notices.push_back({std::to_string(counts.degenerate_lines) +
                           " lines from a node to itself were left out: they have no length"});
    if (file.trailing_bytes > 0)
        notices.push_back(
            {"all data after the last section was not read (" + std::to_string(file.trailing_bytes) + " bytes)"});
    if (file.partitioned > 0) {
        std::string between;
        if (counts.between_partitions > 0)
            between = ", and " + std::to_string(counts.between_partitions) + " elements between them left out";
        notices.push_back({"the mesh is partitioned: the partitions were joined" + between});
    }
    for (const auto& [name, count] : file.skipped)
        notices.push_back(
            {"the section $" + name + " was skipped" + (count > 1 ? " (" + std::to_string(count) + " of them)" : "")});
    return notices;
}

}  // namespace

Outcome<DecodedMesh> mesh_of(File file, const std::string& name, const Execution& execution) {
    Counts counts;
    std::apply([&](auto&... elements) { (finish_elements(file, elements, counts), ...); }, file.elements);
    auto& [points, lines_1, lines_2, triangles_1, triangles_2, tetrahedra_1, tetrahedra_2] = file.elements;
    const std::size_t simplices = lines_1.tags.size() + lines_2.tags.size() + triangles_1.tags.size() +
                                  triangles_2.tags.size() + tetrahedra_1.tags.size() + tetrahedra_2.tags.size();
    const bool has_groups = counts.physicals > 0 || simplices == 0;
    Buffer<Group> groups(file.groups.begin(), file.groups.end());
    find_dimensions(file, groups);
    std::vector<Notice> notices = notices_of(file, counts, has_groups);
    assign_references(file, groups, notices);
    Buffer<std::uint64_t> cell_tags;
    if (!file.fields.empty())
        for (const auto* tags : {&tetrahedra_2.tags, &tetrahedra_1.tags, &triangles_2.tags, &triangles_1.tags,
                                 &lines_2.tags, &lines_1.tags})
            cell_tags.insert(cell_tags.end(), tags->begin(), tags->end());

    // in each dimension, simplices of degree 2 come first, as in `assembled`
    std::array<Column<std::uint64_t>, 4> tags_of_simplices{
        Column<std::uint64_t>(), explicit_tags({&lines_2.tags, &lines_1.tags}),
        explicit_tags({&triangles_2.tags, &triangles_1.tags}), explicit_tags({&tetrahedra_2.tags, &tetrahedra_1.tags})};

    listing::Mesh<3> mesh;
    mesh.name = name;
    mesh.points = std::move(file.nodes.points);
    mesh.point_references.resize(mesh.points.size(), 0);
    mesh.elements = {rows_of(tetrahedra_1, has_groups), rows_of(tetrahedra_2, has_groups), {}};
    mesh.facets = {rows_of(triangles_1, has_groups), rows_of(triangles_2, has_groups), {}};
    mesh.edges = {rows_of(lines_1, has_groups), rows_of(lines_2, has_groups), {}};
    auto tags = std::make_shared<const Buffer<std::uint64_t>>(file.nodes.tags);
    mesh.number = [tags](std::size_t point) { return (*tags)[point]; };
    if (auto sound = listing::check(mesh, execution); !sound) return fail(std::move(sound.error()));

    Places places(file, mesh);
    places.add_blocks();
    if (auto added = add_points(file, mesh, places); !added) return fail(std::move(added.error()));
    if (!std::get<0>(file.elements).tags.empty()) set_mid_node_references(mesh, mesh.point_references);
    std::move(places).put_into(mesh.geometry);
    mesh.groups = std::move(groups);
    if (!has_groups) drop_names(mesh.groups, notices);
    mesh.fields = fields_of(file, cell_tags, notices);
    auto decoded = listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
    if (!decoded) return decoded;
    decoded->tags.simplices = std::move(tags_of_simplices);
    decoded->tags.vertices = tags_of_vertices(*decoded, file.nodes.tags);
    return decoded;
}

}  // namespace camber::msh
