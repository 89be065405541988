module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::msh {

namespace {

std::optional<FieldKind> kind_of(std::size_t components) {
    if (components == 1) return FieldKind::scalar;
    if (components == 3) return FieldKind::vector;
    if (components == 9) return FieldKind::full_tensor;
    return std::nullopt;
}

/// The values by the rows that the tags are of; none where a row has no value.
std::optional<Buffer<double>> by_row(const Field& field, const TagIndex& index, std::size_t rows) {
    Buffer<double> values(rows * field.components);
    Buffer<std::uint8_t> seen(rows, std::uint8_t{0});
    for (std::size_t i = 0; i < field.tags.size(); ++i) {
        const std::uint32_t row = index.find(field.tags[i]);
        if (row == no_row) continue;
        seen[row] = 1;
        std::copy_n(field.values.data() + i * field.components, field.components,
                    values.data() + row * field.components);
    }
    if (std::find(seen.begin(), seen.end(), 0) != seen.end()) return std::nullopt;
    return values;
}

}  // namespace

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
    if (file.steps_left_out > 0)
        notices.push_back({"fields have several time steps: the last of each was taken, " +
                           std::to_string(file.steps_left_out) + " were left out"});
    return MeshFields(std::move(fields));
}

}  // namespace camber::msh
