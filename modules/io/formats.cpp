// The table of formats, and commands that convert files of other formats.
module;
#include <algorithm>
#include <array>
#include <cctype>
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

using Decoder = decltype(MeshFormat::decode);

template <Decoder decode>
Outcome<DecodedMesh> quiet(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                           const Execution& execution) {
    return decode(bytes, name, options, without_progress(execution));
}

template <auto encode>
Outcome<Chunks> encoded(const AnyMesh& mesh, const MeshFields& fields, EncodeOptions options,
                        const Execution& execution) {
    return std::visit([&](const auto& m) { return encode(m, fields, options, execution); }, mesh);
}
template <auto not_in>
std::vector<Notice> losses_of(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return not_in(m); }, mesh);
}

template <GmfEncoding encoding>
MeshFormat gmf_row(FormatName name) {
    MeshFormat format{std::move(name)};
    format.decode = decode_gmf_mesh;
    format.encode = encoded<[](const auto& mesh, const MeshFields&, EncodeOptions, const Execution& execution) {
        return encode_gmf_mesh(mesh, {encoding}, execution);
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_gmf(mesh); }>;
    return format;
}

template <MshVersion version, MshEncoding encoding>
MeshFormat msh_row(std::string_view name, std::string_view what, std::vector<std::string_view> endings) {
    constexpr std::string_view ending = ".msh";
    MeshFormat format{{.name = name,
                       .what = what,
                       .endings = std::move(endings),
                       .shared_extension = ending,
                       .sniff = [](std::span<const std::byte> bytes) { return is_msh(bytes, {version, encoding}); }}};
    format.decode = quiet<decode_msh>;
    format.encode = encoded<[](const auto& mesh, const MeshFields& fields, EncodeOptions, const Execution& execution) {
        return encode_msh(mesh, fields, {version, encoding}, without_progress(execution));
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_msh(mesh, version); }>;
    format.renames = [](const MeshFields& fields) { return renamed_fields(fields, msh::field_names(), "MSH"); };
    format.has_fields = true;
    format.is_always_3d = true;
    return format;
}

MeshFormat vtu_row() {
    MeshFormat format{{"vtu", "VTU (ParaView)", {".vtu"}, {}, is_vtu}};
    format.decode = quiet<decode_vtu>;
    format.encode =
        encoded<[](const auto& mesh, const MeshFields& fields, EncodeOptions options, const Execution& execution) {
            return encode_vtu(mesh, fields, {options.cells}, without_progress(execution));
        }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_vtu(mesh); }>;
    format.renames = [](const MeshFields& fields) { return renamed_fields(fields, vtu::field_names(), "VTU"); };
    format.has_fields = true;
    format.chooses_cells = true;
    format.for_viewers = true;
    format.is_always_3d = true;
    return format;
}

MeshFormat pvtu_row() {
    MeshFormat format{{"pvtu", "PVTU (pieces in VTU files)", {".pvtu"}, {}, is_pvtu}};
    format.decode = quiet<decode_pvtu>;
    format.is_always_3d = true;
    return format;
}

template <VtkEncoding encoding>
MeshFormat vtk_row(std::string_view name, std::string_view what, std::vector<std::string_view> endings) {
    MeshFormat format{{name, what, std::move(endings), ".vtk",
                       [](std::span<const std::byte> bytes) { return is_vtk(bytes, encoding); }}};
    format.decode = quiet<decode_vtk>;
    format.encode = encoded<[](const auto& mesh, const MeshFields& fields, EncodeOptions, const Execution& execution) {
        return encode_vtk(mesh, fields, encoding, without_progress(execution));
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_vtk(mesh); }>;
    format.renames = [](const MeshFields& fields) { return renamed_fields(fields, vtk::field_names(), "VTK"); };
    format.has_fields = true;
    format.is_always_3d = true;
    return format;
}

template <StlEncoding encoding>
MeshFormat stl_row(std::string_view name, std::string_view what, std::vector<std::string_view> endings) {
    MeshFormat format{
        {name, what, std::move(endings), {}, [](std::span<const std::byte> bytes) { return is_stl(bytes, encoding); }}};
    format.decode = quiet<decode_stl>;
    format.encode = encoded<[](const auto& mesh, const MeshFields&, EncodeOptions, const Execution& execution) {
        return encode_stl(mesh, encoding, without_progress(execution));
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_stl(mesh, encoding); }>;
    format.is_always_3d = true;
    return format;
}

MeshFormat xdmf_row() {
    MeshFormat format{{"xdmf", "XDMF 3 as text", {".xdmf", ".xmf"}, {}, is_xdmf}};
    format.encode = encoded<[](const auto& mesh, const MeshFields& fields, EncodeOptions, const Execution& execution) {
        return encode_xdmf(mesh, fields, without_progress(execution));
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_xdmf(mesh); }>;
    format.renames = [](const MeshFields& fields) { return renamed_fields(fields, vtu::field_names(), "XDMF"); };
    format.has_fields = true;
    format.is_always_3d = true;
    return format;
}

MeshFormat mfem_row() {
    MeshFormat format{{"mfem", "MFEM mesh v1.0", {".mfem"}, {}, is_mfem}};
    format.decode = quiet<decode_mfem>;
    format.encode = encoded<[](const auto& mesh, const MeshFields&, EncodeOptions, const Execution& execution) {
        return encode_mfem(mesh, without_progress(execution));
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_mfem(mesh); }>;
    return format;
}

MeshFormat su2_row() {
    MeshFormat format{{"su2", "SU2 mesh", {".su2"}, {}, is_su2}};
    format.decode = quiet<decode_su2>;
    return format;
}

MeshFormat cgns_row() {
    MeshFormat format{{"cgns", "CGNS", {".cgns"}, {}, is_cgns}};
    format.decode = quiet<decode_cgns>;
    format.encode = encoded<[](const auto& mesh, const MeshFields& fields, EncodeOptions, const Execution& execution) {
        return encode_cgns(mesh, fields, without_progress(execution));
    }>;
    format.losses = losses_of<[](const auto& mesh) { return not_in_cgns(mesh); }>;
    format.renames = [](const MeshFields& fields) {
        return renamed_fields(cgns::fields_in_file(fields), cgns::field_names(), "CGNS");
    };
    format.has_fields = true;
    format.can_store = is_in_cgns;
    return format;
}

template <GmfEncoding encoding>
Outcome<Chunks> encode_gmf_fields(const Solution& solution, const Execution& execution) {
    return encode_gmf_solution(solution, {encoding}, execution);
}

}  // namespace

std::span<const MeshFormat> mesh_formats() {
    using enum MshVersion;
    static const std::vector<MeshFormat> formats{
        gmf_row<GmfEncoding::ascii>({"gmf-ascii", "GMF as text", {".mesh"}, {}, is_gmf_ascii}),
        gmf_row<GmfEncoding::binary>({"gmf-binary", "GMF in binary", {".meshb"}, {}, is_gmf_binary}),
        msh_row<v4, MshEncoding::binary>("msh", "Gmsh MSH 4.1 in binary", {".msh"}),
        msh_row<v4, MshEncoding::ascii>("msh-ascii", "Gmsh MSH 4.1 as text", {}),
        msh_row<v2, MshEncoding::binary>("msh2", "Gmsh MSH 2.2 in binary", {}),
        msh_row<v2, MshEncoding::ascii>("msh2-ascii", "Gmsh MSH 2.2 as text", {}),
        vtu_row(),
        pvtu_row(),
        vtk_row<VtkEncoding::binary>("vtk", "legacy VTK in binary", {".vtk"}),
        vtk_row<VtkEncoding::ascii>("vtk-ascii", "legacy VTK as text", {}),
        mfem_row(),
        su2_row(),
        cgns_row(),
        stl_row<StlEncoding::binary>("stl", "STL in binary", {".stl"}),
        stl_row<StlEncoding::ascii>("stl-ascii", "STL as text", {}),
        xdmf_row(),
    };
    return formats;
}

std::span<const SolutionFormat> solution_formats() {
    static const std::vector<SolutionFormat> formats{
        {{"gmf-ascii", "GMF as text", {".sol"}, {}, is_gmf_ascii},
         decode_gmf_solution,
         encode_gmf_fields<GmfEncoding::ascii>},
        {{"gmf-binary", "GMF in binary", {".solb"}, {}, is_gmf_binary},
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

Outcome<const MeshFormat*> format_to_rewrite(std::span<const MeshFormat> formats, std::string_view path,
                                             std::string_view name, std::string_view source) {
    const MeshFormat* const own = name.empty() ? format_with_name(formats, source) : nullptr;
    const bool has_own_extension =
        own && own->encode && !own->shared_extension.empty() && path.ends_with(own->shared_extension);
    return has_own_extension ? own : format_to_write(formats, path, name);
}

Outcome<DecodedSolution> decode_solution(std::span<const std::byte> bytes, std::string_view path,
                                         const Execution& execution) {
    const auto format = format_to_read(solution_formats(), bytes, path);
    if (!format) return fail(format.error());
    return (*format)->decode(bytes, path, execution);
}

namespace {

constexpr std::string_view gmsh_mesh_command = "gmsh IN -3 -format msh41 -o OUT.msh",
                           gmsh_save_command = "gmsh IN -save -format msh41 -o OUT.msh",
                           meshio_command = "meshio convert IN OUT.vtu",
                           paraview_command = "in ParaView, File > Save Data as OUT.vtu";

struct Foreign {
    std::string_view ending, command;
};
constexpr std::array foreign{
    Foreign{".step", gmsh_mesh_command}, Foreign{".stp", gmsh_mesh_command},  Foreign{".iges", gmsh_mesh_command},
    Foreign{".igs", gmsh_mesh_command},  Foreign{".brep", gmsh_mesh_command}, Foreign{".geo", gmsh_mesh_command},
    Foreign{".unv", gmsh_save_command},  Foreign{".med", meshio_command},     Foreign{".bdf", gmsh_save_command},
    Foreign{".nas", gmsh_save_command},  Foreign{".inp", meshio_command},     Foreign{".diff", gmsh_save_command},
    Foreign{".obj", meshio_command},     Foreign{".ply", meshio_command},     Foreign{".off", meshio_command},
    Foreign{".vtk", meshio_command},     Foreign{".xdmf", meshio_command},    Foreign{".xmf", meshio_command},
    Foreign{".e", meshio_command},       Foreign{".exo", meshio_command},     Foreign{".ex2", meshio_command},
    Foreign{".ugrid", meshio_command},   Foreign{".node", meshio_command},    Foreign{".ele", meshio_command},
    Foreign{".avs", meshio_command},     Foreign{".h5m", meshio_command},     Foreign{".pvtu", paraview_command},
    Foreign{".pvd", paraview_command},   Foreign{".vtp", paraview_command},   Foreign{".foam", paraview_command},
    Foreign{".case", paraview_command},
};

std::string for_shell(std::string_view path) {
    const bool plain = std::all_of(path.begin(), path.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '/' || c == '.' || c == '_' || c == '-' || c == '+';
    });
    if (plain) return std::string(path);
    std::string text = "'";
    for (const char c : path) {
        if (c == '\'')
            text += "'\\''";
        else
            text += c;
    }
    return text + "'";
}

}  // namespace

std::string conversion_command(std::string_view path) {
    std::string lower(path);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const Foreign& format : foreign) {
        if (!lower.ends_with(format.ending)) continue;
        std::string command;
        const std::string_view text = format.command, stem = path.substr(0, path.size() - format.ending.size());
        for (std::size_t i = 0; i < text.size();) {
            if (text.substr(i).starts_with("IN ")) {
                command += for_shell(path);
                i += 2;
            } else if (text.substr(i).starts_with("OUT.")) {
                const std::size_t end = std::min(text.find(' ', i), text.size());
                command += for_shell(std::string(stem).append(text.substr(i + 3, end - i - 3)));
                i = end;
            } else {
                command += text[i++];
            }
        }
        return command;
    }
    return {};
}

}  // namespace camber
