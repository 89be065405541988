module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.cad;
import camber.app_shell;
import camber.config;
import camber.surface;
import :cad_reader;

namespace camber::app {

namespace {

/// The word that makes a process the reader; then the file, seconds and bytes.
constexpr std::string_view reader = "--read-cad-file-for-parent";

ChildLimits limits_of(const config::Cad& cad) {
    constexpr double seconds = 10, seconds_a_megabyte = 1, megabyte = 1e6, gigabyte = 1e9, memory_a_byte = 50;
    std::error_code missing;
    const auto found = std::filesystem::file_size(cad.file.path, missing);
    const double size = missing ? 0 : static_cast<double>(found);
    const double memory = cad.memory > 0 ? cad.memory * megabyte : gigabyte + memory_a_byte * size;
    return {cad.seconds > 0 ? cad.seconds : seconds + seconds_a_megabyte * size / megabyte,
            static_cast<std::size_t>(memory)};
}

/// Errors: a pipe or a device, which may have no end. A file that is not there is for the reader to tell.
Outcome<Done> check_plain(const std::string& path) {
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    if (!std::filesystem::is_other(status)) return Done{};
    return fail(ErrorKind::input, "is no plain file, as a CAD model must be", path, {}, "copy it into one");
}

/// An error as bytes: 'E', its kind, and its parts, each ended by a zero byte. A model's bytes begin with 'M'.
std::string as_bytes_of(const Error& error) {
    std::string bytes = "E" + std::to_string(static_cast<int>(error.kind));
    const std::string kind = error.entity ? error.entity->kind : std::string();
    const std::string number = error.entity ? std::to_string(error.entity->number) : "0";
    for (const std::string& part : {std::string(), error.what, error.where, error.remedy, kind, number})
        bytes += part + '\0';
    return bytes;
}
Error error_of(std::string_view bytes) {
    std::array<std::string, 6> parts;
    bytes.remove_prefix(1);
    for (std::string& part : parts) {
        const std::size_t end = std::min(bytes.find('\0'), bytes.size());
        part = bytes.substr(0, end);
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
    }
    const auto& [kind, what, where, remedy, entity, number] = parts;
    Error error{static_cast<ErrorKind>(std::stoi(kind)), what, where, {}, remedy};
    if (!entity.empty()) error.entity = Entity{entity, std::stoull(number)};
    return error;
}

/// The file's model, tried: what its faces and edges do to whom asks them is seen here, and not in the parent.
Outcome<std::string> read_and_tried(const std::string& path) {
    constexpr std::size_t tries = 1000;
    const auto model = read_cad(path, {});
    if (!model) return fail(model.error());
    if (const auto samples = samples_of<3>(*model, tries, {.threads = 1}); !samples) return fail(samples.error());
    return packed_cad(*model);
}

Error of_end(const ChildResult& result, const config::Cad& cad, const ChildLimits& limits) {
    if (result.end == ChildEnd::out_of_time)
        return {ErrorKind::input,
                fmt::format("reading it takes more than {:.3g} s", limits.seconds),
                cad.file.path,
                {},
                "export the model again; if it is right, allow more: --cad-seconds, or geometry/cad/seconds"};
    return {ErrorKind::input,
            fmt::format("OpenCASCADE crashes on it ({}): the file is damaged", result.how),
            cad.file.path,
            {},
            "export the model again"};
}

Error out_of_memory(const config::Cad& cad, const ChildLimits& limits) {
    return {ErrorKind::input,
            fmt::format("reading it takes more than {:.3g} MB of memory", static_cast<double>(limits.bytes) / 1e6),
            cad.file.path,
            {},
            "export the model again; if it is right, allow more: --cad-memory, or geometry/cad/memory"};
}

}  // namespace

std::optional<int> cad_reader(std::span<const char* const> arguments) {
    if (arguments.size() != 5 || arguments[1] != reader) return std::nullopt;
    keep_limits({std::stod(arguments[3]), static_cast<std::size_t>(std::stod(arguments[4]))});
    const auto bytes = read_and_tried(arguments[2]);
    return hand_over(bytes ? "M" + *bytes : as_bytes_of(bytes.error())) ? 0 : 1;
}

Outcome<CadModel> read_cad_apart(const config::Cad& cad, const Execution& execution) {
    return guarded([&]() -> Outcome<CadModel> {
        if (auto plain = check_plain(cad.file.path); !plain) return fail(plain.error());
        if (!can_start_itself()) return read_cad(cad.file.path, {cad.unit});
        const ChildLimits limits = limits_of(cad);
        const auto result = run_self(
            {std::string(reader), cad.file.path, fmt::format("{}", limits.seconds), fmt::format("{}", limits.bytes)},
            limits, execution);
        if (!result) return fail(result.error());
        if (result->end != ChildEnd::done || result->bytes.empty()) return fail(of_end(*result, cad, limits));
        if (result->bytes.front() == 'E') {
            Error error = error_of(result->bytes);
            return fail(error.kind == ErrorKind::memory ? out_of_memory(cad, limits) : std::move(error));
        }
        auto model = unpacked_cad(result->bytes.substr(1), {cad.unit});
        if (!model && model.error().where.empty()) {
            Error error = model.error();
            error.where = cad.file.path;
            return fail(std::move(error));
        }
        return model;
    });
}

}  // namespace camber::app
