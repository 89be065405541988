module;
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.io;
import camber.app_shell;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

/// The share of the time that making the bytes of a file takes, and making something of them: the rest is the disk's.
constexpr double of_encoding = 0.3, of_decoding = 0.5;

Outcome<Done> write_chunks(const Outcome<Chunks>& chunks, const std::string& path, const Execution& execution) {
    if (!chunks) {
        Error error = chunks.error();
        if (error.where.empty()) error.where = called_output(path);
        return fail(std::move(error));
    }
    const std::vector<std::span<const std::byte>> parts(chunks->begin(), chunks->end());
    return write_file(path, parts, part_of(execution, of_encoding, 1));
}

/// `refuse(beginning)`: the decoder, whose error names a beginning that is of no format.
template <class Format, class Refuse>
StreamBound bound_by(std::span<const Format> formats, const std::string& path, Refuse refuse) {
    return [=](std::span<const std::byte> beginning) -> Outcome<std::size_t> {
        if (format_with_content(formats, beginning)) return memory_limit().bytes / 4;
        if (format_with_ending(formats, path)) return bound_of_text(beginning);
        if (const auto decoded = refuse(beginning); !decoded) return fail(decoded.error());
        return bound_of_text(beginning);
    };
}

/// Standard output has no ending that could tell a format.
template <class Format>
Outcome<Done> check_is_told(std::span<const Format> formats, const std::string& path, std::string_view name) {
    if (path != standard_stream || !name.empty()) return Done{};
    return fail(ErrorKind::usage, "has no ending that tells a format", called_output(path), {},
                "give --format, one of " + listed(names_written(formats)));
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

void tell_renames(const MeshFormat& format, const MeshFields& fields) {
    if (!format.renames) return;
    for (const Notice& notice : format.renames(fields)) tell_note(notice.what);
}

void name_references(AnyMesh& mesh, const run::Groups& groups) {
    std::visit(
        [&](auto& m) {
            if (m.groups.empty()) m.groups = Buffer<Group>(groups.begin(), groups.end());
        },
        mesh);
}

Outcome<Done> write_solution(const SolutionFormat& format, const Solution& solution, const std::string& path,
                             const Execution& execution) {
    return write_chunks(format.encode(solution, part_of(execution, 0, of_encoding)), path, execution);
}

StreamBound bound_of_mesh(const std::string& path) {
    return bound_by(mesh_formats(), path, [path](std::span<const std::byte> beginning) {
        return decode_mesh(beginning, called_input(path), {}, {});
    });
}

Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution) {
    const StreamBound bound = bound_by(solution_formats(), path, [&](std::span<const std::byte> beginning) {
        return decode_solution(beginning, called_input(path), {});
    });
    auto bytes = read_file(path, part_of(execution, 0, 1 - of_decoding), bound);
    if (!bytes) return fail(bytes.error());
    return decode_solution(*bytes, called_input(path), part_of(execution, 1 - of_decoding, 1));
}

Outcome<Done> write_text(const std::string& path, std::string_view text) {
    const std::span<const std::byte> bytes = as_bytes(text);
    return write_file(path, {&bytes, 1});
}

Outcome<const MeshFormat*> format_of_mesh(const std::string& path, std::string_view name, std::string_view source) {
    if (auto told = check_is_told(mesh_formats(), path, name); !told) return fail(told.error());
    return format_to_write_again(mesh_formats(), path, name, source);
}

Outcome<const SolutionFormat*> format_of_solution(const std::string& path, std::string_view name) {
    if (auto told = check_is_told(solution_formats(), path, name); !told) return fail(told.error());
    return format_to_write(solution_formats(), path, name);
}

bool is_solution_output(const std::string& path, std::string_view name) {
    return name.empty() ? is_solution_file(path) : format_with_name(solution_formats(), name) != nullptr;
}

Outcome<Done> check_viewer_output(const std::string& path) {
    if (path.empty()) return Done{};
    const auto format = format_to_write(mesh_formats(), path);
    if (!format) return fail(format.error());
    if (!(*format)->for_viewers)
        return fail(ErrorKind::usage, "the mesh with its fields goes into a format for viewers", path, {},
                    "name a .vtu file");
    return check_writable(path);
}

Outcome<Done> write_for_viewers(AnyMesh mesh, MeshFields fields, const std::optional<Lift>& lift,
                                const std::string& path, const Execution& execution) {
    const auto format = format_to_write(mesh_formats(), path);
    if (!format) return fail(format.error());
    if (lift && (*format)->always_in_space) {
        auto in_space = camber::raised(mesh, *lift, execution);
        if (!in_space) return fail(in_space.error());
        auto of_space = camber::raised(fields, execution);
        if (!of_space) return fail(of_space.error());
        mesh = std::move(*in_space);
        fields = std::move(*of_space);
    }
    tell_renames(**format, fields);
    return write_mesh(**format, mesh, fields, EncodeOptions{}, path, execution);
}

}  // namespace camber::app
