module;
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
export module camber.app_shell:files;
import camber.core;

export namespace camber::app {

/// What stands for standard input and standard output in place of a file's name.
inline constexpr std::string_view standard_stream = "-";
/// The path as one says it: "standard input", "standard output".
[[nodiscard]] std::string called_input(const std::string& path);
[[nodiscard]] std::string called_output(const std::string& path);

/// Decides by the first bytes of a stream (a pipe, a device), at most `beginning_of_stream`, how many may follow: a
/// stream has no size, and may have no end. Errors: those of a stream that is not read at all.
using StreamBound = std::function<Outcome<std::size_t>(std::span<const std::byte> beginning)>;
inline constexpr std::size_t beginning_of_stream = std::size_t{1} << 16U;

/// The bound of texts: configs, reports, tables.
[[nodiscard]] Outcome<std::size_t> bound_of_text(std::span<const std::byte> beginning);

/// The whole file (or pipe, or standard input). A plain file is read whatever its size. Errors: input, with the
/// system's reason, or a stream beyond its bound; memory; stopped, also while a pipe is silent.
[[nodiscard]] Outcome<Buffer<std::byte>> read_file(const std::string& path, const Execution& execution = {},
                                                   const StreamBound& bound = bound_of_text);

[[nodiscard]] inline std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
[[nodiscard]] inline std::span<const std::byte> as_bytes(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

/// Writes the chunks one after the other: all of them or nothing. The file appears (or replaces the old one, keeping
/// its permissions) only when complete and on disk; until then it has no name, so that no death of the process leaves
/// a part of it. Where the target is no plain file (a pipe, standard output) it is written to as it is.
/// Errors: write, with the system's reason; stopped, as long as nothing has its name yet.
[[nodiscard]] Outcome<Done> write_file(const std::string& path, std::span<const std::span<const std::byte>> chunks,
                                       const Execution& execution = {});

/// Whether a file could be written there, asked before the work begins: its folder exists and takes files. Errors:
/// write, with the command that makes a folder that is not there.
[[nodiscard]] Outcome<Done> check_writable(const std::string& path);

/// The same of a folder for files, which `make_folder` makes where its own is there.
[[nodiscard]] Outcome<Done> check_folder(const std::string& folder);
[[nodiscard]] Outcome<Done> make_folder(const std::string& folder);

}  // namespace camber::app
