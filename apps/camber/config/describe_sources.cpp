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

/// Of two vectors that must be of one dimension, the second a direction.
std::string check_axis(const std::vector<double>& point, const std::vector<double>& axis, const char* name) {
    if (point.size() != axis.size()) return "its vectors must have the same number of coordinates";
    return is_zero(axis) ? std::string(name) + " is zero" : std::string{};
}

}  // namespace

const Description<NaturalMetric>& Described<NaturalMetric>::get() {
    static const Description<NaturalMetric> description{
        "natural",
        "The mesh-implied metric: in it all edges of an element have length one; averaged at vertices.",
        {},
        {}};
    return description;
}

const Description<ConstantMetric>& Described<ConstantMetric>::get() {
    static const Description<ConstantMetric> description{
        "constant", "The same metric everywhere: by sizes or by a tensor.", listed<ConstantMetric>(),
        [](const ConstantMetric& s) -> std::string {
            if (s.sizes.empty() == s.tensor.empty()) return "give either \"sizes\" or \"tensor\"";
            if (!s.tensor.empty() && s.tensor.size() != 3 && s.tensor.size() != 6)
                return "a tensor has 3 entries (2D) or 6 (3D), got " + std::to_string(s.tensor.size());
            return {};
        }};
    return description;
}

const Choice<Metric>& Described<Metric>::get() {
    static const auto choice =
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

const Description<Surrogate>& Described<Surrogate>::get() {
    static const Description<Surrogate> description{
        "surrogate", "A smooth cubic surface through the mesh's own boundary, with ridges and corners kept.", {}, {}};
    return description;
}

const Description<Straight>& Described<Straight>::get() {
    static const Description<Straight> description{
        "straight", "The mesh's own flat facets: the boundary stays as it is.", {}, {}};
    return description;
}

const Description<Plane>& Described<Plane>::get() {
    static const Description<Plane> description{"plane", "A plane (2D: a line).", listed<Plane>(), [](const Plane& s) {
                                                    return check_axis(s.point, s.normal, "the normal");
                                                }};
    return description;
}

const Description<Sphere>& Described<Sphere>::get() {
    static const Description<Sphere> description{"sphere", "A sphere (2D: a circle).", listed<Sphere>(), {}};
    return description;
}

const Description<Cylinder>& Described<Cylinder>::get() {
    static const Description<Cylinder> description{
        "cylinder", "An infinite circular cylinder.", listed<Cylinder>(),
        [](const Cylinder& s) { return check_axis(s.point, s.axis, "the axis"); }};
    return description;
}

const Description<Torus>& Described<Torus>::get() {
    static const Description<Torus> description{"torus", "A ring torus.", listed<Torus>(),
                                                [](const Torus& s) -> std::string {
                                                    if (!(s.minor_radius < s.major_radius))
                                                        return "minor_radius must be below major_radius";
                                                    return check_axis(s.centre, s.axis, "the axis");
                                                }};
    return description;
}

const Choice<Surface>& Described<Surface>::get() {
    static const auto choice = choice_of<Surface>(
        "surface", "the surface's equation", key<Plane>("plane", "a plane"), key<Sphere>("sphere", "a sphere"),
        key<Cylinder>("cylinder", "a cylinder"), key<Torus>("torus", "a torus"));
    return choice;
}

const Description<AnalyticSurface>& Described<AnalyticSurface>::get() {
    using S = AnalyticSurface;
    static const Description<S> description{
        "analytic",
        "An array of surfaces by their equations; boundary facets of other references take the surrogate.",
        {field<S>(option_of(&S::references)),
         [] {
             auto surface = inlined(&S::surface);
             surface.is_required = true;
             return surface;
         }()},
        {}};
    return description;
}

const Description<Cad>& Described<Cad>::get() {
    static const Description<Cad> description{
        "cad",
        "A CAD model (3D), read by OpenCASCADE: facets of the boundary lie on its faces, ridges on its edges, by where "
        "they are; all of them, or those of some references.",
        listed<Cad>(),
        {}};
    return description;
}

const Choice<Geometry>& Described<Geometry>::get() {
    static const auto choice = choice_of<Geometry>(
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

Outcome<Analytic> Codec<Analytic>::read(const Json& json, const Place& place, const Limits&) {
    Limits some;
    some.min_count = 1;
    return Items::read(json, place, some).map([](std::vector<AnalyticSurface> items) {
        return Analytic{std::move(items)};
    });
}
Json Codec<Analytic>::write(const Analytic& analytic) { return Items::write(analytic.surfaces); }
Json Codec<Analytic>::schema(const Limits&) {
    Limits some;
    some.min_count = 1;
    return Items::schema(some);
}
std::string Codec<Analytic>::type(const Limits&) { return "array of surfaces"; }

const Description<BoundaryLayer>& Described<BoundaryLayer>::get() {
    static const Description<BoundaryLayer> description{
        "layer", "Thin layers along a wall, prisms cut to simplices.", listed<BoundaryLayer>(), {}};
    return description;
}

const Description<ShellOptions<3>>& Described<ShellOptions<3>>::get() {
    static const Description<ShellOptions<3>> description{
        "shell", "The volume between two concentric spheres.", listed<ShellOptions<3>>(), {}};
    return description;
}

const Description<ShellOptions<2>>& Described<ShellOptions<2>>::get() {
    static const Description<ShellOptions<2>> description{
        "annulus", "The area between two concentric circles (2D).", listed<ShellOptions<2>>(), {}};
    return description;
}

const Description<BoxOptions<3>>& Described<BoxOptions<3>>::get() {
    static const Description<BoxOptions<3>> description{
        "box", "An axis-aligned box; references 1 to 6 at low x, high x, low y, …", listed<BoxOptions<3>>(), {}};
    return description;
}

const Description<BoxOptions<2>>& Described<BoxOptions<2>>::get() {
    static const Description<BoxOptions<2>> description{
        "rectangle",
        "A rectangle (2D); references 1 to 4 at low x, high x, low y, high y.",
        listed<BoxOptions<2>>(),
        {}};
    return description;
}

const Description<BumpOptions>& Described<BumpOptions>::get() {
    static const Description<BumpOptions> description{
        "bump",
        "A channel with a smooth bump on its floor (2D); references: 1 inlet, 2 outlet, 3 floor, 4 ceiling.",
        listed<BumpOptions>(),
        {}};
    return description;
}

const Choice<Shape>& Described<Shape>::get() {
    static const auto choice = choice_of<Shape>(
        "generate", "A domain that Camber meshes itself.", key<ShellOptions<3>>("shell", "between two spheres"),
        key<ShellOptions<2>>("annulus", "between two circles (2D)"), key<BoxOptions<3>>("box", "a box"),
        key<BoxOptions<2>>("rectangle", "a rectangle (2D)"), key<BumpOptions>("bump", "a channel with a bump (2D)"));
    return choice;
}

}  // namespace camber::config
