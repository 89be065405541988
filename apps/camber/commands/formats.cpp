module;
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import :formats;

namespace camber::app {

namespace {

GmfOptions encoding(bool binary) { return GmfOptions{.encoding = binary ? GmfEncoding::binary : GmfEncoding::ascii}; }

Outcome<Done> write_chunks(const Outcome<Chunks>& chunks, const std::string& path, const Execution& execution) {
    if (!chunks) return fail(chunks.error());
    const std::vector<std::span<const std::byte>> parts(chunks->begin(), chunks->end());
    return write_file(path, parts, execution.stop);
}

}  // namespace

Outcome<MeshFormat> mesh_format_of(std::string_view path) {
    if (path.ends_with(".meshb")) return MeshFormat::gmf_binary;
    if (path.ends_with(".mesh")) return MeshFormat::gmf_ascii;
    if (path.ends_with(".vtu")) return MeshFormat::vtu;
    return fail(ErrorKind::usage, "no format known for this ending", std::string(path), {},
                "use .mesh, .meshb or .vtu");
}

bool is_solution_file(std::string_view path) { return path.ends_with(".sol") || path.ends_with(".solb"); }

Outcome<Done> write_mesh(const AnyMesh& mesh, const MeshFields& fields, VtuOptions options, const std::string& path,
                         const Execution& execution) {
    const auto format = mesh_format_of(path);
    if (!format) return fail(format.error());
    return std::visit(
        [&](const auto& m) {
            if (*format == MeshFormat::vtu)
                return write_chunks(encode_vtu(m, fields, options, execution), path, execution);
            return write_chunks(encode_gmf_mesh(m, encoding(*format == MeshFormat::gmf_binary), execution), path,
                                execution);
        },
        mesh);
}

Outcome<Done> write_solution(const Solution& solution, const std::string& path, const Execution& execution) {
    return write_chunks(encode_gmf_solution(solution, encoding(path.ends_with(".solb")), execution), path, execution);
}

Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution) {
    auto bytes = read_file(path, execution.stop);
    if (!bytes) return fail(bytes.error());
    return decode_gmf_solution(*bytes, path, execution);
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

std::vector<Notice> losses(const AnyMesh& mesh, std::string_view path) {
    if (!path.ends_with(".vtu")) return {};
    return std::visit([](const auto& m) { return not_in_vtu(m); }, mesh);
}

VtuOptions vtu_options(config::VtuCells cells) {
    return {cells == config::VtuCells::lagrange ? camber::VtuCells::lagrange : camber::VtuCells::quadratic};
}

}  // namespace camber::app
