// Descriptions of sources and shapes
module;
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

}  // namespace camber::config
