// Reads MSH files: format line and sections.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;

namespace camber {

namespace msh {

namespace {

constexpr std::string_view comments = "$Comments", end_of_comments = "$EndComments";

}  // namespace

std::optional<FormatLine> find_format(std::span<const std::byte> bytes) {
    Source source(bytes, {});
    if (source.rest().starts_with("\xEF\xBB\xBF")) source.seek(3);
    for (source.skip_blanks(); source.rest().starts_with(comments); source.skip_blanks()) {
        const std::size_t end = source.rest().find(end_of_comments);
        if (end == std::string_view::npos) return std::nullopt;
        source.seek(source.at() + end + end_of_comments.size());
    }
    const std::string_view first = source.line();
    if (first == "$NOD") {
        const auto line_begin = static_cast<std::size_t>(first.data() - reinterpret_cast<const char*>(bytes.data()));
        return FormatLine{.version = "1", .data_size = sizeof(double), .end = line_begin};
    }
    if (!first.starts_with("$MeshFormat")) return std::nullopt;
    const std::string_view text = source.line();
    Words words{text.data(), text.data() + text.size()};
    FormatLine line;
    line.version = words.next();
    std::int64_t kind = 0, size = 0;
    if (line.version.empty() || !read_number(words, kind) || !read_number(words, size)) return std::nullopt;
    line.binary = kind == 1;
    line.data_size = static_cast<long>(size);
    line.end = source.at();
    return line;
}

std::optional<Generation> generation(const FormatLine& format) {
    // The version is compared as a number, because it may have more digits, as in 2.200000.
    Words words{format.version.data(), format.version.data() + format.version.size()};
    double version = 0;
    if (!read_number(words, version)) return std::nullopt;
    if (version == 4.1) return Generation::v41;
    if (version == 4) return Generation::v40;
    if (version == 1) return Generation::v1;
    for (const double of_2 : {2.0, 2.1, 2.2})
        if (version == of_2) return Generation::v2;
    return std::nullopt;
}

namespace {

std::string last_line(std::string_view name) {
    const bool is_upper_case = name == "NOD" || name == "ELM";
    return (is_upper_case ? "$END" : "$End") + std::string(name);
}

}  // namespace

Outcome<std::string> next_section(Source& source) {
    source.skip_blanks();
    if (source.left() == 0) return std::string();
    if (!source.rest().starts_with('$')) return source.error("a section ($…) is missing here", "the file is damaged");
    std::string_view name = source.line().substr(1);
    while (name.ends_with(' ') || name.ends_with('\t')) name.remove_suffix(1);
    constexpr std::size_t longest = 64;
    if (name.empty() || name.size() > longest) return source.error("the previous line has no section name");
    return std::string(name);
}

Outcome<Done> end_section(Source& source, std::string_view name) {
    source.skip_blanks();
    const std::string end = last_line(name);
    if (source.left() == 0) return source.error("the file ends before " + end, "it seems to be cut off");
    if (!source.rest().starts_with(end)) return source.error("missing here: " + end, "the file is damaged");
    source.line();
    return Done{};
}

Outcome<Done> skip_section(Source& source, std::string_view name) {
    const std::string end = last_line(name);
    const std::size_t found = source.rest().find(end);
    if (found == std::string_view::npos) return source.error("the section has no " + end, "it seems to be cut off");
    source.seek(source.at() + found);
    source.line();
    return Done{};
}

}  // namespace msh

bool is_msh(std::span<const std::byte> bytes, MshOptions kind) {
    const auto line = msh::find_format(bytes);
    if (!line || line->binary != (kind.encoding == MshEncoding::binary)) return false;
    const auto generation = msh::generation(*line);
    const bool is_old = generation == msh::Generation::v1 || generation == msh::Generation::v2;
    return is_old == (kind.version == MshVersion::v2);
}

namespace msh {

namespace {

constexpr const char* remedy = "gmsh FILE -save -format msh41 -o NEW.msh";

Outcome<Done> read_byte_order(Source& source) {
    std::int64_t one = 0;
    for (const bool swapped : {false, true}) {
        Source from = source;
        from.swapped = swapped;
        if (!from.integer(one) || one != 1) continue;
        source = from;
        return Done{};
    }
    return source.error("the number 1 of $MeshFormat in a binary file is missing here, in both byte orders",
                        "the file is damaged");
}

Outcome<Generation> begin(Source& source, std::span<const std::byte> bytes) {
    const auto line = find_format(bytes);
    if (!line) return source.error("this is not an MSH file: it does not begin with $MeshFormat", "give a .msh file");
    const auto version = generation(*line);
    if (!version)
        return fail(ErrorKind::unsupported, "MSH version " + line->version + " is not 1, 2 or 4", source.place(), {},
                    remedy);
    source.seek(line->end);
    source.binary = line->binary;
    if (line->data_size != sizeof(double))
        return fail(ErrorKind::unsupported,
                    "numbers of " + std::to_string(line->data_size) + " bytes are not supported; MSH files have 8",
                    source.place(), {}, remedy);
    if (*version == Generation::v1) return *version;
    if (source.binary)
        if (auto read = read_byte_order(source); !read) return fail(std::move(read.error()));
    if (auto ended = end_section(source, "MeshFormat"); !ended) return fail(std::move(ended.error()));
    return *version;
}

Outcome<Done> read_nodes(Source& source, Generation version, bool parametric, Nodes& nodes,
                         const Execution& execution) {
    if (nodes.listed) return source.error("the nodes are listed twice");
    nodes.listed = true;
    auto read = version == Generation::v40 || version == Generation::v41
                    ? read_nodes_4(source, version, nodes, execution)
                    : read_nodes_2(source, parametric, nodes, execution);
    return read.and_then([&](Done) { return order_nodes(source, nodes); });
}

Outcome<Done> read_elements(Source& source, Generation version, File& file, const Execution& execution) {
    if (file.elements_listed) return source.error("the elements are listed twice");
    if (!file.nodes.listed) return source.error("the elements come before the nodes", remedy);
    file.elements_listed = true;
    switch (version) {
        case Generation::v1: return read_elements_1(source, file);
        case Generation::v2: return read_elements_2(source, file, execution);
        case Generation::v40:
        case Generation::v41: break;
    }
    return read_elements_4(source, version, file, execution);
}

Outcome<bool> read_section(Source& source, Generation version, std::string_view name, File& file,
                           const Execution& execution) {
    const auto yes = [](Done) { return true; };
    if (name == "PhysicalNames") return read_names(source, file).map(yes);
    if (name == "NodeData" || name == "ElementData")
        return read_data(source, name == "NodeData", file, execution).map(yes);
    if (name == "Elements" || name == "ELM") return read_elements(source, version, file, execution).map(yes);
    if (name == "Nodes" || name == "NOD" || (name == "ParametricNodes" && version == Generation::v2))
        return read_nodes(source, version, name == "ParametricNodes", file.nodes, execution).map(yes);
    if (version == Generation::v40 && name == "PartitionedEntities")
        return fail(ErrorKind::unsupported, "is partitioned, which Camber reads from version 4.1, but not from 4.0",
                    source.place(), {}, remedy);
    if ((version == Generation::v40 || version == Generation::v41) &&
        (name == "Entities" || name == "PartitionedEntities"))
        return read_entities_4(source, name == "PartitionedEntities", version, file).map(yes);
    return false;
}

UnsupportedItems unsupported_items_of(const File& file) {
    UnsupportedItems refused;
    for (const auto& [type, count] : file.refused) {
        const ElementType* const known = find_type(type);
        refused.count(known ? name_of(*known) : "elements of type " + std::to_string(type), count);
    }
    return refused;
}

}  // namespace

Outcome<Done> check_positive(const Source& source, std::size_t begin, RowShape shape,
                             std::span<const std::uint64_t> tags) {
    for (std::size_t i = 0; i < tags.size(); ++i)
        if (const auto tag = static_cast<std::int64_t>(tags[i]); tag < 1)
            return source.at_row(begin, i, shape)
                .error("$Nodes: " + std::to_string(tag) + " is the tag of a node, but must be positive",
                       "number the nodes from 1");
    return Done{};
}

Outcome<Done> order_nodes(const Source& source, Nodes& nodes) {
    const Buffer<std::uint32_t> rows = rows_by_tag(nodes.tags);
    if (!rows.empty()) {
        Buffer<std::uint64_t> tags(rows.size());
        Buffer<Vec<3>> points(rows.size());
        nodes.vertex_of.resize(rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            tags[i] = nodes.tags[rows[i]];
            points[i] = nodes.points[rows[i]];
            nodes.vertex_of[rows[i]] = static_cast<std::uint32_t>(i);
        }
        nodes.tags = std::move(tags);
        nodes.points = std::move(points);
    }
    const auto twice = std::adjacent_find(nodes.tags.begin(), nodes.tags.end());
    if (twice != nodes.tags.end())
        return fail(ErrorKind::input, "is listed twice", source.place(), Entity{"node", *twice},
                    "the file is damaged, or was joined from two files");
    nodes.index = TagIndex(nodes.tags, {});
    return Done{};
}

Outcome<File> read_file(Source& source, Generation version, const Execution& execution) {
    File file;
    for (;;) {
        source.skip_blanks();
        if (file.nodes.listed && file.elements_listed && !source.rest().starts_with('$')) {
            file.trailing_bytes = source.left();
            break;
        }
        const auto name = next_section(source);
        if (!name) return fail(name.error());
        if (name->empty()) break;
        auto read = read_section(source, version, *name, file, execution);
        if (!read) return fail(std::move(read.error()));
        if (!*read && *name != "Comments") ++file.skipped[*name];
        auto ended = *read ? end_section(source, *name) : skip_section(source, *name);
        if (!ended) return fail(std::move(ended.error()));
    }
    if (!file.nodes.listed || !file.elements_listed)
        return source.error(std::string("the file has no ") + (file.nodes.listed ? "$Elements" : "$Nodes"),
                            "it seems to be cut off");
    return file;
}

}  // namespace msh

Outcome<DecodedMesh> decode_msh(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        msh::Source source(bytes, name);
        const auto version = msh::begin(source, bytes);
        if (!version) return fail(version.error());
        auto file = msh::read_file(source, *version, execution);
        if (!file) return fail(std::move(file.error()));
        const UnsupportedItems refused = msh::unsupported_items_of(*file);
        if (auto supported = refused.verdict(std::string(name), options.unsupported_cells); !supported)
            return fail(std::move(supported.error()));
        auto decoded = msh::mesh_of(std::move(*file), std::string(name), execution);
        if (decoded) decoded->unsupported_cells = refused.counts();
        return decoded;
    });
}

}  // namespace camber
