// Descriptions of metrics and of adaptation
module;
#include <algorithm>
#include <string>
#include <string_view>
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

Description Described<SurfaceMetric>::make() {
    return described<SurfaceMetric>(
        "surface",
        "Thin along the normals of the boundary, wide along it, isotropic in the volume; gradation carries it inwards. "
        "At ridges and corners every side's normal is thin.");
}

Description Described<ReferenceSize>::make() {
    return described<ReferenceSize>("sizes", "A size at the vertices of what has one of the references.");
}
Wrapper Described<SizesMetric>::make() {
    return Wrapper(&SizesMetric::sizes, Limits{.min_count = 1, .max_count = 100000}, "array of sizes");
}

Description Described<GeometryMetric>::make() {
    return described<GeometryMetric>(
        "geometry-sizes",
        "Sizes along the boundary by its curvature: that chords stay near to it, and that it turns by no more than an "
        "angle along one; and across the domain where it is thin.");
}

Description Described<SolutionMetric>::make() {
    return described<SolutionMetric>(
        "metric-of-solution",
        "Of all metrics of a complexity the one that interpolates the run's solution best, as camber metric makes it: "
        "docs/algorithms/metric-from-solution.md.",
        [](const SolutionMetric& s) -> std::string {
            if ((s.complexity > 0) + (s.vertices > 0) + (s.elements > 0) > 1)
                return "give one of \"complexity\", \"vertices\" and \"elements\"";
            if (s.gradation > 0 && s.gradation <= 1) return "gradation is a ratio above 1";
            if (s.max_size > 0 && s.max_size < s.min_size) return "max_size is below min_size";
            if (s.max_anisotropy > 0 && s.max_anisotropy < 1) return "max_anisotropy is a ratio of at least 1";
            return {};
        });
}

Description Described<LinearField>::make() {
    return described<LinearField>(
        "linear",
        "UGAWG's linear: thin across a plane of constant z (2D: y), with min_size + 2 (size - min_size) |z - "
        "position| across and size along it.");
}

Description Described<PolarOneField>::make() {
    return described<PolarOneField>("polar-1",
                                    "UGAWG's polar-1: a curved layer, thin along the radius r of the z axis, with "
                                    "min_size + 2 (size - min_size) |r - radius|, and size elsewhere.");
}

Description Described<PolarTwoField>::make() {
    return described<PolarTwoField>("polar-2",
                                    "UGAWG's polar-2: polar-1 with shorter edges around the circle near the layer.");
}

Description Described<PlanarShock>::make() {
    return described<PlanarShock>("planar-shock", "Thin across a plane, where tanh(distance / width) jumps.");
}

Description Described<SphericalShock>::make() {
    return described<SphericalShock>("spherical-shock",
                                     "Thin across a sphere (2D: a circle), where tanh(distance / width) jumps.");
}

Description Described<RotatingField>::make() {
    return described<RotatingField>(
        "rotating", "Constant sizes whose axes turn in the x, y plane with x: by a whole turn over the period.");
}

Choice Described<FieldMetric>::make() {
    return choice_of<FieldMetric>("field", "An analytic metric field; the defaults are those of the benchmarks.",
                                  key<LinearField>("linear", "UGAWG: thin across a plane"),
                                  key<PolarOneField>("polar-1", "UGAWG: thin along the radius"),
                                  key<PolarTwoField>("polar-2", "UGAWG: the same, finer around the circle"),
                                  key<PlanarShock>("planar-shock", "thin where tanh jumps across a plane"),
                                  key<SphericalShock>("spherical-shock", "thin where tanh jumps across a sphere"),
                                  key<RotatingField>("rotating", "axes that turn with x"));
}

Choice Described<MetricExpression>::make() {
    return choice_of<MetricExpression>(
        "expression",
        "Expressions of x, y, z: numbers, + - * / ^, comparisons, c ? a : b, pi, sqrt, exp, log, sin, tanh, atan2, "
        "abs, min, max.",
        key<SizeExpression>("size", "one size in all directions"),
        key<SizesExpression>("sizes", "a size along each axis"),
        key<TensorExpression>("tensor", "entries of the metric, lower triangle by rows: xx, xy, yy, xz, yz, zz"));
}

Choice Described<MetricOperation>::make() {
    return choice_of<MetricOperation>(
        "metric_operations", "One step of what is done to the metric.",
        key<Intersect>("intersect", "with another metric: the largest sizes that both allow"),
        key<Gradation>("gradation", "limit how fast sizes grow"), key<Bound>("bound", "limit sizes and anisotropy"),
        key<Complexity>("complexity", "scale to a wanted number of elements"));
}

Description Described<Gradation>::make() {
    return described<Gradation>("gradation",
                                "Limits how fast sizes grow from vertex to vertex, along every edge; sizes only fall.");
}

Description Described<Bound>::make() {
    return described<Bound>("bound", "Limits sizes, then anisotropy (long sizes become shorter).",
                            [](const Bound& s) -> std::string {
                                if (s.max_size > 0 && s.max_size < s.min_size) return "max_size is below min_size";
                                if (s.max_anisotropy > 0 && s.max_anisotropy < 1)
                                    return "max_anisotropy is a ratio of at least 1";
                                return {};
                            });
}

Description Described<Complexity>::make() {
    return described<Complexity>(
        "complexity",
        "Scales all sizes alike, so that the integral of sqrt(det M) over the mesh is the target: a mesh that fits has "
        "about 12 times as many tetrahedra (2.6 times as many triangles).");
}

Wrapper Described<SizeExpression>::make() { return Wrapper(&SizeExpression::size, {}, "expression"); }

Wrapper Described<SizesExpression>::make() {
    const Limits axes{.min_count = 2, .max_count = 3};
    return Wrapper(&SizesExpression::sizes, axes, list_type("expression", axes));
}

Wrapper Described<TensorExpression>::make() {
    const Limits entries{.min_count = 3, .max_count = 6};
    return Wrapper(&TensorExpression::tensor, entries, list_type("expression", entries));
}

Wrapper Described<Intersect>::make() { return Wrapper(&Intersect::metric); }

namespace {

/// True if any word of the command contains it.
bool has(const std::vector<std::string>& words, std::string_view part) {
    return std::ranges::any_of(words, [&](const std::string& word) { return word.find(part) != std::string::npos; });
}

/// Returns the error of a file's name within a folder; empty if there is none.
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

Description Described<Adaptation>::make() {
    return described<Adaptation>("adapt",
                                 "Cycles of the stages, each on the mesh that the one before made, until that has "
                                 "converged; a solver may be asked for the solution in between. Without a geometry of "
                                 "its own every cycle takes the boundary of the first mesh.",
                                 wrong_with);
}

}  // namespace camber::config
