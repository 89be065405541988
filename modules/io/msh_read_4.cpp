// Reads entities, nodes and elements of MSH 4; builds groups, tags and fields.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

/// Version 4.0 differs from 4.1: tags have 4 bytes, a node's tag precedes its coordinates, an entity's tag precedes its
/// dimension, and points have a box.
namespace camber::msh {

namespace {

template <class Take>
bool read_list(Source& source, Take&& take) {
    std::uint64_t n = 0;
    std::int64_t value = 0;
    if (!source.count(n)) return false;
    for (; n > 0; --n) {
        if (!source.integer(value)) return false;
        take(value);
    }
    return true;
}

bool read_reals(Source& source, int n) {
    double value = 0;
    for (; n > 0; --n)
        if (!source.real(value)) return false;
    return true;
}

bool read_entity(Source& source, int dimension, bool of_partition, Generation version, File& file) {
    const auto ignore = [](std::int64_t) {};
    EntityInfo info{.of_partition = of_partition};
    std::int64_t tag = 0, parent_dimension = 0, parent_tag = 0;
    if (!source.integer(tag)) return false;
    if (of_partition) {
        if (!source.integer(parent_dimension) || !source.integer(parent_tag) || !read_list(source, ignore))
            return false;
        if (parent_dimension < 0 || parent_dimension > 3) return false;
        info.parent = {static_cast<int>(parent_dimension), static_cast<Reference>(parent_tag)};
    }
    if (!read_reals(source, dimension == 0 && version == Generation::v41 ? 3 : 6)) return false;
    const auto physical = [&](std::int64_t value) {
        if (info.physical == 0)
            info.physical = magnitude(value);
        else
            info.others.push_back(magnitude(value));
    };
    if (!read_list(source, physical) || (dimension > 0 && !read_list(source, ignore))) return false;
    file.entities.insert_or_assign(EntityKey{dimension, static_cast<Reference>(tag)}, info);
    return true;
}

struct BlockHead {
    EntityKey entity;
    std::int64_t kind = 0;  ///< in a node block: 1 if its nodes have parameters, else 0; in an element block: the
                            ///< element type
    std::uint64_t count = 0;
};
bool read_head(Source& source, Generation version, BlockHead& head) {
    std::int64_t dimension = 0, tag = 0;
    const bool tag_first = version == Generation::v40;
    if (!source.integer(tag_first ? tag : dimension) || !source.integer(tag_first ? dimension : tag) ||
        !source.integer(head.kind) || !source.count(head.count))
        return false;
    head.entity = {static_cast<int>(dimension), static_cast<Reference>(tag)};
    return dimension >= 0 && dimension <= 3;
}

/// Reads the number of blocks, and skips totals that the blocks imply.
bool read_blocks(Source& source, Generation version, std::uint64_t& blocks) {
    std::uint64_t ignored = 0;
    if (!source.count(blocks) || !source.count(ignored)) return false;
    return version == Generation::v40 || (source.count(ignored) && source.count(ignored));
}

Outcome<Done> read_node_block(Source& source, Generation version, const BlockHead& head, Nodes& nodes,
                              const Execution& execution) {
    const auto parameters = static_cast<std::size_t>(head.kind != 0 ? head.entity.dimension : 0);
    const RowShape tag{1, 8, 0}, place{0, 8, 3 + parameters}, both{1, 4, 3 + parameters};
    if (!source.can_contain_rows(head.count, both))
        return source.error("$Nodes: a block announces " + std::to_string(head.count) + " nodes, but fewer follow",
                            "the file is cut off or damaged");
    const std::size_t before = nodes.tags.size(), n = head.count;
    if (before + n > max_entities) return source.error("$Nodes: there are more nodes than 32 bits can number");
    nodes.blocks.push_back({head.entity, before, before + n, static_cast<int>(parameters), nodes.parameters.size()});
    nodes.tags.resize(before + n);
    nodes.points.resize(before + n);
    const std::size_t first = nodes.parameters.size(), begin = source.at();
    nodes.parameters.resize(first + n * parameters);
    const auto enter_tag = [&](std::size_t i, const auto& row) {
        nodes.tags[before + i] = static_cast<std::uint64_t>(row.integer(0));
    };
    const auto enter_place = [&](std::size_t i, const auto& row) {
        for (int c = 0; c < 3; ++c) nodes.points[before + i][c] = row.real(static_cast<std::size_t>(c));
        for (std::size_t c = 0; c < parameters; ++c) nodes.parameters[first + i * parameters + c] = row.real(3 + c);
    };
    const auto check = [&](RowShape shape) {
        return check_positive(source, begin, shape, std::span<const std::uint64_t>(nodes.tags).subspan(before));
    };
    if (version == Generation::v40)
        return source
            .rows(n, both, execution,
                  [&](std::size_t i, const auto& row) {
                      enter_tag(i, row);
                      enter_place(i, row);
                  })
            .and_then([&](Done) { return check(both); });
    return source.rows(n, tag, execution, enter_tag).and_then([&](Done) { return check(tag); }).and_then([&](Done) {
        return source.rows(n, place, execution, enter_place);
    });
}

template <int K, int N>
Outcome<Done> read_rows(Source& source, std::size_t n, RowShape shape, const Nodes& nodes, Elements<K, N>& elements,
                        const Execution& execution) {
    const std::size_t before = elements.tags.size();
    if (before + n > max_entities)
        return source.error("$Elements has more of one kind than 32 bits can number", "give a smaller mesh");
    elements.tags.resize(before + n);
    elements.nodes.resize(before + n);
    return source.rows(n, shape, execution, [&](std::size_t i, const auto& row) {
        elements.tags[before + i] = static_cast<std::uint64_t>(row.integer(0));
        for (int k = 0; k < N; ++k) {
            const auto tag = static_cast<std::uint64_t>(row.integer(1 + static_cast<std::size_t>(place_in_row<N>(k))));
            elements.nodes[before + i][static_cast<std::size_t>(k)] = VertexId(std::size_t{nodes.index.find(tag)});
        }
    });
}

Outcome<Done> read_element_block(Source& source, Generation version, const BlockHead& head, File& file,
                                 const Execution& execution) {
    const ElementType* const type = find_type(head.kind);
    if (!type) return unknown_type(source, head.kind);
    const std::size_t tag_bytes = version == Generation::v40 ? 4 : 8;
    const RowShape shape{type->nodes + 1, tag_bytes, 0};
    if (!source.can_contain_rows(head.count, shape))
        return source.error(
            "$Elements: a block announces " + std::to_string(head.count) + " elements, but fewer follow",
            "the file is cut off or damaged");
    const std::size_t n = head.count;
    if (!is_supported(*type)) {
        file.refused[type->number] += n;
        return source.rows(n, shape, execution, [](std::size_t, const auto&) {});
    }
    return with_elements(file, type->number, [&](auto& elements) {
        const std::size_t before = elements.tags.size();
        file.blocks.push_back({type->number, head.entity, before, before + n});
        return read_rows(source, n, shape, file.nodes, elements, execution);
    });
}

}  // namespace

Outcome<Done> read_entities_4(Source& source, bool of_partitions, Generation version, File& file) {
    const char* const section = of_partitions ? "$PartitionedEntities" : "$Entities";
    std::uint64_t partitions = 0, ghosts = 0;
    if (of_partitions) {
        if (!source.count(partitions) || !source.count(ghosts)) return cut_off(source, section);
        for (std::int64_t value = 0; ghosts > 0; --ghosts)
            if (!source.integer(value) || !source.integer(value)) return cut_off(source, section);
    }
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& count : counts)
        if (!source.count(count)) return cut_off(source, section);
    for (int dimension = 0; dimension < 4; ++dimension)
        for (std::uint64_t n = counts[static_cast<std::size_t>(dimension)]; n > 0; --n) {
            if (!read_entity(source, dimension, of_partitions, version, file)) return cut_off(source, section);
            if (of_partitions) ++file.partitioned;
        }
    return Done{};
}

Outcome<Done> read_nodes_4(Source& source, Generation version, Nodes& nodes, const Execution& execution) {
    std::uint64_t blocks = 0;
    if (!read_blocks(source, version, blocks)) return cut_off(source, "$Nodes");
    for (; blocks > 0; --blocks) {
        BlockHead head;
        if (!read_head(source, version, head)) return cut_off(source, "$Nodes");
        if (auto read = read_node_block(source, version, head, nodes, execution); !read) return read;
    }
    return Done{};
}

Outcome<Done> read_elements_4(Source& source, Generation version, File& file, const Execution& execution) {
    std::uint64_t blocks = 0;
    if (!read_blocks(source, version, blocks)) return cut_off(source, "$Elements");
    for (; blocks > 0; --blocks) {
        BlockHead head;
        if (!read_head(source, version, head)) return cut_off(source, "$Elements");
        if (auto read = read_element_block(source, version, head, file, execution); !read) return read;
    }
    return Done{};
}

namespace {

std::optional<FieldKind> kind_of(std::size_t components) {
    if (components == 1) return FieldKind::scalar;
    if (components == 3) return FieldKind::vector;
    if (components == 9) return FieldKind::full_tensor;
    return std::nullopt;
}

std::optional<Buffer<double>> by_row(const Field& field, const TagIndex& index, std::size_t rows) {
    Buffer<double> values(rows * field.components);
    Buffer<std::uint8_t> visited(rows, std::uint8_t{0});
    for (std::size_t i = 0; i < field.tags.size(); ++i) {
        const std::uint32_t row = index.find(field.tags[i]);
        if (row == no_row) continue;
        visited[row] = 1;
        std::copy_n(field.values.data() + i * field.components, field.components,
                    values.data() + row * field.components);
    }
    if (std::find(visited.begin(), visited.end(), 0) != visited.end()) return std::nullopt;
    return values;
}

}  // namespace

void find_dimensions(const File& file, Buffer<Group>& groups) {
    const auto look_in = [&]<int K, int N>(const Elements<K, N>& elements) {
        const auto is_in = [&](std::size_t row, Reference tag) {
            const auto& others = file.further_groups.list[elements.further[row]];
            return elements.physicals[row] == tag || std::ranges::find(others, tag) != others.end();
        };
        for (Group& group : groups)
            for (std::size_t i = 0; i < elements.tags.size() && group.dimension == unknown_dimension; ++i)
                if (is_in(i, group.reference)) group.dimension = K;
    };
    const auto& [points, lines_1, lines_2, triangles_1, triangles_2, tetrahedra_1, tetrahedra_2] = file.elements;
    look_in(tetrahedra_1);
    look_in(tetrahedra_2);
    look_in(triangles_1);
    look_in(triangles_2);
    look_in(lines_1);
    look_in(lines_2);
    look_in(points);
    std::erase_if(groups, [](const Group& group) { return group.dimension == unknown_dimension; });
}

void drop_names(Buffer<Group>& groups, std::vector<Notice>& notices) {
    const auto dropped = std::erase_if(groups, [](const Group& group) { return group.dimension > 0; });
    if (dropped > 0)
        notices.push_back({std::to_string(dropped) + " names of physical groups were left out: no simplex is in them"});
}

Column<std::uint64_t> explicit_tags(std::initializer_list<const Buffer<std::uint64_t>*> parts) {
    Buffer<std::uint64_t> tags;
    bool counts = true;
    for (const auto* part : parts)
        for (const std::uint64_t tag : *part) {
            tags.push_back(tag);
            counts = counts && tag == tags.size();
        }
    return counts ? Column<std::uint64_t>() : Column<std::uint64_t>(std::move(tags));
}

Column<std::uint64_t> tags_of_vertices(const DecodedMesh& decoded, const Buffer<std::uint64_t>& nodes) {
    const std::size_t vertices = std::visit([](const auto& mesh) { return mesh.points.size(); }, decoded.mesh);
    if (vertices == nodes.size()) return explicit_tags({&nodes});
    const Column<std::uint32_t>& numbers = decoded.node_numbers;  // for degree 2: position of each vertex in tag order
    if (numbers.size() < vertices) return {};
    const Buffer<std::uint64_t> of(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(vertices));
    return explicit_tags({&of});
}

MeshFields fields_of(const File& file, std::span<const std::uint64_t> cell_tags, std::vector<Notice>& notices) {
    if (file.fields.empty()) return {};
    std::vector<MeshField> fields;
    const Buffer<std::uint32_t> rows = rows_by_tag(cell_tags);
    Buffer<std::uint64_t> ascending(cell_tags.begin(), cell_tags.end());
    for (std::size_t i = 0; i < rows.size(); ++i) ascending[i] = cell_tags[rows[i]];
    const TagIndex cells(ascending, rows);
    for (const Field& field : file.fields) {
        const auto kind = kind_of(field.components);
        if (!kind) {
            notices.push_back({"the field " + in_quotes(field.name) + " has " + std::to_string(field.components) +
                               " components: left out"});
            continue;
        }
        auto values = by_row(field, field.of_nodes ? file.nodes.index : cells,
                             field.of_nodes ? file.nodes.tags.size() : cell_tags.size());
        if (!values)
            notices.push_back({"the field " + in_quotes(field.name) + " does not have a value for each " +
                               (field.of_nodes ? "node" : "simplex") + ": left out"});
        else
            fields.push_back({field.name, field.of_nodes ? Centring::node : Centring::cell, *kind,
                              Column<double>(std::move(*values))});
    }
    if (file.skipped_steps > 0)
        notices.push_back({"fields have several time steps: the last one of each was used, " +
                           std::to_string(file.skipped_steps) + " were left out"});
    return MeshFields(std::move(fields));
}

}  // namespace camber::msh
