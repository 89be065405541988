module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
module camber.io:msh_format;
import camber.core;
import :msh;
import :msh_source;

namespace camber::msh {

/// The versions that have the same sections.
enum class Generation : std::uint8_t { v1, v2, v40, v41 };

/// The first line of $MeshFormat.
struct FormatLine {
    std::string version;  ///< as it is written: "4.1"; "1" of files that begin with $NOD
    bool binary = false;
    long data_size = 0;
    std::size_t end = 0;  ///< of the line, in the file
};

/// None: this is no MSH file. What comes before it must be comments.
[[nodiscard]] std::optional<FormatLine> find_format(std::span<const std::byte> bytes);

/// What sections a version has; none: it is not read.
[[nodiscard]] std::optional<Generation> generation(const FormatLine& format);

/// The section's first line in front of which the source is, without the $; goes behind it. Empty at the end. Errors:
/// input (something else).
[[nodiscard]] Outcome<std::string> next_section(Source& source);
/// Goes behind the section's last line. Errors: input (something else is there).
[[nodiscard]] Outcome<Done> end_section(Source& source, std::string_view name);
/// Goes behind the last line of a section that is not read. Errors: input (none).
[[nodiscard]] Outcome<Done> skip_section(Source& source, std::string_view name);

}  // namespace camber::msh
