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
import camber.fields;
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

namespace {

constexpr const char* length = "model units";

template <class S>
Field<S> size_field(std::string name, double S::* member, std::string doc) {
    return field(std::move(name), member, std::move(doc)).unit(length).above(0);
}
template <class S>
Field<S> scale_field() {
    return field("scale", &S::scale, "all sizes times this").above(0);
}

Limits counted(std::size_t least, std::size_t most) {
    Limits limits;
    limits.least_count = least;
    limits.most_count = most;
    return limits;
}

using Strings = Codec<std::vector<std::string>>;
const Limits axes = counted(2, 3);
const Limits entries = counted(3, 6);

}  // namespace

const Description<SurfaceMetric>& Described<SurfaceMetric>::get() {
    using S = SurfaceMetric;
    static const Description<S> description{
        "surface",
        "Thin along the normals of the boundary, wide along it, isotropic in the volume; gradation carries it inwards. "
        "At ridges and corners every side's normal is thin.",
        {size_field("tangent_size", &S::tangent_size, "size along the boundary").required(),
         size_field("normal_size", &S::normal_size, "size across it; a tenth of tangent_size curves well").required(),
         field("volume_size", &S::volume_size, "size in the volume; 0: tangent_size").unit(length).at_least(0)},
        {}};
    return description;
}

const Description<LinearField>& Described<LinearField>::get() {
    using S = LinearField;
    static const Description<S> description{
        "linear",
        "UGAWG's linear: thin across a plane of constant z (2D: y), with least_size + 2 (size - least_size) |z - "
        "position| across and size along it.",
        {size_field("least_size", &S::least_size, "size across, at the plane"),
         size_field("size", &S::size, "size along, and across at a distance of 1/2"),
         field("position", &S::position, "z (2D: y) of the plane").unit(length), scale_field<S>()},
        {}};
    return description;
}

const Description<PolarOneField>& Described<PolarOneField>::get() {
    using S = PolarOneField;
    static const Description<S> description{
        "polar-1",
        "UGAWG's polar-1: a curved layer, thin along the radius r of the z axis, with least_size + 2 (size - "
        "least_size) |r - radius|, and size elsewhere.",
        {size_field("least_size", &S::least_size, "size along the radius, in the layer"),
         size_field("size", &S::size, "size along the layer"), size_field("radius", &S::radius, "of the layer"),
         scale_field<S>()},
        {}};
    return description;
}

const Description<PolarTwoField>& Described<PolarTwoField>::get() {
    using S = PolarTwoField;
    static const Description<S> description{
        "polar-2",
        "UGAWG's polar-2: polar-1 with shorter edges around the circle near the layer.",
        {size_field("least_size", &S::least_size, "size along the radius, in the layer"),
         size_field("tangential_size", &S::tangential_size, "size around the circle, in the layer"),
         size_field("size", &S::size, "size along z, and around the circle away from the layer"),
         size_field("radius", &S::radius, "of the layer"),
         size_field("layer_width", &S::layer_width, "distance from which the size around the circle is `size`"),
         scale_field<S>()},
        {}};
    return description;
}

const Description<PlanarShock>& Described<PlanarShock>::get() {
    using S = PlanarShock;
    static const Description<S> description{
        "planar-shock",
        "Thin across a plane, where tanh(distance / width) jumps.",
        {field("point", &S::point, "any point of the plane").unit(length).count(2, 3).required(),
         field("normal", &S::normal, "perpendicular to it, of any length").count(2, 3).required(),
         size_field("least_size", &S::least_size, "size along the normal, at the plane"),
         size_field("size", &S::size, "size along the plane, and everywhere away from it"),
         size_field("width", &S::width, "of the jump")},
        {}};
    return description;
}

const Description<SphericalShock>& Described<SphericalShock>::get() {
    using S = SphericalShock;
    static const Description<S> description{
        "spherical-shock",
        "Thin across a sphere (2D: a circle), where tanh(distance / width) jumps.",
        {field("centre", &S::centre, "of the sphere").unit(length).count(2, 3).required(),
         size_field("radius", &S::radius, "of the sphere"),
         size_field("least_size", &S::least_size, "size along the radius, at the sphere"),
         size_field("size", &S::size, "size along the sphere, and everywhere away from it"),
         size_field("width", &S::width, "of the jump")},
        {}};
    return description;
}

const Description<RotatingField>& Described<RotatingField>::get() {
    using S = RotatingField;
    static const Description<S> description{
        "rotating",
        "Constant sizes whose axes turn in the x, y plane with x: by a whole turn over the period.",
        {size_field("least_size", &S::least_size, "size along the turning axis"),
         size_field("size", &S::size, "size across it"), size_field("period", &S::period, "of a whole turn")},
        {}};
    return description;
}

const Choice<FieldMetric>& Described<FieldMetric>::get() {
    static const Choice<FieldMetric> choice{"field",
                                            "An analytic metric field; the defaults are those of the benchmarks.",
                                            {{"linear", "UGAWG: thin across a plane"},
                                             {"polar-1", "UGAWG: thin along the radius"},
                                             {"polar-2", "UGAWG: the same, finer around the circle"},
                                             {"planar-shock", "thin where tanh jumps across a plane"},
                                             {"spherical-shock", "thin where tanh jumps across a sphere"},
                                             {"rotating", "axes that turn with x"}}};
    return choice;
}

const Choice<MetricExpression>& Described<MetricExpression>::get() {
    static const Choice<MetricExpression> choice{
        "expression",
        "Expressions of x, y, z: numbers, + - * / ^, comparisons, c ? a : b, pi, sqrt, exp, log, sin, tanh, atan2, "
        "abs, "
        "min, max.",
        {{"size", "one size in all directions"},
         {"sizes", "a size along each axis"},
         {"tensor", "entries of the metric, lower triangle by rows: xx, xy, yy, xz, yz, zz"}}};
    return choice;
}

const Choice<MetricOperation>& Described<MetricOperation>::get() {
    static const Choice<MetricOperation> choice{
        "metric_operations",
        "One step of what is done to the metric.",
        {{"intersect", "with another metric: the largest sizes that both allow"},
         {"gradation", "limit how fast sizes grow"},
         {"bound", "limit sizes and anisotropy"},
         {"complexity", "scale to a wanted number of elements"}}};
    return choice;
}

const Words& Described<GradationSpace>::get() {
    static const Words words{{"metric", "physical", "mixed"}};
    return words;
}

const Description<Gradation>& Described<Gradation>::get() {
    using S = Gradation;
    static const Description<S> description{
        "gradation",
        "Limits how fast sizes grow from vertex to vertex, along every edge; sizes only fall.",
        {field("ratio", &S::ratio, "largest ratio of the sizes of adjacent edges").above(1).at_most(1000),
         field("space", &S::space,
               "metric: all sizes grow alike, anisotropy is kept; physical: each with the distance, towards isotropy; "
               "mixed: between the two"),
         field("physical_share", &S::physical_share, "mixed only: 0 is metric, 1 physical").at_least(0).at_most(1),
         field("max_sweeps", &S::max_sweeps, "largest number of sweeps over the mesh").at_least(1).at_most(1000000)},
        {}};
    return description;
}

const Description<Bound>& Described<Bound>::get() {
    using S = Bound;
    static const Description<S> description{
        "bound",
        "Limits sizes, then anisotropy (long sizes become shorter).",
        {field("min_size", &S::min_size, "smallest size; 0: none").unit(length).at_least(0),
         field("max_size", &S::max_size, "largest size; 0: none").unit(length).at_least(0),
         field("max_anisotropy", &S::max_anisotropy, "largest ratio of sizes; 0: none").at_least(0)},
        [](const S& s) -> std::string {
            if (s.max_size > 0 && s.max_size < s.min_size) return "max_size is below min_size";
            if (s.max_anisotropy > 0 && s.max_anisotropy < 1) return "max_anisotropy is a ratio of at least 1";
            return {};
        }};
    return description;
}

const Description<Complexity>& Described<Complexity>::get() {
    using S = Complexity;
    static const Description<S> description{
        "complexity",
        "Scales all sizes alike, so that the integral of sqrt(det M) over the mesh is the target: a mesh that fits has "
        "about 8.5 times as many tetrahedra (2.3 times as many triangles).",
        {field("target", &S::target, "the wanted complexity").above(0).required()},
        {}};
    return description;
}

Outcome<SizeExpression> Codec<SizeExpression>::read(const Json& json, const Place& place, const Limits& limits) {
    return Codec<std::string>::read(json, place, limits).map([](std::string s) {
        return SizeExpression{std::move(s)};
    });
}
Json Codec<SizeExpression>::schema(const Limits& limits) { return Codec<std::string>::schema(limits); }
std::string Codec<SizeExpression>::type(const Limits&) { return "expression"; }

Outcome<SizesExpression> Codec<SizesExpression>::read(const Json& json, const Place& place, const Limits&) {
    return Strings::read(json, place, axes).map([](std::vector<std::string> s) {
        return SizesExpression{std::move(s)};
    });
}
Json Codec<SizesExpression>::schema(const Limits&) { return Strings::schema(axes); }
std::string Codec<SizesExpression>::type(const Limits&) { return array_type("expression", axes); }

Outcome<TensorExpression> Codec<TensorExpression>::read(const Json& json, const Place& place, const Limits&) {
    return Strings::read(json, place, entries).map([](std::vector<std::string> s) {
        return TensorExpression{std::move(s)};
    });
}
Json Codec<TensorExpression>::schema(const Limits&) { return Strings::schema(entries); }
std::string Codec<TensorExpression>::type(const Limits&) { return array_type("expression", entries); }

Outcome<Intersect> Codec<Intersect>::read(const Json& json, const Place& place, const Limits& limits) {
    return Codec<Metric>::read(json, place, limits).map([](Metric metric) { return Intersect{std::move(metric)}; });
}
Json Codec<Intersect>::write(const Intersect& intersect) { return Codec<Metric>::write(intersect.metric); }
Json Codec<Intersect>::schema(const Limits& limits) { return Codec<Metric>::schema(limits); }
std::string Codec<Intersect>::type(const Limits& limits) { return Codec<Metric>::type(limits); }

}  // namespace camber::config
