module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace {

template <GmfEncoding encoding>
Outcome<Chunks> encode_gmf(const AnyMesh& mesh, const MeshFields&, EncodeOptions, const Execution& execution) {
    return std::visit([&](const auto& m) { return encode_gmf_mesh(m, {encoding}, execution); }, mesh);
}
template <GmfEncoding encoding>
Outcome<Chunks> encode_gmf_fields(const Solution& solution, const Execution& execution) {
    return encode_gmf_solution(solution, {encoding}, execution);
}
std::vector<Notice> gmf_losses(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return not_in_gmf(m); }, mesh);
}

Outcome<Chunks> encode_vtu_mesh(const AnyMesh& mesh, const MeshFields& fields, EncodeOptions options,
                                const Execution& execution) {
    return std::visit([&](const auto& m) { return encode_vtu(m, fields, {options.cells}, execution); }, mesh);
}
std::vector<Notice> vtu_losses(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return not_in_vtu(m); }, mesh);
}

Outcome<Chunks> encode_cgns_mesh(const AnyMesh& mesh, const MeshFields& fields, EncodeOptions,
                                 const Execution& execution) {
    return std::visit([&](const auto& m) { return encode_cgns(m, fields, execution); }, mesh);
}
std::vector<Notice> cgns_losses(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return not_in_cgns(m); }, mesh);
}

template <MshVersion version, MshEncoding encoding>
bool is_msh_of(std::span<const std::byte> bytes) {
    return is_msh(bytes, {version, encoding});
}
template <MshVersion version, MshEncoding encoding>
Outcome<Chunks> encode_msh_mesh(const AnyMesh& mesh, const MeshFields& fields, EncodeOptions,
                                const Execution& execution) {
    return std::visit([&](const auto& m) { return encode_msh(m, fields, {version, encoding}, execution); }, mesh);
}
template <MshVersion version>
std::vector<Notice> msh_losses(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return not_in_msh(m, version); }, mesh);
}
/// One of Gmsh's four formats.
template <MshVersion version, MshEncoding encoding>
MeshFormat msh_format(std::string_view name, std::string_view what, std::vector<std::string_view> endings) {
    MeshFormat format{{name, what, std::move(endings), is_msh_of<version, encoding>},
                      decode_msh,
                      encode_msh_mesh<version, encoding>,
                      msh_losses<version>};
    format.holds_fields = true;
    format.always_in_space = true;
    return format;
}

}  // namespace

std::span<const MeshFormat> mesh_formats() {
    static const std::vector<MeshFormat> formats{
        {{"gmf-ascii", "GMF as text", {".mesh"}, is_gmf_ascii},
         decode_gmf_mesh,
         encode_gmf<GmfEncoding::ascii>,
         gmf_losses},
        {{"gmf-binary", "GMF in binary", {".meshb"}, is_gmf_binary},
         decode_gmf_mesh,
         encode_gmf<GmfEncoding::binary>,
         gmf_losses},
        msh_format<MshVersion::v4, MshEncoding::binary>("msh", "Gmsh MSH 4.1 in binary", {".msh"}),
        msh_format<MshVersion::v4, MshEncoding::ascii>("msh-ascii", "Gmsh MSH 4.1 as text", {}),
        msh_format<MshVersion::v2, MshEncoding::binary>("msh2", "Gmsh MSH 2.2 in binary", {}),
        msh_format<MshVersion::v2, MshEncoding::ascii>("msh2-ascii", "Gmsh MSH 2.2 as text", {}),
        {{"vtu", "VTU (ParaView)", {".vtu"}, is_vtu},
         decode_vtu,
         encode_vtu_mesh,
         vtu_losses,
         true,
         nullptr,
         true,
         true},
        {{"cgns", "CGNS", {".cgns"}, is_cgns}, decode_cgns, encode_cgns_mesh, cgns_losses, true, is_in_cgns},
    };
    return formats;
}

std::span<const SolutionFormat> solution_formats() {
    static const std::vector<SolutionFormat> formats{
        {{"gmf-ascii", "GMF as text", {".sol"}, is_gmf_ascii},
         decode_gmf_solution,
         encode_gmf_fields<GmfEncoding::ascii>},
        {{"gmf-binary", "GMF in binary", {".solb"}, is_gmf_binary},
         decode_gmf_solution,
         encode_gmf_fields<GmfEncoding::binary>},
    };
    return formats;
}

std::string listed(std::span<const std::string_view> words, std::string_view before_last, std::string_view between) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (i > 0) text += i + 1 < words.size() ? between : before_last;
        text += words[i];
    }
    return text;
}

Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path, const Execution& execution) {
    const auto format = format_to_read(mesh_formats(), bytes, path);
    if (!format) return fail(format.error());
    auto decoded = (*format)->decode(bytes, path, execution);
    if (decoded) decoded->always_in_space = (*format)->always_in_space;
    return decoded;
}

Outcome<DecodedSolution> decode_solution(std::span<const std::byte> bytes, std::string_view path,
                                         const Execution& execution) {
    const auto format = format_to_read(solution_formats(), bytes, path);
    if (!format) return fail(format.error());
    return (*format)->decode(bytes, path, execution);
}

}  // namespace camber
