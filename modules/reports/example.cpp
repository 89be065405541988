// Example of camber.reports: checks a mesh, prints the result as a table and draws it.
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.bezier;
import camber.drawing;
import camber.io;
import camber.recipes;
import camber.reports;

using namespace camber;

static Outcome<Mesh<2>> square(const Execution& execution) {
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
    const auto v = [](std::size_t i) { return VertexId(i); };
    mesh.elements.vertices = Buffer<SimplexVertices<2>>{{v(0), v(1), v(2)}, {v(0), v(2), v(3)}};
    mesh.point_references = Buffer<Reference>(4, 0);
    mesh.elements.references = Buffer<Reference>{1, 2};
    return elevate(as_mesh(std::move(mesh)), 2, execution);
}

static Outcome<bool> example(const Execution& execution) {
    auto mesh = square(execution);
    if (!mesh) return fail(mesh.error());
    const DecodedMesh input{.mesh = std::move(*mesh), .notices = {}};
    const auto report = run::check_mesh(input, {}, {}, without_wrapper(execution));
    if (!report) return fail(report.error());
    const auto picture = run::picture_of({.mesh = input}, {.width = 400, .height = 300}, execution);
    if (!picture) return fail(picture.error());
    const auto svg = svg_of(picture->scene, execution);
    if (!svg) return fail(svg.error());
    std::printf("%s%zu bytes of SVG\n", run::check_table(*report).c_str(), svg->size());
    return report->all_good() && svg->starts_with("<svg");
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
