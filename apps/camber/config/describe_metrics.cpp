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
        "Small sizes along the normals of the boundary, large sizes along the boundary, isotropic in the volume. "
        "Gradation extends the small sizes into the volume. At ridges and corners the sizes are small along the "
        "normals of all sides.");
}

Description Described<ReferenceSize>::make() {
    return described<ReferenceSize>("sizes",
                                    "A size at the vertices of all facets, edges, vertices or elements with "
                                    "one of the references.");
}
Wrapper Described<SizesMetric>::make() {
    return Wrapper(&SizesMetric::sizes, Limits{.min_count = 1, .max_count = 100000}, "array of sizes");
}

Description Described<GeometryMetric>::make() {
    return described<GeometryMetric>(
        "geometry-sizes",
        "Sizes along the boundary by its curvature: they limit the distance of chords from the boundary and the angle "
        "by which the boundary turns along a chord. Sizes across the domain where it is thin.");
}

Description Described<SolutionMetric>::make() {
    return described<SolutionMetric>(
        "metric-of-solution",
        "The metric of the given complexity that interpolates the run's solution best, as computed by camber metric: "
        "docs/algorithms/metric-from-solution.md.",
        [](const SolutionMetric& s) -> std::string {
            if ((s.complexity > 0) + (s.vertices > 0) + (s.elements > 0) > 1)
                return "give only one of \"complexity\", \"vertices\" and \"elements\"";
            if (s.gradation > 0 && s.gradation <= 1) return "gradation must be above 1";
            if (s.max_size > 0 && s.max_size < s.min_size) return "max_size must be at least min_size";
            if (s.max_anisotropy > 0 && s.max_anisotropy < 1) return "max_anisotropy must be at least 1";
            return {};
        });
}

Description Described<LinearField>::make() {
    return described<LinearField>(
        "linear",
        "Metric \"linear\" of UGAWG: small sizes across a plane of constant z (2D: y). The size across it is min_size "
        "+ 2 (size - min_size) |z - position|, the size along it is size.");
}

Description Described<PolarOneField>::make() {
    return described<PolarOneField>("polar-1",
                                    "Metric \"polar-1\" of UGAWG: a curved layer with small sizes along the radius r "
                                    "of the z axis. The size along r is min_size + 2 (size - min_size) |r - radius|, "
                                    "the other sizes are size.");
}

Description Described<PolarTwoField>::make() {
    return described<PolarTwoField>("polar-2",
                                    "Metric \"polar-2\" of UGAWG: polar-1 with shorter edges around the circle near "
                                    "the layer.");
}

Description Described<PlanarShock>::make() {
    return described<PlanarShock>("planar-shock",
                                  "Small sizes across a plane, where tanh(distance / width) changes "
                                  "steeply.");
}

Description Described<SphericalShock>::make() {
    return described<SphericalShock>("spherical-shock",
                                     "Small sizes across a sphere (2D: a circle), where tanh(distance / width) changes "
                                     "steeply.");
}

Description Described<RotatingField>::make() {
    return described<RotatingField>(
        "rotating",
        "Constant sizes along axes that rotate in the x, y plane with x, by a full rotation over the "
        "period.");
}

Choice Described<FieldMetric>::make() {
    return choice_of<FieldMetric>("field", "An analytic metric field. The defaults are the values of the benchmarks.",
                                  key<LinearField>("linear", "UGAWG: small sizes across a plane"),
                                  key<PolarOneField>("polar-1", "UGAWG: small sizes along the radius"),
                                  key<PolarTwoField>("polar-2", "UGAWG: polar-1, finer around the circle"),
                                  key<PlanarShock>("planar-shock",
                                                   "small sizes across a plane, where tanh changes "
                                                   "steeply"),
                                  key<SphericalShock>("spherical-shock",
                                                      "small sizes across a sphere, where tanh "
                                                      "changes steeply"),
                                  key<RotatingField>("rotating", "axes that rotate with x"));
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
        "metric_operations", "One operation on the metric.",
        key<Intersect>("intersect", "intersect with another metric: the largest sizes that both allow"),
        key<Gradation>("gradation", "limit the growth of sizes"), key<Bound>("bound", "limit sizes and anisotropy"),
        key<Complexity>("complexity", "scale to a target number of elements"));
}

Description Described<Gradation>::make() {
    return described<Gradation>(
        "gradation", "Limits the growth of sizes between the ends of every edge. Sizes only become smaller.");
}

Description Described<Bound>::make() {
    return described<Bound>("bound", "Limits sizes, then anisotropy, by shortening the largest sizes.",
                            [](const Bound& s) -> std::string {
                                if (s.max_size > 0 && s.max_size < s.min_size)
                                    return "max_size must be at least min_size";
                                if (s.max_anisotropy > 0 && s.max_anisotropy < 1)
                                    return "max_anisotropy must be at least 1";
                                return {};
                            });
}

Description Described<Complexity>::make() {
    return described<Complexity>(
        "complexity",
        "Scales all sizes by one factor, so that the integral of sqrt(det M) over the mesh is the target. A mesh of "
        "unit edges has about 12 times as many tetrahedra, or 2.6 times as many triangles.");
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

bool has(const std::vector<std::string>& words, std::string_view part) {
    return std::ranges::any_of(words, [&](const std::string& word) { return word.find(part) != std::string::npos; });
}

/// Returns the error; empty: the name is valid.
std::string wrong_name(const char* what, const std::string& name) {
    if (name.empty() || name.find('/') != std::string::npos || name.front() == '.')
        return in_quotes(what) + " must be a file name without a folder, not starting with a dot, got " +
               in_quotes(name);
    return {};
}

std::string wrong_with(const Adaptation& a) {
    for (const std::string_view needed : {"{mesh}", "{solution}"})
        if (!a.solve.empty() && !has(a.solve, needed))
            return "\"solve\" has no " + std::string(needed) + ": it specifies the file that the command " +
                   (needed == "{mesh}" ? "reads" : "writes");
    if (auto wrong = wrong_name("mesh", a.mesh); !wrong.empty()) return wrong;
    if (auto wrong = wrong_name("solution", a.solution); !wrong.empty()) return wrong;
    if (a.mesh == a.solution) return "\"mesh\" and \"solution\" must be different files";
    if (!format_to_write(mesh_formats(), a.mesh))
        return "\"mesh\" must end in " + camber::listed(writable_extensions(mesh_formats())) + ", got " +
               in_quotes(a.mesh);
    return {};
}

}  // namespace

Description Described<Adaptation>::make() {
    return described<Adaptation>("adapt",
                                 "Repeats the stages in cycles, each on the mesh of the previous cycle, until the "
                                 "error has converged. A solver can compute the solution of each cycle. If no geometry "
                                 "is specified, all cycles use the boundary of the first mesh.",
                                 wrong_with);
}

}  // namespace camber::config
