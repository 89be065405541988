module;
#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <string>
#include <string_view>
module camber.io;
import camber.core;

namespace camber {

namespace {

/// What makes a mesh that we read of files that we do not: IN and OUT stand for their names.
constexpr std::string_view mesh_it = "gmsh IN -3 -format msh41 -o OUT.msh",
                           resave = "gmsh IN -save -format msh41 -o OUT.msh", by_meshio = "meshio convert IN OUT.vtu",
                           by_paraview = "in ParaView, File > Save Data as OUT.vtu";

struct Foreign {
    std::string_view ending, command;
};
constexpr std::array foreign{
    Foreign{".step", mesh_it},     Foreign{".stp", mesh_it},     Foreign{".iges", mesh_it},
    Foreign{".igs", mesh_it},      Foreign{".brep", mesh_it},    Foreign{".geo", mesh_it},
    Foreign{".unv", resave},       Foreign{".med", by_meshio},   Foreign{".bdf", resave},
    Foreign{".nas", resave},       Foreign{".inp", by_meshio},   Foreign{".diff", resave},
    Foreign{".obj", by_meshio},    Foreign{".ply", by_meshio},   Foreign{".off", by_meshio},
    Foreign{".vtk", by_meshio},    Foreign{".xdmf", by_meshio},  Foreign{".xmf", by_meshio},
    Foreign{".e", by_meshio},      Foreign{".exo", by_meshio},   Foreign{".ex2", by_meshio},
    Foreign{".ugrid", by_meshio},  Foreign{".node", by_meshio},  Foreign{".ele", by_meshio},
    Foreign{".avs", by_meshio},    Foreign{".h5m", by_meshio},   Foreign{".pvtu", by_paraview},
    Foreign{".pvd", by_paraview},  Foreign{".vtp", by_paraview}, Foreign{".foam", by_paraview},
    Foreign{".case", by_paraview},
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

std::string how_to_convert(std::string_view path) {
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
