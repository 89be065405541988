module;
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
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

namespace {

constexpr const char* length = "model units";

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
        "natural", "The mesh's own metric: all edges of each element have length one; averaged at vertices.", {}, {}};
    return description;
}

const Description<ConstantMetric>& Described<ConstantMetric>::get() {
    using S = ConstantMetric;
    static const Description<S> description{
        "constant",
        "The same metric everywhere: by sizes or by a tensor.",
        {field("sizes", &S::sizes, "one edge length, or one along each axis; empty when a tensor is given")
             .unit(length)
             .above(0)
             .count(0, 3),
         field("tensor", &S::tensor,
               "lower triangle by rows: xx, xy, yy (2D) or xx, xy, yy, xz, yz, zz; empty when sizes are given")
             .unit("1 / length²")
             .count(0, 6)},
        [](const S& s) -> std::string {
            if (s.sizes.empty() == s.tensor.empty()) return "give either \"sizes\" or \"tensor\"";
            if (!s.tensor.empty() && s.tensor.size() != 3 && s.tensor.size() != 6)
                return "a tensor has 3 entries (2D) or 6 (3D), got " + std::to_string(s.tensor.size());
            return {};
        }};
    return description;
}

const Choice<Metric>& Described<Metric>::get() {
    static const Choice<Metric> choice{
        "metric",
        "The field of sizes and directions that edges follow.",
        {{"natural", "the mesh's own"},
         {"file", "symmetric tensors at the vertices, from a " + listed(endings_read(solution_formats())) + " file"},
         {"constant", "the same everywhere"},
         {"surface", "thin along the boundary's normals, isotropic in the volume"},
         {"field", "an analytic field, by name"},
         {"expression", "sizes or tensors as expressions of x, y, z"}}};
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
    using S = Plane;
    static const Description<S> description{
        "plane",
        "A plane (2D: a line).",
        {field("point", &S::point, "any point of it").unit(length).count(2, 3).required(),
         field("normal", &S::normal, "perpendicular to it, of any length").count(2, 3).required()},
        [](const S& s) { return check_axis(s.point, s.normal, "the normal"); }};
    return description;
}

const Description<Sphere>& Described<Sphere>::get() {
    using S = Sphere;
    static const Description<S> description{
        "sphere",
        "A sphere (2D: a circle).",
        {field("centre", &S::centre, "its centre; empty: the origin").unit(length).count(0, 3),
         field("radius", &S::radius, "its radius").unit(length).above(0).required()},
        {}};
    return description;
}

const Description<Cylinder>& Described<Cylinder>::get() {
    using S = Cylinder;
    static const Description<S> description{
        "cylinder",
        "An infinite circular cylinder.",
        {field("point", &S::point, "any point of its axis").unit(length).count(3, 3).required(),
         field("axis", &S::axis, "direction of its axis, of any length").count(3, 3).required(),
         field("radius", &S::radius, "its radius").unit(length).above(0).required()},
        [](const S& s) { return check_axis(s.point, s.axis, "the axis"); }};
    return description;
}

const Description<Torus>& Described<Torus>::get() {
    using S = Torus;
    static const Description<S> description{
        "torus",
        "A ring torus.",
        {field("centre", &S::centre, "its centre").unit(length).count(3, 3).required(),
         field("axis", &S::axis, "direction of its axis of rotation, of any length").count(3, 3).required(),
         field("major_radius", &S::major_radius, "from the centre to the middle of the tube")
             .unit(length)
             .above(0)
             .required(),
         field("minor_radius", &S::minor_radius, "radius of the tube").unit(length).above(0).required()},
        [](const S& s) -> std::string {
            if (!(s.minor_radius < s.major_radius)) return "minor_radius must be below major_radius";
            return check_axis(s.centre, s.axis, "the axis");
        }};
    return description;
}

const Choice<Surface>& Described<Surface>::get() {
    static const Choice<Surface> choice{
        "surface",
        "the surface's equation",
        {{"plane", "a plane"}, {"sphere", "a sphere"}, {"cylinder", "a cylinder"}, {"torus", "a torus"}}};
    return choice;
}

const Description<AnalyticSurface>& Described<AnalyticSurface>::get() {
    using S = AnalyticSurface;
    static const Description<S> description{
        "analytic",
        "An array of surfaces by their equations; boundary facets of other references take the surrogate.",
        {field("references", &S::references, "references of the boundary facets on this surface")
             .count(1, 100000)
             .required(),
         [] {
             auto surface = inlined(&S::surface);
             surface.is_required = true;
             return surface;
         }()},
        {}};
    return description;
}

const Choice<Geometry>& Described<Geometry>::get() {
    static const Choice<Geometry> choice{
        "geometry",
        "The shape that boundary nodes are put onto.",
        {{"surrogate", "a smooth surface through the mesh's boundary"},
         {"straight", "the flat facets themselves"},
         {"analytic", "spheres, planes, cylinders, tori by reference, the surrogate on all others"}}};
    return choice;
}

Outcome<Analytic> Codec<Analytic>::read(const Json& json, const Place& place, const Limits&) {
    Limits some;
    some.least_count = 1;
    return Items::read(json, place, some).map([](std::vector<AnalyticSurface> items) {
        return Analytic{std::move(items)};
    });
}
Json Codec<Analytic>::write(const Analytic& analytic) { return Items::write(analytic.surfaces); }
Json Codec<Analytic>::schema(const Limits&) {
    Limits some;
    some.least_count = 1;
    return Items::schema(some);
}
std::string Codec<Analytic>::type(const Limits&) { return "array of surfaces"; }

}  // namespace camber::config
