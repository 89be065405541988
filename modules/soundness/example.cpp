// Example of camber.soundness: a square of four triangles, one of them reversed, without boundary facets. `examine`
// reports these defects, `prepare` corrects them.
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.soundness;

using namespace camber;

static Mesh<2> square() {
    const auto v = [](std::size_t i) { return VertexId(i); };
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{-1, -1}}, {{1, -1}}, {{1, 1}}, {{-1, 1}}, {{0, 0}}};
    mesh.point_references = Buffer<Reference>(5, 0);
    mesh.elements.vertices =
        Buffer<SimplexVertices<2>>{{v(0), v(1), v(4)}, {v(1), v(2), v(4)}, {v(2), v(3), v(4)}, {v(0), v(3), v(4)}};
    mesh.elements.references = Buffer<Reference>(4, 1);
    return as_mesh(std::move(mesh));
}

static Outcome<bool> example(const Execution& execution) {
    const auto before = examine(square(), execution);
    if (!before) return fail(before.error());
    for (const Defect defect : {Defect::reversed_element, Defect::no_facets})
        if ((*before)[defect].count > 0) std::printf("%s\n", sentence(*before, defect).c_str());
    const auto prepared = prepare(square(), execution);
    if (!prepared) return fail(prepared.error());
    for (const auto& notice : prepared->notices) std::printf("%s\n", notice.c_str());
    const auto after = examine(prepared->mesh, execution);
    if (!after) return fail(after.error());
    return !before->sound() && after->sound() && prepared->mesh.facets.of<Shape::line>().size() == 4;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
