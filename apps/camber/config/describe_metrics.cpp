// Descriptions of metrics and of adaptation
module;
#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.metric;
import camber.solution_metric;
import camber.io;
import camber.fields;
import camber.recipes;
import :codec;
import :description;

namespace camber::config {

namespace {

Limits counted(std::size_t least, std::size_t most) {
    Limits limits;
    limits.min_count = least;
    limits.max_count = most;
    return limits;
}

using Strings = Codec<std::vector<std::string>>;
const Limits axes = counted(2, 3);
const Limits entries = counted(3, 6);

}  // namespace

const Description<SurfaceMetric>& Described<SurfaceMetric>::get() {
    static const Description<SurfaceMetric> description{
        "surface",
        "Thin along the normals of the boundary, wide along it, isotropic in the volume; gradation carries it inwards. "
        "At ridges and corners every side's normal is thin.",
        listed<SurfaceMetric>(),
        {}};
    return description;
}

const Description<ReferenceSize>& Described<ReferenceSize>::get() {
    static const Description<ReferenceSize> description{
        "sizes", "A size at the vertices of what has one of the references.", listed<ReferenceSize>(), {}};
    return description;
}
Outcome<SizesMetric> Codec<SizesMetric>::read(const Json& json, const Place& place, const Limits&) {
    return Items::read(json, place, counted(1, 100000)).map([](std::vector<ReferenceSize> sizes) {
        return SizesMetric{std::move(sizes)};
    });
}
Json Codec<SizesMetric>::write(const SizesMetric& metric) { return Items::write(metric.sizes); }
Json Codec<SizesMetric>::schema(const Limits&) { return Items::schema(counted(1, 100000)); }
std::string Codec<SizesMetric>::type(const Limits&) { return "array of sizes"; }

const Description<GeometryMetric>& Described<GeometryMetric>::get() {
    static const Description<GeometryMetric> description{
        "geometry-sizes",
        "Sizes along the boundary by its curvature: that chords stay near to it, and that it turns by no more than an "
        "angle along one; and across the domain where it is thin.",
        listed<GeometryMetric>(),
        {}};
    return description;
}

const Description<SolutionMetric>& Described<SolutionMetric>::get() {
    static const Description<SolutionMetric> description{
        "metric-of-solution",
        "Of all metrics of a complexity the one that interpolates the run's solution best, as camber metric makes it: "
        "docs/algorithms/metric-from-solution.md.",
        listed<SolutionMetric>(), [](const SolutionMetric& s) -> std::string {
            if ((s.complexity > 0) + (s.vertices > 0) + (s.elements > 0) > 1)
                return "give one of \"complexity\", \"vertices\" and \"elements\"";
            if (s.gradation > 0 && s.gradation <= 1) return "gradation is a ratio above 1";
            if (s.max_size > 0 && s.max_size < s.min_size) return "max_size is below min_size";
            if (s.max_anisotropy > 0 && s.max_anisotropy < 1) return "max_anisotropy is a ratio of at least 1";
            return {};
        }};
    return description;
}

const Description<LinearField>& Described<LinearField>::get() {
    static const Description<LinearField> description{
        "linear",
        "UGAWG's linear: thin across a plane of constant z (2D: y), with min_size + 2 (size - min_size) |z - "
        "position| across and size along it.",
        listed<LinearField>(),
        {}};
    return description;
}

const Description<PolarOneField>& Described<PolarOneField>::get() {
    static const Description<PolarOneField> description{
        "polar-1",
        "UGAWG's polar-1: a curved layer, thin along the radius r of the z axis, with min_size + 2 (size - "
        "min_size) |r - radius|, and size elsewhere.",
        listed<PolarOneField>(),
        {}};
    return description;
}

const Description<PolarTwoField>& Described<PolarTwoField>::get() {
    static const Description<PolarTwoField> description{
        "polar-2",
        "UGAWG's polar-2: polar-1 with shorter edges around the circle near the layer.",
        listed<PolarTwoField>(),
        {}};
    return description;
}

const Description<PlanarShock>& Described<PlanarShock>::get() {
    static const Description<PlanarShock> description{
        "planar-shock", "Thin across a plane, where tanh(distance / width) jumps.", listed<PlanarShock>(), {}};
    return description;
}

const Description<SphericalShock>& Described<SphericalShock>::get() {
    static const Description<SphericalShock> description{
        "spherical-shock",
        "Thin across a sphere (2D: a circle), where tanh(distance / width) jumps.",
        listed<SphericalShock>(),
        {}};
    return description;
}

const Description<RotatingField>& Described<RotatingField>::get() {
    static const Description<RotatingField> description{
        "rotating",
        "Constant sizes whose axes turn in the x, y plane with x: by a whole turn over the period.",
        listed<RotatingField>(),
        {}};
    return description;
}

const Choice<FieldMetric>& Described<FieldMetric>::get() {
    static const auto choice =
        choice_of<FieldMetric>("field", "An analytic metric field; the defaults are those of the benchmarks.",
                               key<LinearField>("linear", "UGAWG: thin across a plane"),
                               key<PolarOneField>("polar-1", "UGAWG: thin along the radius"),
                               key<PolarTwoField>("polar-2", "UGAWG: the same, finer around the circle"),
                               key<PlanarShock>("planar-shock", "thin where tanh jumps across a plane"),
                               key<SphericalShock>("spherical-shock", "thin where tanh jumps across a sphere"),
                               key<RotatingField>("rotating", "axes that turn with x"));
    return choice;
}

const Choice<MetricExpression>& Described<MetricExpression>::get() {
    static const auto choice = choice_of<MetricExpression>(
        "expression",
        "Expressions of x, y, z: numbers, + - * / ^, comparisons, c ? a : b, pi, sqrt, exp, log, sin, tanh, atan2, "
        "abs, "
        "min, max.",
        key<SizeExpression>("size", "one size in all directions"),
        key<SizesExpression>("sizes", "a size along each axis"),
        key<TensorExpression>("tensor", "entries of the metric, lower triangle by rows: xx, xy, yy, xz, yz, zz"));
    return choice;
}

const Choice<MetricOperation>& Described<MetricOperation>::get() {
    static const auto choice = choice_of<MetricOperation>(
        "metric_operations", "One step of what is done to the metric.",
        key<Intersect>("intersect", "with another metric: the largest sizes that both allow"),
        key<Gradation>("gradation", "limit how fast sizes grow"), key<Bound>("bound", "limit sizes and anisotropy"),
        key<Complexity>("complexity", "scale to a wanted number of elements"));
    return choice;
}

const Description<Gradation>& Described<Gradation>::get() {
    static const Description<Gradation> description{
        "gradation",
        "Limits how fast sizes grow from vertex to vertex, along every edge; sizes only fall.",
        listed<Gradation>(),
        {}};
    return description;
}

const Description<Bound>& Described<Bound>::get() {
    static const Description<Bound> description{"bound", "Limits sizes, then anisotropy (long sizes become shorter).",
                                                listed<Bound>(), [](const Bound& s) -> std::string {
                                                    if (s.max_size > 0 && s.max_size < s.min_size)
                                                        return "max_size is below min_size";
                                                    if (s.max_anisotropy > 0 && s.max_anisotropy < 1)
                                                        return "max_anisotropy is a ratio of at least 1";
                                                    return {};
                                                }};
    return description;
}

const Description<Complexity>& Described<Complexity>::get() {
    static const Description<Complexity> description{
        "complexity",
        "Scales all sizes alike, so that the integral of sqrt(det M) over the mesh is the target: a mesh that fits has "
        "about 12 times as many tetrahedra (2.6 times as many triangles).",
        listed<Complexity>(),
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

namespace {

/// Whether any of the command's words has it.
bool has(const std::vector<std::string>& words, std::string_view part) {
    return std::ranges::any_of(words, [&](const std::string& word) { return word.find(part) != std::string::npos; });
}

/// What is wrong with the name of a file within a folder.
std::string wrong_name(const char* what, const std::string& name) {
    if (name.empty() || name.find('/') != std::string::npos || name.front() == '.')
        return in_quotes(what) + " is the name of a file within a cycle's folder, got " + in_quotes(name);
    return {};
}

std::string wrong_with(const Adaptation& a) {
    for (const std::string_view needed : {"{mesh}", "{solution}"})
        if (!a.solve.empty() && !has(a.solve, needed))
            return "\"solve\" has no " + std::string(needed) + ": the command is to be told which file it " +
                   (needed == "{mesh}" ? "reads" : "writes");
    if (auto wrong = wrong_name("mesh", a.mesh); !wrong.empty()) return wrong;
    if (auto wrong = wrong_name("solution", a.solution); !wrong.empty()) return wrong;
    if (a.mesh == a.solution) return "\"mesh\" and \"solution\" are one file";
    if (!format_to_write(mesh_formats(), a.mesh))
        return "\"mesh\" must end in " + camber::listed(endings_written(mesh_formats())) + ", got " + in_quotes(a.mesh);
    return {};
}

}  // namespace

const Description<Adaptation>& Described<Adaptation>::get() {
    static const Description<Adaptation> description{
        "adapt",
        "Cycles of the stages, each on the mesh that the one before made, until that has settled; a solver may be "
        "asked "
        "for the solution in between. Without a geometry of its own every cycle takes the boundary of the first mesh.",
        listed<Adaptation>(), wrong_with};
    return description;
}

}  // namespace camber::config
