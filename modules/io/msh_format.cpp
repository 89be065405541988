module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
module camber.io;
import camber.core;

namespace camber {

namespace msh {

namespace {

constexpr std::string_view comments = "$Comments", end_of_comments = "$EndComments";

}  // namespace

std::optional<FormatLine> find_format(std::span<const std::byte> bytes) {
    Source source(bytes, {});
    if (source.rest().starts_with("\xEF\xBB\xBF")) source.go_to(3);
    for (source.skip_blanks(); source.rest().starts_with(comments); source.skip_blanks()) {
        const std::size_t end = source.rest().find(end_of_comments);
        if (end == std::string_view::npos) return std::nullopt;
        source.go_to(source.at() + end + end_of_comments.size());
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
    // A number, which some write with more digits: 2.200000.
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

/// The last line of a section; those of version 1 shout.
std::string last_line(std::string_view name) {
    const bool shouts = name == "NOD" || name == "ELM";
    return (shouts ? "$END" : "$End") + std::string(name);
}

}  // namespace

Outcome<std::string> next_section(Source& source) {
    source.skip_blanks();
    if (source.left() == 0) return std::string();
    if (!source.rest().starts_with('$')) return source.error("here should be a section ($…)", "the file is damaged");
    std::string_view name = source.line().substr(1);
    while (name.ends_with(' ') || name.ends_with('\t')) name.remove_suffix(1);
    constexpr std::size_t longest = 64;
    if (name.empty() || name.size() > longest) return source.error("the line before has no section's name");
    return std::string(name);
}

Outcome<Done> end_section(Source& source, std::string_view name) {
    source.skip_blanks();
    const std::string end = last_line(name);
    if (source.left() == 0) return source.error("the file ends before " + end, "it seems to be cut off");
    if (!source.rest().starts_with(end)) return source.error("here should be " + end, "the file is damaged");
    source.line();
    return Done{};
}

Outcome<Done> skip_section(Source& source, std::string_view name) {
    const std::string end = last_line(name);
    const std::size_t found = source.rest().find(end);
    if (found == std::string_view::npos) return source.error("the section has no " + end, "it seems to be cut off");
    source.go_to(source.at() + found);
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

}  // namespace camber
