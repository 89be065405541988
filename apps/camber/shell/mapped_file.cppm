module;
#include <cstddef>
#include <span>
#include <string>
export module camber.app_shell:mapped_file;
import camber.core;

export namespace camber::app {

/// A plain file's bytes, of which the system brings those into memory that are looked at. Who cuts the file short
/// meanwhile ends the program. Errors: input, with the system's reason (a pipe cannot be read so).
[[nodiscard]] Outcome<Column<std::byte>> map_file(const std::string& path);

/// Lets a mapped file's bytes leave this process's memory; those that are looked at again come back.
void give_back(std::span<const std::byte> of_mapped_file);

}  // namespace camber::app
