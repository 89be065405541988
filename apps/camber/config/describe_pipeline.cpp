// Descriptions of sources, shapes, steps and outputs
module;
#include <algorithm>
#include <string>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.recipes;
import camber.io;
import camber.shapes;
import camber.cad;
import camber.metric;
import camber.edge_optimisation;
import camber.transfer;
import camber.validity;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;
import :codec;
import :description;

namespace camber::config {

namespace {

/// Error of a point and a direction that must have one dimension; empty if there is none.
std::string check_axis(const std::vector<double>& point, const std::vector<double>& axis, const char* name) {
    if (point.size() != axis.size()) return "its vectors must have the same number of coordinates";
    const bool is_zero = std::ranges::all_of(axis, [](double x) { return x == 0; });
    return is_zero ? std::string(name) + " is zero" : std::string();
}

}  // namespace

Description Described<NaturalMetric>::make() {
    return described<NaturalMetric>(
        "natural", "The mesh-implied metric: in it all edges of an element have length one; averaged at vertices.");
}

Description Described<ConstantMetric>::make() {
    return described<ConstantMetric>(
        "constant", "The same metric everywhere: by sizes or by a tensor.", [](const ConstantMetric& s) -> std::string {
            if (s.sizes.empty() == s.tensor.empty()) return "give either \"sizes\" or \"tensor\"";
            if (!s.tensor.empty() && s.tensor.size() != 3 && s.tensor.size() != 6)
                return "a tensor has 3 entries (2D) or 6 (3D), got " + std::to_string(s.tensor.size());
            return {};
        });
}

Choice Described<Metric>::make() {
    return choice_of<Metric>(
        "metric", "The field of sizes and directions that edges follow.",
        key<NaturalMetric>("natural", "mesh-implied: the mesh's own"),
        key<FilePath>("file", "symmetric tensors, or sizes, at the vertices or nodes, from a " +
                                  camber::listed(endings_read(solution_formats())) +
                                  " file, or a mesh file with the field metric"),
        key<ConstantMetric>("constant", "the same everywhere"),
        key<SurfaceMetric>("surface", "thin along the boundary's normals, isotropic in the volume"),
        key<FieldMetric>("field", "an analytic field, by name"),
        key<MetricExpression>("expression", "sizes or tensors as expressions of x, y, z"),
        key<SizesMetric>("sizes",
                         "sizes at what has a reference, as large as the domain elsewhere: to intersect others with"),
        key<GeometryMetric>(
            "geometry",
            "what the boundary's own surface asks for, as large as the domain elsewhere: to intersect others with"),
        key<SolutionMetric>("solution", "what interpolates the run's solution best"));
}

Description Described<Surrogate>::make() {
    return described<Surrogate>(
        "surrogate", "A smooth cubic surface through the mesh's own boundary, with ridges and corners kept.");
}

Description Described<Straight>::make() {
    return described<Straight>("straight", "The mesh's own flat facets: the boundary stays as it is.");
}

Description Described<Plane>::make() {
    return described<Plane>("plane", "A plane (2D: a line).",
                            [](const Plane& s) { return check_axis(s.point, s.normal, "the normal"); });
}

Description Described<Sphere>::make() { return described<Sphere>("sphere", "A sphere (2D: a circle)."); }

Description Described<Cylinder>::make() {
    return described<Cylinder>("cylinder", "An infinite circular cylinder.",
                               [](const Cylinder& s) { return check_axis(s.point, s.axis, "the axis"); });
}

Description Described<Torus>::make() {
    return described<Torus>("torus", "A ring torus.", [](const Torus& s) -> std::string {
        if (!(s.minor_radius < s.major_radius)) return "minor_radius must be below major_radius";
        return check_axis(s.centre, s.axis, "the axis");
    });
}

Choice Described<Surface>::make() {
    return choice_of<Surface>("surface", "the surface's equation", key<Plane>("plane", "a plane"),
                              key<Sphere>("sphere", "a sphere"), key<Cylinder>("cylinder", "a cylinder"),
                              key<Torus>("torus", "a torus"));
}

Description Described<AnalyticSurface>::make() {
    using S = AnalyticSurface;
    return described<S>(
        "analytic", "An array of surfaces by their equations; boundary facets of other references take the surrogate.",
        {field<S>(option_of(&S::references)), inlined(&S::surface)});
}

Description Described<Cad>::make() {
    return described<Cad>(
        "cad",
        "A CAD model (3D), read by OpenCASCADE: facets of the boundary lie on its faces, ridges on its edges, by where "
        "they are; all of them, or those of some references.");
}

Choice Described<Geometry>::make() {
    return choice_of<Geometry>(
        "geometry", "The shape that boundary nodes are put onto.",
        key<Surrogate>("surrogate", "a smooth surface through the mesh's boundary"),
        key<Straight>("straight", "the flat facets themselves"),
        key<FilePath>("mesh",
                      "the boundary of another mesh of the same body, smooth through its vertices and nodes: give the "
                      "first mesh where one is remeshed many times"),
        key<Analytic>("analytic", "spheres, planes, cylinders, tori by reference, the surrogate on all others"),
        key<Cad>("cad", "the faces and edges of a CAD model, by reference beside the others"));
}

Wrapper Described<Analytic>::make() {
    return Wrapper(&Analytic::surfaces, Limits{.min_count = 1}, "array of surfaces");
}

Description Described<BoundaryLayer>::make() {
    return described<BoundaryLayer>("layer", "Thin layers along a wall, prisms cut to simplices.");
}

Description Described<ShellOptions<3>>::make() {
    return described<ShellOptions<3>>("shell", "The volume between two concentric spheres.");
}

Description Described<ShellOptions<2>>::make() {
    return described<ShellOptions<2>>("annulus", "The area between two concentric circles (2D).");
}

Description Described<BoxOptions<3>>::make() {
    return described<BoxOptions<3>>("box", "An axis-aligned box; references 1 to 6 at low x, high x, low y, …");
}

Description Described<BoxOptions<2>>::make() {
    return described<BoxOptions<2>>("rectangle",
                                    "A rectangle (2D); references 1 to 4 at low x, high x, low y, high y.");
}

Description Described<BumpOptions>::make() {
    return described<BumpOptions>(
        "bump", "A channel with a smooth bump on its floor (2D); references: 1 inlet, 2 outlet, 3 floor, 4 ceiling.");
}

Choice Described<Shape>::make() {
    return choice_of<Shape>(
        "generate", "A domain that Camber meshes itself.", key<ShellOptions<3>>("shell", "between two spheres"),
        key<ShellOptions<2>>("annulus", "between two circles (2D)"), key<BoxOptions<3>>("box", "a box"),
        key<BoxOptions<2>>("rectangle", "a rectangle (2D)"), key<BumpOptions>("bump", "a channel with a bump (2D)"));
}

Choice Described<MeshSource>::make() {
    const std::string file = "a mesh file (" + camber::listed(endings_read(mesh_formats()), ", ") + ")";
    return choice_of<MeshSource>("source", "one of them: " + file + ", or an example domain",
                                 key<FilePath>("mesh", file), key<Shape>("generate", "an example domain"));
}
Description Described<Input>::make() {
    using S = Input;
    return described<S>("input", "Where the mesh comes from.", {inlined(&S::source), field<S>(option_of(&S::flat))},
                        [](const S& s) -> std::string {
                            const bool generated = std::holds_alternative<Shape>(s.source);
                            return generated && s.flat != Flat::plane ? "\"flat\" is for a mesh file" : std::string();
                        });
}

Description Described<GivenSolution>::make() {
    return described<GivenSolution>(
        "solution",
        "Fields at the nodes of the input's mesh. They go along to the mesh that is made; a metric may be made for "
        "them, and nodes of edges placed (the objective solution).",
        [](const GivenSolution& s) -> std::string {
            if (!s.file.empty() && !s.expression.empty()) return "\"file\" and \"expression\" are two solutions";
            if (!s.expression.empty() && !s.fields.empty())
                return "\"fields\" are fields of a file, and an expression is one field: leave \"fields\" out";
            if (!std::ranges::all_of(s.weights, [](double w) { return w >= 0; })) return "\"weights\" are 0 or more";
            return {};
        });
}

Description Described<Features>::make() {
    return described<Features>(
        "features",
        "What counts as a ridge where neither the file's edges nor references say so; what required entities of the "
        "boundary hold.");
}

Description Described<BoundaryTolerance>::make() {
    return described<BoundaryTolerance>(
        "geometry_tolerance",
        "Largest distances from the geometry at which nodes and vertices of the boundary count as being on it. A run "
        "whose result exceeds them ends with exit code 1.");
}

Description Described<Output>::make() {
    return described<Output>(
        "output", "Files to write, relative to the working directory.",
        [] {
            auto fields = listed<Output>();
            for (auto& field : fields) {
                if (field.name == option_of(&Output::mesh).name)
                    field.doc = "the mesh, in the format of its ending (" +
                                camber::listed(endings_written(mesh_formats()), ", ") + "); empty: none";
                if (field.name == option_of(&Output::format).name)
                    field.doc += " (" + camber::listed(names_written(mesh_formats()), ", ", ", ") + ")";
            }
            return fields;
        }(),
        [](const Output& o) -> std::string {
            const auto names = names_written(mesh_formats());
            if (o.format.empty() || std::ranges::find(names, o.format) != names.end()) return {};
            return "\"format\": " + in_quotes(o.format) + " is no format that is written (" +
                   suggestion(o.format, {names.begin(), names.end()}) + ")";
        });
}

Description Described<Pipeline>::make() {
    return described<Pipeline>("pipeline",
                               "A run of Camber: a mesh, a metric, a geometry, stages, outputs. Input paths are "
                               "relative to the config's folder, output paths to the working directory.");
}

Description Described<Elevate>::make() {
    return described<Elevate>("elevate",
                              "Linear to quadratic: each edge gets a node at its middle; no point of the mesh moves.");
}

Description Described<Curve>::make() {
    return described<Curve>(
        "curve",
        "Moves each edge's node: boundary nodes onto the geometry, volume nodes where the objective asks for them: by "
        "default where what the metric is made for is interpolated best.");
}

Description Described<Validate>::make() {
    return described<Validate>("validate", "Judges every element by certified bounds of its Jacobian's determinant.");
}

Description Described<Relax>::make() {
    return described<Relax>("relax",
                            "Repairs what is not valid, at the least loss of what the stage before wanted: volume "
                            "edges first, surface edges last.");
}

Description Described<Commit>::make() { return described<Commit>("commit", "Makes the planned nodes the mesh's own."); }

Description Described<Reinsert>::make() {
    return described<Reinsert>(
        "reinsert",
        "The paper's global algorithm: every vertex is put in again where it is, by the cavity operator with its ball "
        "as the cavity, and the nodes of its edges go to where curve wants them, or a part of the way. No element that "
        "is valid stops being so at any time. In place of curve, validate, relax and commit. Of the options of relax "
        "its bounds count.");
}

Description Described<Collapse>::make() {
    return described<Collapse>("collapse",
                               "Of a mesh of degree 1 or 2: edges that are short in the metric go, one end into the "
                               "other, the shortest first.");
}

Description Described<Split>::make() {
    return described<Split>(
        "split",
        "Of a mesh of degree 1 or 2: edges that are long in the metric get a vertex at their middle by length, the "
        "longest first; those of the boundary on the geometry. The halves of a curved one keep its curve.");
}

Description Described<Swap>::make() {
    return described<Swap>("swap",
                           "Of a mesh of degree 1 or 2: edges and faces of bad elements are exchanged where the worst "
                           "element becomes better for it.");
}

Description Described<Smooth>::make() {
    return described<Smooth>(
        "smooth",
        "Of a mesh of degree 1 or 2: vertices move to where their edges are nearer to unit, as far as the worst "
        "element around them becomes better; those of smooth surfaces on the geometry.");
}

Description Described<Mend>::make() {
    return described<Mend>("improve",
                           "Of a mesh of degree 1 or 2: swaps and moves for bad elements alone, turn after turn.");
}

Description Described<Remesh>::make() {
    return described<Remesh>(
        "remesh",
        "Brings a mesh to the metric, of degree 1, or of degree 2 with its curves (after commit, or as it was read): "
        "rounds of collapse, split, swap and smooth, until edges are of unit length and nothing changes much; improve "
        "at last. References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept, "
        "and no valid element becomes an invalid one. The metric is made of the mesh as it is before; the geometry "
        "too, and what follows is curved onto it.");
}

Choice Described<Stage>::make() {
    return choice_of<Stage>(
        "stages", "One step of the pipeline.", key<Elevate>("elevate", "linear to quadratic"),
        key<Curve>("curve", "plan where nodes go"), key<Validate>("validate", "judge every element"),
        key<Relax>("relax", "repair what is not valid"), key<Commit>("commit", "make the plan the mesh"),
        key<Reinsert>("reinsert", "curve cavity by cavity"), key<Collapse>("collapse", "remove short edges"),
        key<Split>("split", "divide long edges"), key<Swap>("swap", "exchange edges and faces of bad elements"),
        key<Smooth>("smooth", "move vertices"), key<Mend>("improve", "swap and move for bad elements alone"),
        key<Remesh>("remesh", "bring a mesh to the metric"));
}

}  // namespace camber::config
