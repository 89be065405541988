module;
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

/// The sections that both versions have: names of groups, fields.
namespace camber::msh {

namespace {

/// The text of a line without its quotes.
std::string unquoted(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    if (text.starts_with('"')) text.remove_prefix(1);
    if (text.ends_with('"')) text.remove_suffix(1);
    return std::string(text);
}

/// What stands before the rows: text in either kind of file, which ends with its line.
struct DataHead {
    std::string name;
    std::size_t components = 0, rows = 0;
};

/// take() for each of as many as a count says.
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
            dimension = unknown_dimension;  // of versions before 2.1
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
    if (!source.has_room(head.rows, shape))
        return source.error(
            "the field " + in_quotes(head.name) + " announces " + std::to_string(head.rows) + " rows, more than follow",
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
        ++file.steps_left_out;
    }
    return Done{};
}

}  // namespace camber::msh
