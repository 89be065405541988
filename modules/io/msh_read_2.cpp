// Reads nodes and elements of MSH 1 and 2, and data sections of all versions.
module;
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::msh {

namespace {

/// Reads a count, which is text even in binary files and cannot exceed the number of remaining bytes.
bool read_count(Source& source, std::size_t& count) {
    std::int64_t number = 0;
    if (!source.text_number(number) || number < 0) return false;
    source.line();
    count = static_cast<std::size_t>(number);
    return count <= source.left();
}

auto too_many(const Source& source, const char* section, std::size_t count) {
    return source.error(std::string(section) + " announces " + std::to_string(count) + " rows, but fewer follow",
                        "the file is cut off or damaged");
}

bool read_tag(Source& source, std::uint64_t& tag) {
    std::int64_t value = 0;
    if (!(source.binary ? source.integer(value) : source.text_number(value))) return false;
    tag = static_cast<std::uint64_t>(value);
    return true;
}

/// Reads a node of $ParametricNodes; its number of parameters depends on the entity's dimension.
bool read_parametric_node(Source& source, std::size_t i, Nodes& nodes) {
    if (!read_tag(source, nodes.tags[i]) || static_cast<std::int64_t>(nodes.tags[i]) < 1) return false;
    for (int c = 0; c < 3; ++c)
        if (!source.real(nodes.points[i][c])) return false;
    std::int64_t dimension = 0, tag = 0;
    if (!source.integer(dimension) || !source.integer(tag) || dimension < 0 || dimension > 3) return false;
    const int parameters = dimension < 3 ? static_cast<int>(dimension) : 0;
    nodes.blocks.push_back(
        {{static_cast<int>(dimension), static_cast<Reference>(tag)}, i, i + 1, parameters, nodes.parameters.size()});
    for (int k = 0; k < parameters; ++k)
        if (double value = 0; source.real(value))
            nodes.parameters.push_back(value);
        else
            return false;
    return true;
}

struct Head {
    std::int64_t type = 0, elements = 0, tags = 0;
};

template <int K, int N, class Row>
void enter(const Row& row, std::size_t tags, const Nodes& nodes, std::size_t i, Elements<K, N>& elements) {
    elements.tags[i] = static_cast<std::uint64_t>(row.integer(0));
    const auto tag_at = [&](std::size_t k) { return k < tags ? static_cast<Reference>(row.integer(1 + k)) : 0; };
    elements.physicals[i] = magnitude(tag_at(0));
    elements.entities[i] = tag_at(1);
    for (int k = 0; k < N; ++k) {
        const std::int64_t tag = row.integer(1 + tags + static_cast<std::size_t>(place_in_row<N>(k)));
        elements.nodes[i][static_cast<std::size_t>(k)] =
            VertexId(std::size_t{nodes.index.find(static_cast<std::uint64_t>(tag))});
    }
}

void grow(auto& elements, std::size_t n) {
    const std::size_t size = elements.tags.size() + n;
    elements.tags.resize(size);
    elements.nodes.resize(size);
    elements.physicals.resize(size);
    elements.entities.resize(size);
}

Outcome<Done> read_rows(Source& source, const Head& head, File& file, const Execution& execution) {
    const ElementType* const type = find_type(head.type);
    if (!type) return unknown_type(source, head.type);
    const auto n = static_cast<std::size_t>(head.elements), tags = static_cast<std::size_t>(head.tags);
    const RowShape shape{1 + tags + type->nodes, 4, 0};
    if (tags > source.left() || !source.can_contain_rows(n, shape)) return too_many(source, "$Elements", n);
    if (!is_supported(*type)) {
        file.refused[type->number] += n;
        return source.rows(n, shape, execution, [](std::size_t, const auto&) {});
    }
    return with_elements(file, type->number, [&](auto& elements) -> Outcome<Done> {
        const std::size_t before = elements.tags.size();
        if (before + n > max_entities) return too_many(source, "$Elements", before + n);
        grow(elements, n);
        std::atomic<bool> partitioned = false;
        auto read = source.rows(n, shape, execution, [&](std::size_t i, const auto& row) {
            enter(row, tags, file.nodes, before + i, elements);
            if (tags > 2 && row.integer(3) > 0) partitioned.store(true, std::memory_order_relaxed);
        });
        if (partitioned.load()) file.partitioned += n;
        return read;
    });
}

void enter_line(const ElementType& type, std::size_t tags, const TextRow& row, File& file) {
    if (tags > 2 && row.integers[3] > 0) ++file.partitioned;
    if (!is_supported(type)) {
        ++file.refused[type.number];
        return;
    }
    with_elements(file, type.number, [&](auto& elements) {
        grow(elements, 1);
        enter(row, tags, file.nodes, elements.tags.size() - 1, elements);
    });
}

/// Reads a line: tag, type, number of tags, tags, nodes.
Outcome<Done> read_line(Source& source, File& file, TextRow& row) {
    Head head;
    std::int64_t tag = 0;
    if (!source.text_number(tag) || !source.text_number(head.type) || !source.text_number(head.tags) || head.tags < 0 ||
        static_cast<std::size_t>(head.tags) > source.left())
        return cut_off(source, "$Elements");
    const ElementType* const type = find_type(head.type);
    if (!type) return unknown_type(source, head.type);
    const auto tags = static_cast<std::size_t>(head.tags);
    row.integers.resize(1 + tags + type->nodes);
    row.integers[0] = tag;
    for (std::size_t i = 1; i < row.integers.size(); ++i)
        if (!(i <= tags ? source.integer(row.integers[i]) : source.text_number(row.integers[i])))
            return cut_off(source, "$Elements");
    enter_line(*type, tags, row, file);
    return Done{};
}

/// Reads a line of version 1: tag, type, group, entity, number of nodes, nodes.
Outcome<Done> read_old_line(Source& source, File& file, TextRow& row) {
    std::int64_t tag = 0, kind = 0, nodes = 0;
    if (!source.text_number(tag) || !source.text_number(kind)) return cut_off(source, "$ELM");
    const ElementType* const type = find_type(kind);
    if (!type) return unknown_type(source, kind);
    constexpr std::size_t tags = 2;
    row.integers.assign(1 + tags + type->nodes, tag);
    bool sound = source.integer(row.integers[1]) && source.integer(row.integers[2]) && source.text_number(nodes) &&
                 std::cmp_equal(nodes, type->nodes);
    for (std::size_t i = 1 + tags; sound && i < row.integers.size(); ++i) sound = source.text_number(row.integers[i]);
    if (!sound) return cut_off(source, "$ELM");
    enter_line(*type, tags, row, file);
    return Done{};
}

}  // namespace

Outcome<Done> read_nodes_2(Source& source, bool parametric, Nodes& nodes, const Execution& execution) {
    std::size_t n = 0;
    if (!read_count(source, n)) return cut_off(source, "$Nodes");
    const RowShape shape{1, 4, 3};
    if (!source.can_contain_rows(n, shape)) return too_many(source, "$Nodes", n);
    nodes.tags.resize(n);
    nodes.points.resize(n);
    if (!parametric) {
        const std::size_t begin = source.at();
        return source
            .rows(n, shape, execution,
                  [&](std::size_t i, const auto& row) {
                      nodes.tags[i] = static_cast<std::uint64_t>(row.integer(0));
                      for (int c = 0; c < 3; ++c) nodes.points[i][c] = row.real(static_cast<std::size_t>(c));
                  })
            .and_then([&](Done) { return check_positive(source, begin, shape, nodes.tags); });
    }
    for (std::size_t i = 0; i < n; ++i)
        if (!read_parametric_node(source, i, nodes)) return cut_off(source, "$ParametricNodes");
    return Done{};
}

Outcome<Done> read_elements_2(Source& source, File& file, const Execution& execution) {
    std::size_t n = 0;
    if (!read_count(source, n)) return cut_off(source, "$Elements");
    file.by_row = true;
    TextRow row;
    while (n > 0) {
        Head head{.elements = 1};
        if (source.binary) {
            if (!source.integer(head.type) || !source.integer(head.elements) || !source.integer(head.tags) ||
                head.elements < 1 || static_cast<std::size_t>(head.elements) > n || head.tags < 0)
                return cut_off(source, "$Elements");
            if (auto read = read_rows(source, head, file, execution); !read) return read;
        } else if (auto read = read_line(source, file, row); !read) {
            return read;
        }
        n -= static_cast<std::size_t>(head.elements);
    }
    return Done{};
}

Outcome<Done> read_elements_1(Source& source, File& file) {
    std::size_t n = 0;
    if (!read_count(source, n)) return cut_off(source, "$ELM");
    file.by_row = true;
    TextRow row;
    for (; n > 0; --n)
        if (auto read = read_old_line(source, file, row); !read) return read;
    return Done{};
}

// Sections that are equal in all versions: names of groups, and fields.

namespace {

std::string unquoted(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    if (text.starts_with('"')) text.remove_prefix(1);
    if (text.ends_with('"')) text.remove_suffix(1);
    return std::string(text);
}

struct DataHead {
    std::string name;
    std::size_t components = 0, rows = 0;
};

template <class Take>
bool read_tags(Source& source, Take&& take) {
    std::int64_t n = 0;
    if (!source.text_number(n) || n < 0) return false;
    for (; n > 0; --n)
        if (source.left() == 0 || !take()) return false;
    return true;
}

bool read_head(Source& source, DataHead& head) {
    std::vector<std::string> strings;
    std::vector<std::int64_t> integers;
    const auto text = [&] {
        source.skip_blanks();
        strings.push_back(unquoted(source.line()));
        return true;
    };
    const auto real = [&] {
        double time = 0;
        return source.text_number(time);
    };
    const auto integer = [&] {
        integers.push_back(0);
        return source.text_number(integers.back());
    };
    if (!read_tags(source, text) || !read_tags(source, real) || !read_tags(source, integer)) return false;
    source.line();
    if (integers.size() < 3 || integers[1] < 0 || integers[2] < 0) return false;
    head.name = strings.empty() ? "" : strings[0];
    head.components = static_cast<std::size_t>(integers[1]);
    head.rows = static_cast<std::size_t>(integers[2]);
    return head.components <= source.left() && head.rows <= source.left();
}

}  // namespace

Outcome<Done> read_names(Source& source, File& file) {
    std::int64_t n = 0, dimension = 0, tag = 0;
    std::set<std::pair<int, Reference>> known;
    if (!source.text_number(n) || n < 0) return cut_off(source, "$PhysicalNames");
    for (; n > 0; --n) {
        if (!source.text_number(tag)) return cut_off(source, "$PhysicalNames");
        dimension = tag;
        source.skip_blanks();
        if (source.rest().starts_with('"'))
            dimension = unknown_dimension;  // before version 2.1, files have no dimensions of groups
        else if (!source.text_number(tag))
            return cut_off(source, "$PhysicalNames");
        Group group{static_cast<int>(dimension), magnitude(tag), unquoted(source.line())};
        if (dimension >= unknown_dimension && dimension <= 3 && known.insert({group.dimension, group.reference}).second)
            file.groups.push_back(std::move(group));
    }
    return Done{};
}

Outcome<Done> read_data(Source& source, bool of_nodes, File& file, const Execution& execution) {
    DataHead head;
    if (!read_head(source, head)) return cut_off(source, of_nodes ? "$NodeData" : "$ElementData");
    const RowShape shape{1, 4, head.components};
    if (!source.can_contain_rows(head.rows, shape))
        return source.error(
            "the field " + in_quotes(head.name) + " announces " + std::to_string(head.rows) + " rows, but fewer follow",
            "the file is cut off or damaged");
    Field field{head.name, of_nodes, head.components, Buffer<std::uint64_t>(head.rows),
                Buffer<double>(head.rows * head.components)};
    auto read = source.rows(head.rows, shape, execution, [&](std::size_t i, const auto& row) {
        field.tags[i] = static_cast<std::uint64_t>(row.integer(0));
        for (std::size_t c = 0; c < head.components; ++c) field.values[i * head.components + c] = row.real(c);
    });
    if (!read) return read;
    const auto [known, is_new] = file.field_rows.try_emplace({of_nodes, field.name}, file.fields.size());
    if (is_new) {
        file.fields.push_back(std::move(field));
    } else {
        file.fields[known->second] = std::move(field);
        ++file.skipped_steps;
    }
    return Done{};
}

}  // namespace camber::msh
