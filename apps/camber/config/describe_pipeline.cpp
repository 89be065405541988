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

/// Returns the error if the dimensions differ or the axis is zero; empty: valid.
std::string check_axis(const std::vector<double>& point, const std::vector<double>& axis, const char* name) {
    if (point.size() != axis.size()) return "the point and the direction must have the same number of coordinates";
    const bool is_zero = std::ranges::all_of(axis, [](double x) { return x == 0; });
    return is_zero ? std::string(name) + " is zero" : std::string();
}

}  // namespace

Description Described<NaturalMetric>::make() {
    return described<NaturalMetric>(
        "natural",
        "The mesh-implied metric: all edges of a straight element have length 1 in it. It is averaged at "
        "vertices.");
}

Description Described<ConstantMetric>::make() {
    return described<ConstantMetric>("constant", "The same metric everywhere, given by sizes or by a tensor.",
                                     [](const ConstantMetric& s) -> std::string {
                                         if (s.sizes.empty() == s.tensor.empty())
                                             return "give either \"sizes\" or \"tensor\"";
                                         if (!s.tensor.empty() && s.tensor.size() != 3 && s.tensor.size() != 6)
                                             return "a tensor has 3 entries (2D) or 6 (3D), got " +
                                                    std::to_string(s.tensor.size());
                                         return {};
                                     });
}

Choice Described<Metric>::make() {
    return choice_of<Metric>(
        "metric", "The metric: requested sizes of elements in each direction.",
        key<NaturalMetric>("natural", "mesh-implied: the sizes of the input mesh"),
        key<FilePath>("file", "symmetric tensors, or sizes, at the vertices or nodes, from a " +
                                  camber::listed(readable_extensions(solution_formats())) +
                                  " file, or a mesh file with the field metric"),
        key<ConstantMetric>("constant", "the same everywhere"),
        key<SurfaceMetric>("surface", "small sizes along the normals of the boundary, isotropic in the volume"),
        key<FieldMetric>("field", "an analytic field, by name"),
        key<MetricExpression>("expression", "sizes or tensors as expressions of x, y, z"),
        key<SizesMetric>("sizes",
                         "sizes at entities with a reference, as large as the domain elsewhere; to be intersected with "
                         "others"),
        key<GeometryMetric>(
            "geometry",
            "sizes by the curvature of the boundary, as large as the domain elsewhere; to be intersected with others"),
        key<SolutionMetric>("solution", "the metric that interpolates the run's solution best"));
}

Description Described<Surrogate>::make() {
    return described<Surrogate>(
        "surrogate", "A smooth cubic surface through the boundary of the mesh. It preserves ridges and corners.");
}

Description Described<Straight>::make() {
    return described<Straight>("straight", "The flat facets of the mesh. The boundary does not change.");
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
        "analytic", "An array of surfaces given by equations. Boundary facets with other references use the surrogate.",
        {field<S>(option_of(&S::references)), inlined(&S::surface)});
}

Description Described<Cad>::make() {
    return described<Cad>(
        "cad",
        "A CAD model (3D), read by OpenCASCADE. Facets of the boundary are associated with its faces and ridges with "
        "its edges, by their positions. This applies to all facets, or to those with some references.");
}

Choice Described<Geometry>::make() {
    return choice_of<Geometry>(
        "geometry", "The shape onto which boundary nodes are projected.",
        key<Surrogate>("surrogate", "a smooth surface through the mesh's boundary"),
        key<Straight>("straight", "the flat facets of the mesh"),
        key<FilePath>("mesh",
                      "the boundary of another mesh of the same body, smooth through its vertices and nodes. Use the "
                      "first mesh if a body is remeshed repeatedly"),
        key<Analytic>("analytic", "spheres, planes, cylinders, tori by reference, the surrogate for all others"),
        key<Cad>("cad", "faces and edges of a CAD model, optionally only for some references"));
}

Wrapper Described<Analytic>::make() {
    return Wrapper(&Analytic::surfaces, Limits{.min_count = 1}, "array of surfaces");
}

Description Described<BoundaryLayer>::make() {
    return described<BoundaryLayer>("layer", "Thin layers along a boundary: prisms divided into simplices.");
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
        "generate", "A domain that Camber meshes.", key<ShellOptions<3>>("shell", "between two spheres"),
        key<ShellOptions<2>>("annulus", "between two circles (2D)"), key<BoxOptions<3>>("box", "a box"),
        key<BoxOptions<2>>("rectangle", "a rectangle (2D)"), key<BumpOptions>("bump", "a channel with a bump (2D)"));
}

Choice Described<MeshSource>::make() {
    const std::string file = "a mesh file (" + camber::listed(readable_extensions(mesh_formats()), ", ") + ")";
    return choice_of<MeshSource>("source", "either " + file + ", or an example domain", key<FilePath>("mesh", file),
                                 key<Shape>("generate", "an example domain"));
}
Description Described<Input>::make() {
    using S = Input;
    return described<S>("input", "Source of the mesh.", {inlined(&S::source), field<S>(option_of(&S::flat))},
                        [](const S& s) -> std::string {
                            const bool generated = std::holds_alternative<Shape>(s.source);
                            return generated && s.flat != Flat::plane ? "\"flat\" applies only to a mesh file"
                                                                      : std::string();
                        });
}

Description Described<SolutionInput>::make() {
    return described<SolutionInput>(
        "solution",
        "Fields at the nodes of the input mesh. They are transferred to the output mesh. A metric can be computed from "
        "them, and nodes of edges can be placed for them (the objective solution).",
        [](const SolutionInput& s) -> std::string {
            if (!s.file.empty() && !s.expression.empty()) return "\"file\" and \"expression\" are mutually exclusive";
            if (!s.expression.empty() && !s.fields.empty())
                return "\"fields\" selects fields of a file; leave it out with \"expression\"";
            if (!std::ranges::all_of(s.weights, [](double w) { return w >= 0; }))
                return "\"weights\" must be 0 or more";
            return {};
        });
}

Description Described<Features>::make() {
    return described<Features>(
        "features",
        "Criteria for ridges that are neither listed in the file nor lie between references, and the treatment of "
        "required entities of the boundary.");
}

Description Described<BoundaryTolerance>::make() {
    return described<BoundaryTolerance>(
        "geometry_tolerance",
        "Largest distances from the geometry at which nodes and vertices of the boundary count as lying on it. A run "
        "whose result exceeds them ends with exit code 1.");
}

Description Described<Output>::make() {
    return described<Output>(
        "output", "Files to write, relative to the working directory.",
        [] {
            auto fields = listed<Output>();
            for (auto& field : fields) {
                if (field.name == option_of(&Output::mesh).name)
                    field.doc = "the mesh, in the format of its file extension (" +
                                camber::listed(writable_extensions(mesh_formats()), ", ") + "); empty: none";
                if (field.name == option_of(&Output::format).name)
                    field.doc += " (" + camber::listed(writable_formats(mesh_formats()), ", ", ", ") + ")";
            }
            return fields;
        }(),
        [](const Output& o) -> std::string {
            const auto names = writable_formats(mesh_formats());
            if (o.format.empty() || std::ranges::find(names, o.format) != names.end()) return {};
            return "\"format\": " + in_quotes(o.format) + " is not a format that Camber writes (" +
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
                              "Converts a linear mesh to a quadratic one: each edge gets a node at its middle. The "
                              "shape of the mesh does not change.");
}

Description Described<Curve>::make() {
    return described<Curve>(
        "curve",
        "Proposes a position for each edge's node: on the geometry for boundary nodes, by the objective for inner "
        "nodes. The default objective minimises the interpolation error of the field that belongs to the metric.");
}

Description Described<Validate>::make() {
    return described<Validate>("validate",
                               "Determines the validity of every element by certified bounds of its "
                               "Jacobian determinant.");
}

Description Described<Relax>::make() {
    return described<Relax>("relax",
                            "Makes invalid elements valid, with the smallest changes to the node positions that the "
                            "previous stage proposed. Nodes of volume edges move first, nodes of surface edges last.");
}

Description Described<Commit>::make() {
    return described<Commit>("commit",
                             "Replaces the nodes of the mesh by the "
                             "proposed nodes.");
}

Description Described<Reinsert>::make() {
    return described<Reinsert>(
        "reinsert",
        "The global algorithm of the paper (see docs/README.md). The cavity operator reinserts every vertex at its "
        "position, with its ball as the cavity. The nodes of its edges move to the target positions of curve, or part "
        "of the way. A valid element stays valid at any time. The stage replaces curve, validate, relax and commit. "
        "Only the bounds of relax apply to it.");
}

Description Described<Collapse>::make() {
    return described<Collapse>("collapse",
                               "Collapses edges that are short in the metric into one of their ends, the shortest "
                               "first. The mesh has degree 1 or 2.");
}

Description Described<Split>::make() {
    return described<Split>(
        "split",
        "Splits edges that are long in the metric at their middle by length, the longest first. New boundary vertices "
        "lie on the geometry. The halves of a curved edge follow its curve. The mesh has degree 1 or 2.");
}

Description Described<Swap>::make() {
    return described<Swap>("swap",
                           "Swaps edges and faces of bad elements if this improves the worst element. The mesh has "
                           "degree 1 or 2.");
}

Description Described<Smooth>::make() {
    return described<Smooth>(
        "smooth",
        "Moves vertices to positions where their edges are closer to unit length, if this improves the worst element "
        "around them. Vertices of smooth surfaces stay on the geometry. The mesh has degree 1 or 2.");
}

Description Described<Mend>::make() {
    return described<Mend>("improve",
                           "Repeats swaps and moves of vertices, for bad elements only. The mesh has degree 1 or 2.");
}

Description Described<Remesh>::make() {
    return described<Remesh>(
        "remesh",
        "Adapts the mesh to the metric by rounds of collapse, split, swap and smooth, followed by improve. The rounds "
        "end when edges have unit length and few operations remain. The mesh has degree 1, or degree 2 with curved "
        "edges (after commit, or from a file). References, materials, interfaces, ridges, listed curves, corners and "
        "required entities are preserved. No valid element becomes invalid. Metric and geometry are computed from the "
        "mesh before the stage. Later stages curve the result onto the same geometry.");
}

Choice Described<Stage>::make() {
    return choice_of<Stage>(
        "stages", "One step of the pipeline.", key<Elevate>("elevate", "linear to quadratic"),
        key<Curve>("curve", "propose node positions"), key<Validate>("validate", "check every element"),
        key<Relax>("relax", "make invalid elements valid"), key<Commit>("commit", "accept the proposed nodes"),
        key<Reinsert>("reinsert", "curve cavity by cavity"), key<Collapse>("collapse", "collapse short edges"),
        key<Split>("split", "split long edges"), key<Swap>("swap", "swap edges and faces of bad elements"),
        key<Smooth>("smooth", "move vertices"), key<Mend>("improve", "swap and move for bad elements only"),
        key<Remesh>("remesh", "adapt the mesh to the metric"));
}

}  // namespace camber::config
