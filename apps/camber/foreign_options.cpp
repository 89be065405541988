// Options and commands of Gmsh, Mmg and other programs, with those of Camber.
#include "foreign_options.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace camber::app {

namespace {

struct Row {
    std::string_view names;  ///< in small letters, "-" for "_", with blanks between them
    std::string_view program;
    std::string_view remedy;
};

constexpr std::array options{
    // sizes
    Row{"hausd", "Mmg", "use --geometry-error DISTANCE"},
    Row{"hsiz", "Mmg", "use camber remesh --metric SIZE"},
    Row{"hmax", "Mmg",
        "use --max-size with camber metric or adapt, or --set 'metric_operations=[{\"bound\": {\"max_size\": SIZE}}]'"},
    Row{"hmin", "Mmg",
        "use --min-size with camber metric or adapt, or --set 'metric_operations=[{\"bound\": {\"min_size\": SIZE}}]'"},
    Row{"hgrad hgradreq", "Mmg", "use --gradation RATIO"},
    Row{"sol met", "Mmg", "use --metric FILE for a metric, or --solution FILE for a solution"},
    Row{"lc clmax", "Gmsh", "use camber remesh --metric SIZE"},
    Row{"clmin", "Gmsh",
        "use --min-size with camber metric or adapt, or --set 'metric_operations=[{\"bound\": {\"min_size\": SIZE}}]'"},
    Row{"clscale", "Gmsh", "use camber remesh --complexity NUMBER: 8 times as many elements in 3D have half the size"},
    Row{"clcurv", "Gmsh", "use --geometry-error DISTANCE"},
    Row{"bgm", "Gmsh", "use --metric FILE"},
    Row{"size-field sizing mesh-size target-size edge-length resolution h", "", "use camber remesh --metric SIZE"},
    Row{"size-map sizes local-size", "", "use --size REFERENCE=SIZE"},
    // geometry
    Row{"ar angle feature-angle angle-detection", "Mmg",
        "use --set features/ridge_angle=DEGREES, or --ridge-angle with camber check or geometry"},
    Row{"nr no-ridges", "Mmg", "use --set features/ridge_angle=180"},
    Row{"nosurf", "Mmg", "list the triangles as RequiredTriangles in the mesh; required entities are preserved"},
    Row{"ls lag opnbdy", "Mmg", "Camber has no equivalent"},
    Row{"tol tolerance", "", "use --geometry-tolerance for boundary nodes, or --geometry-error for the boundary"},
    Row{"step stp iges brep geo", "", "use --cad FILE.step with a mesh; Camber does not mesh a CAD model without one"},
    Row{"model geom cad-file", "", "use --cad FILE"},
    // degree and quality
    Row{"order degree p2 high-order highorder", "Gmsh",
        "camber curve makes degree 2, camber convert --straighten degree 1; there are no higher degrees"},
    Row{"optimize optimise optimize-ho optimize-netgen optimize-threshold optimize-lowmem optho", "Gmsh",
        "use camber repair for a curved mesh, or camber remesh"},
    Row{"optim optimles", "Mmg", "use camber remesh without --metric: it preserves the sizes and improves the shapes"},
    Row{"noinsert noswap nomove", "Mmg",
        "use a config with the stages of split, collapse, swap and smooth that are required, see camber explain "
        "stages"},
    Row{"smooth smoothing", "Gmsh", "use camber remesh, or the stage smooth in a config"},
    Row{"refine level", "Gmsh", "use camber remesh --metric SIZE"},
    Row{"quality min-quality threshold", "", "use --min-scaled-jacobian BOUND"},
    Row{"algo algorithm", "Gmsh", "Camber generates no mesh from a model: mesh it with gmsh first"},
    // files
    Row{"in i input", "", "name the input mesh as the first argument, without an option"},
    Row{"out outfile output-file", "", "use -o FILE"},
    Row{"f input-format output-format outformat bin binary ascii", "", "use --format NAME, see camber convert --help"},
    Row{"save save-all save-topology", "Gmsh", "leave it out: the whole mesh is written to -o FILE"},
    Row{"y yes overwrite clobber", "", "use --force"},
    Row{"part nparts", "Gmsh", "use --partition NUMBER"},
    Row{"3dmedit rn nreg xreg keep-ref", "Mmg", "Camber has no equivalent"},
    // run
    Row{"nt j np cores jobs num-threads nthreads", "", "use --threads NUMBER; several processes: mpirun camber-mpi"},
    Row{"v verbosity debug d", "", "use --verbose for details, or --quiet"},
    Row{"q silent s", "", "use --quiet"},
    Row{"m mem max-memory", "Mmg", "use --memory SIZE with camber curve"},
    Row{"setnumber setstring param", "Gmsh", "use --set PATH=VALUE, see camber explain"},
    Row{"nopopup gui fltk", "Gmsh", "leave it out: Camber has no window; use camber report or picture to see a mesh"},
    Row{"1 2 3", "Gmsh", "leave it out: the mesh has its dimension; Camber generates no mesh from a model"},
    Row{"a anisotropic aniso", "Mmg", "use --metric FILE with a tensor at each vertex"},
    Row{"val", "Mmg", "use camber VERB --print-config"},
};

constexpr std::array commands{
    Row{"mesh refine coarsen remeshing mmg mmg3d mmg2d mmgs", "", "use camber remesh"},
    Row{"optimize optimise improve smooth untangle fix heal", "",
        "use camber repair for a curved mesh, or camber remesh"},
    Row{"elevate order degree ho highorder", "", "use camber curve"},
    Row{"quality validate verify test stats statistics", "", "use camber check"},
    Row{"view show open display gui", "", "use camber report for a page in a browser, or camber picture"},
    Row{"partition split", "", "use camber convert --partition NUMBER"},
    Row{"list ls cat describe", "", "use camber info"},
    Row{"export import save translate", "", "use camber convert"},
    Row{"interpolate map project", "", "use camber transfer"},
    Row{"straighten linearize", "", "use camber convert --straighten"},
    Row{"version", "", "use camber --version"},
    Row{"new create make", "", "use camber generate"},
};

std::optional<ForeignName> find(std::span<const Row> rows, std::string_view name) {
    for (const Row& row : rows)
        for (std::size_t begin = 0; begin < row.names.size();) {
            const std::size_t end = std::min(row.names.find(' ', begin), row.names.size());
            if (row.names.substr(begin, end - begin) == name)
                return ForeignName{std::string(row.program), std::string(row.remedy)};
            begin = end + 1;
        }
    return std::nullopt;
}

}  // namespace

std::optional<ForeignName> find_foreign_option(std::string_view option) {
    option.remove_prefix(std::min(option.find_first_not_of('-'), option.size()));
    std::string name(option.substr(0, option.find('=')));
    for (char& c : name) c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return find(options, name);
}

std::optional<ForeignName> find_foreign_command(std::string_view command) { return find(commands, command); }

}  // namespace camber::app
