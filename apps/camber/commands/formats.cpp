module;
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.io;
import camber.run;
import :formats;

namespace camber::app {

namespace {

/// The share of the time that making the bytes of a file takes, and making something of them: the rest is the disk's.
constexpr double of_encoding = 0.3, of_decoding = 0.5;

Outcome<Done> write_chunks(const Outcome<Chunks>& chunks, const std::string& path, const Execution& execution) {
    if (!chunks) return fail(chunks.error());
    const std::vector<std::span<const std::byte>> parts(chunks->begin(), chunks->end());
    return write_file(path, parts, part_of(execution, of_encoding, 1));
}

}  // namespace

bool names_a_file(const std::string& text) {
    std::error_code none;
    return is_solution_file(text) || format_with_ending(mesh_formats(), text) != nullptr ||
           std::filesystem::exists(text, none);
}

bool is_solution_file(std::string_view path) { return format_with_ending(solution_formats(), path) != nullptr; }

Outcome<Done> write_mesh(const MeshFormat& format, const AnyMesh& mesh, const MeshFields& fields, EncodeOptions options,
                         const std::string& path, const Execution& execution) {
    return write_chunks(format.encode(mesh, fields, options, part_of(execution, 0, of_encoding)), path, execution);
}

Outcome<Done> write_solution(const SolutionFormat& format, const Solution& solution, const std::string& path,
                             const Execution& execution) {
    return write_chunks(format.encode(solution, part_of(execution, 0, of_encoding)), path, execution);
}

Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution) {
    auto bytes = read_file(path, part_of(execution, 0, 1 - of_decoding));
    if (!bytes) return fail(bytes.error());
    return decode_solution(*bytes, path, part_of(execution, 1 - of_decoding, 1));
}

Outcome<Done> write_text(const std::string& path, std::string_view text) {
    const std::span<const std::byte> bytes = as_bytes(text);
    return write_file(path, {&bytes, 1});
}

Outcome<Done> make_folder_of(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
        return fail(ErrorKind::write, "the folder cannot be made: " + error.message(), folder.string(), {},
                    "take another place");
    return Done{};
}

}  // namespace camber::app
