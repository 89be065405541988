// Descriptions of sources, shapes, steps and outputs
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
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

bool is_zero(const std::vector<double>& v) {
    for (const double x : v)
        if (x != 0) return false;
    return true;
}

/// Error of a point and a direction that must have one dimension; empty if there is none.
std::string check_axis(const std::vector<double>& point, const std::vector<double>& axis, const char* name) {
    if (point.size() != axis.size()) return "its vectors must have the same number of coordinates";
    return is_zero(axis) ? std::string(name) + " is zero" : std::string{};
}

}  // namespace

const Description& Described<NaturalMetric>::get() {
    static const Description description = described<NaturalMetric>(
        "natural", "The mesh-implied metric: in it all edges of an element have length one; averaged at vertices.");
    return description;
}

const Description& Described<ConstantMetric>::get() {
    static const Description description = described<ConstantMetric>(
        "constant", "The same metric everywhere: by sizes or by a tensor.", [](const ConstantMetric& s) -> std::string {
            if (s.sizes.empty() == s.tensor.empty()) return "give either \"sizes\" or \"tensor\"";
            if (!s.tensor.empty() && s.tensor.size() != 3 && s.tensor.size() != 6)
                return "a tensor has 3 entries (2D) or 6 (3D), got " + std::to_string(s.tensor.size());
            return {};
        });
    return description;
}

const Choice& Described<Metric>::get() {
    static const Choice choice =
        choice_of<Metric>("metric", "The field of sizes and directions that edges follow.",
                          key<NaturalMetric>("natural", "mesh-implied: the mesh's own"),
                          key<FilePath>("file", "symmetric tensors, or sizes, at the vertices or nodes, from a " +
                                                    camber::listed(endings_read(solution_formats())) +
                                                    " file, or a mesh file with the field metric"),
                          key<ConstantMetric>("constant", "the same everywhere"),
                          key<SurfaceMetric>("surface", "thin along the boundary's normals, isotropic in the volume"),
                          key<FieldMetric>("field", "an analytic field, by name"),
                          key<MetricExpression>("expression", "sizes or tensors as expressions of x, y, z"),
                          key<SizesMetric>("sizes",
                                           "sizes at what has a reference, as large as the domain elsewhere: "
                                           "to intersect others with"),
                          key<GeometryMetric>("geometry",
                                              "what the boundary's own surface asks for, as large as the "
                                              "domain elsewhere: to intersect others with"),
                          key<SolutionMetric>("solution", "what interpolates the run's solution best"));
    return choice;
}

const Description& Described<Surrogate>::get() {
    static const Description description = described<Surrogate>(
        "surrogate", "A smooth cubic surface through the mesh's own boundary, with ridges and corners kept.");
    return description;
}

const Description& Described<Straight>::get() {
    static const Description description =
        described<Straight>("straight", "The mesh's own flat facets: the boundary stays as it is.");
    return description;
}

const Description& Described<Plane>::get() {
    static const Description description = described<Plane>(
        "plane", "A plane (2D: a line).", [](const Plane& s) { return check_axis(s.point, s.normal, "the normal"); });
    return description;
}

const Description& Described<Sphere>::get() {
    static const Description description = described<Sphere>("sphere", "A sphere (2D: a circle).");
    return description;
}

const Description& Described<Cylinder>::get() {
    static const Description description =
        described<Cylinder>("cylinder", "An infinite circular cylinder.",
                            [](const Cylinder& s) { return check_axis(s.point, s.axis, "the axis"); });
    return description;
}

const Description& Described<Torus>::get() {
    static const Description description =
        described<Torus>("torus", "A ring torus.", [](const Torus& s) -> std::string {
            if (!(s.minor_radius < s.major_radius)) return "minor_radius must be below major_radius";
            return check_axis(s.centre, s.axis, "the axis");
        });
    return description;
}

const Choice& Described<Surface>::get() {
    static const Choice choice = choice_of<Surface>(
        "surface", "the surface's equation", key<Plane>("plane", "a plane"), key<Sphere>("sphere", "a sphere"),
        key<Cylinder>("cylinder", "a cylinder"), key<Torus>("torus", "a torus"));
    return choice;
}

const Description& Described<AnalyticSurface>::get() {
    using S = AnalyticSurface;
    static const Description description = described<S>(
        "analytic", "An array of surfaces by their equations; boundary facets of other references take the surrogate.",
        {field<S>(option_of(&S::references)), inlined(&S::surface)});
    return description;
}

const Description& Described<Cad>::get() {
    static const Description description = described<Cad>(
        "cad",
        "A CAD model (3D), read by OpenCASCADE: facets of the boundary lie on its faces, ridges on its edges, by where "
        "they are; all of them, or those of some references.");
    return description;
}

const Choice& Described<Geometry>::get() {
    static const Choice choice = choice_of<Geometry>(
        "geometry", "The shape that boundary nodes are put onto.",
        key<Surrogate>("surrogate", "a smooth surface through the mesh's boundary"),
        key<Straight>("straight", "the flat facets themselves"),
        key<FilePath>("mesh",
                      "the boundary of another mesh of the same body, smooth through its vertices and nodes: give the "
                      "first mesh where one is remeshed many times"),
        key<Analytic>("analytic", "spheres, planes, cylinders, tori by reference, the surrogate on all others"),
        key<Cad>("cad", "the faces and edges of a CAD model, by reference beside the others"));
    return choice;
}

const Wrapper& Described<Analytic>::get() {
    static const Wrapper wrapper(&Analytic::surfaces, Limits{.min_count = 1}, "array of surfaces");
    return wrapper;
}

const Description& Described<BoundaryLayer>::get() {
    static const Description description =
        described<BoundaryLayer>("layer", "Thin layers along a wall, prisms cut to simplices.");
    return description;
}

const Description& Described<ShellOptions<3>>::get() {
    static const Description description =
        described<ShellOptions<3>>("shell", "The volume between two concentric spheres.");
    return description;
}

const Description& Described<ShellOptions<2>>::get() {
    static const Description description =
        described<ShellOptions<2>>("annulus", "The area between two concentric circles (2D).");
    return description;
}

const Description& Described<BoxOptions<3>>::get() {
    static const Description description =
        described<BoxOptions<3>>("box", "An axis-aligned box; references 1 to 6 at low x, high x, low y, …");
    return description;
}

const Description& Described<BoxOptions<2>>::get() {
    static const Description description =
        described<BoxOptions<2>>("rectangle", "A rectangle (2D); references 1 to 4 at low x, high x, low y, high y.");
    return description;
}

const Description& Described<BumpOptions>::get() {
    static const Description description = described<BumpOptions>(
        "bump", "A channel with a smooth bump on its floor (2D); references: 1 inlet, 2 outlet, 3 floor, 4 ceiling.");
    return description;
}

const Choice& Described<Shape>::get() {
    static const Choice choice = choice_of<Shape>(
        "generate", "A domain that Camber meshes itself.", key<ShellOptions<3>>("shell", "between two spheres"),
        key<ShellOptions<2>>("annulus", "between two circles (2D)"), key<BoxOptions<3>>("box", "a box"),
        key<BoxOptions<2>>("rectangle", "a rectangle (2D)"), key<BumpOptions>("bump", "a channel with a bump (2D)"));
    return choice;
}

const Choice& Described<MeshSource>::get() {
    static const std::string file = "a mesh file (" + camber::listed(endings_read(mesh_formats()), ", ") + ")";
    static const Choice choice =
        choice_of<MeshSource>("source", "one of them: " + file + ", or an example domain", key<FilePath>("mesh", file),
                              key<Shape>("generate", "an example domain"));
    return choice;
}
const Description& Described<Input>::get() {
    using S = Input;
    static const Description description =
        described<S>("input", "Where the mesh comes from.", {inlined(&S::source), field<S>(option_of(&S::flat))},
                     [](const S& s) -> std::string {
                         const bool generated = std::holds_alternative<Shape>(s.source);
                         return generated && s.flat != Flat::plane ? "\"flat\" is for a mesh file" : std::string();
                     });
    return description;
}

const Description& Described<GivenSolution>::get() {
    static const Description description = described<GivenSolution>(
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
    return description;
}

const Description& Described<Features>::get() {
    static const Description description = described<Features>(
        "features",
        "What counts as a ridge where neither the file's edges nor references say so; what required entities of the "
        "boundary hold.");
    return description;
}

const Description& Described<BoundaryTolerance>::get() {
    static const Description description = described<BoundaryTolerance>(
        "geometry_tolerance",
        "Largest distances from the geometry at which nodes and vertices of the boundary count as being on it. A run "
        "whose result exceeds them ends with exit code 1.");
    return description;
}

const Description& Described<Output>::get() {
    static const Description description = described<Output>(
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
    return description;
}

const Description& Described<Pipeline>::get() {
    static const Description description = described<Pipeline>(
        "pipeline",
        "A run of Camber: a mesh, a metric, a geometry, stages, outputs. Input paths are relative to the config's "
        "folder, output "
        "paths to the working directory.");
    return description;
}

const Description& Described<Elevate>::get() {
    static const Description description = described<Elevate>(
        "elevate", "Linear to quadratic: each edge gets a node at its middle; no point of the mesh moves.");
    return description;
}

const Description& Described<Curve>::get() {
    static const Description description = described<Curve>(
        "curve",
        "Moves each edge's node: boundary nodes onto the geometry, volume nodes where the objective asks for "
        "them: by default where what the metric is made for is interpolated best.");
    return description;
}

const Description& Described<Validate>::get() {
    static const Description description =
        described<Validate>("validate", "Judges every element by certified bounds of its Jacobian's determinant.");
    return description;
}

const Description& Described<Relax>::get() {
    static const Description description =
        described<Relax>("relax",
                         "Repairs what is not valid, at the least loss of what the stage before "
                         "wanted: volume edges first, surface edges "
                         "last.");
    return description;
}

const Description& Described<Commit>::get() {
    static const Description description = described<Commit>("commit", "Makes the planned nodes the mesh's own.");
    return description;
}

const Description& Described<Reinsert>::get() {
    static const Description description = described<Reinsert>(
        "reinsert",
        "The paper's global algorithm: every vertex is put in again where it is, by the cavity operator with its ball "
        "as "
        "the cavity, and the nodes of its edges go to where curve wants them, or a part of the way. No element that is "
        "valid stops being so at any time. In place of curve, validate, relax and commit. Of the options of relax its "
        "bounds count.");
    return description;
}

const Description& Described<Collapse>::get() {
    static const Description description =
        described<Collapse>("collapse",
                            "Of a mesh of degree 1 or 2: edges that are short in the metric go, "
                            "one end into the other, the shortest first.");
    return description;
}

const Description& Described<Split>::get() {
    static const Description description = described<Split>(
        "split",
        "Of a mesh of degree 1 or 2: edges that are long in the metric get a vertex at their middle by length, the "
        "longest first; those of the boundary on the geometry. The halves of a curved one keep its curve.");
    return description;
}

const Description& Described<Swap>::get() {
    static const Description description =
        described<Swap>("swap",
                        "Of a mesh of degree 1 or 2: edges and faces of bad elements are "
                        "exchanged where the worst element becomes better for it.");
    return description;
}

const Description& Described<Smooth>::get() {
    static const Description description =
        described<Smooth>("smooth",
                          "Of a mesh of degree 1 or 2: vertices move to where their edges are "
                          "nearer to unit, as far as the worst element around "
                          "them becomes better; those of smooth surfaces on the geometry.");
    return description;
}

const Description& Described<Mend>::get() {
    static const Description description = described<Mend>(
        "improve", "Of a mesh of degree 1 or 2: swaps and moves for bad elements alone, turn after turn.");
    return description;
}

const Description& Described<Remesh>::get() {
    static const Description description = described<Remesh>(
        "remesh",
        "Brings a mesh to the metric, of degree 1, or of degree 2 with its curves (after commit, or as it was read): "
        "rounds of collapse, split, swap and smooth, until edges are of unit length and nothing changes much; improve "
        "at "
        "last. References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept, "
        "and no valid element becomes an invalid one. The metric is made of the mesh as it is before; the geometry "
        "too, and what follows is curved onto it.");
    return description;
}

const Choice& Described<Stage>::get() {
    static const Choice choice = choice_of<Stage>(
        "stages", "One step of the pipeline.", key<Elevate>("elevate", "linear to quadratic"),
        key<Curve>("curve", "plan where nodes go"), key<Validate>("validate", "judge every element"),
        key<Relax>("relax", "repair what is not valid"), key<Commit>("commit", "make the plan the mesh"),
        key<Reinsert>("reinsert", "curve cavity by cavity"), key<Collapse>("collapse", "remove short edges"),
        key<Split>("split", "divide long edges"), key<Swap>("swap", "exchange edges and faces of bad elements"),
        key<Smooth>("smooth", "move vertices"), key<Mend>("improve", "swap and move for bad elements alone"),
        key<Remesh>("remesh", "bring a mesh to the metric"));
    return choice;
}

}  // namespace camber::config
