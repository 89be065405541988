// camber.repair: one displaced node folds an element of a P2 mesh. One call finds the element and moves the node back
// by a small distance; the boundary stays.
#include <cstdio>
#include <utility>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.repair;

using namespace camber;

/// Four triangles around vertex 4.
static LinearMesh<2> square() {
    const auto v = [](std::size_t i) { return VertexId(i); };
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{-1, -1}}, {{1, -1}}, {{1, 1}}, {{-1, 1}}, {{0, 0}}};
    mesh.point_references = Buffer<Reference>(5, 0);
    mesh.elements.vertices =
        Buffer<SimplexVertices<2>>{{v(0), v(1), v(4)}, {v(1), v(2), v(4)}, {v(2), v(3), v(4)}, {v(3), v(0), v(4)}};
    mesh.elements.references = Buffer<Reference>(4, 1);
    return mesh;
}

static Outcome<bool> example(const Execution& execution) {
    auto mesh = elevate(square(), execution);
    if (!mesh) return fail(mesh.error());
    const EdgeId spoke = find_edge(mesh->edges, VertexId(std::size_t{0}), VertexId(std::size_t{4}));
    auto nodes = take(mesh->mid_nodes);
    nodes[spoke.index()].point += Vec<2>{{0.5, -0.4}};
    mesh->mid_nodes = std::move(nodes);

    const auto repaired = repair_mesh(as_mesh(*mesh), {.repair = {.min_scaled_jacobian = 0.1}}, execution);
    if (!repaired) return fail(repaired.error());
    const Vec<2>& node = repaired->mesh.edge_nodes[spoke.index()].point;
    std::printf(
        "%zu of 4 elements invalid, smallest scaled Jacobian %.3f; repaired: %zu, %.3f, the node at (%.3f, %.3f)\n",
        repaired->before.invalid, repaired->before.smallest, repaired->after.invalid, repaired->after.smallest, node[0],
        node[1]);
    return repaired->before.invalid > 0 && repaired->after.all_valid();
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
