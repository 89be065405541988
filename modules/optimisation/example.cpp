// camber.optimisation: finds the position of the inner node of two triangles that maximises their minimum scaled
// Jacobian, with a bound that proves optimality.
#include <cstdio>
#include <span>
#include <utility>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

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
    const auto mesh = elevate(square(), execution);
    if (!mesh) return fail(mesh.error());
    const EdgeId spoke = find_edge(mesh->edges, VertexId(std::size_t{0}), VertexId(std::size_t{4}));

    Buffer<LagrangeNode<2>> nodes(mesh->mid_nodes.begin(), mesh->mid_nodes.end());
    nodes[spoke.index()].point += Vec<2>{{0.5, -0.4}};
    const auto around = shells(mesh->edges, execution);
    if (!around) return fail(around.error());
    const auto best =
        max_min_node(edge_shell<2>(*mesh, std::span<const LagrangeNode<2>>(nodes), (*around)[spoke], spoke));
    if (!best) return false;
    std::printf("scaled Jacobian at least %.6f and at most %.6f with the node at (%.3f, %.3f)\n", best->lower,
                best->upper, best->node.point[0], best->node.point[1]);
    // The other edges of the square are straight, so the optimum is the middle of the spoke.
    return best->lower > 0.99 && distance(best->node.point, Vec<2>{{-0.5, -0.5}}) < 0.01;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
