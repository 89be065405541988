module;
#include <cstddef>
#include <string>
export module camber.app_shell:mapped_file;
import camber.core;

export namespace camber::app {

/// A plain file's bytes, of which the system brings those into memory that are looked at. Who cuts the file short
/// meanwhile ends the program. Errors: input, with the system's reason (a pipe cannot be read so).
[[nodiscard]] Outcome<Column<std::byte>> map_file(const std::string& path);

}  // namespace camber::app
