// camber.validity: one displaced node folds elements of a P2 mesh. `validate` certifies which, and `commit` rejects the
// proposal. A verdict holds for every point of an element, including rounding errors.
#include <cstdio>
#include <utility>

import camber.core;
import camber.bezier;
import camber.validity;

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
    const std::size_t n = mesh->edges.size();
    const EdgeId spoke = find_edge(mesh->edges, VertexId(std::size_t{0}), VertexId(std::size_t{4}));

    // A proposal contains new node positions, judged before they are committed.
    Buffer<LagrangeNode<2>> nodes(mesh->mid_nodes.begin(), mesh->mid_nodes.end());
    nodes[spoke.index()].point += Vec<2>{{0.5, -0.4}};
    Buffer<EdgeKind> kinds(n, EdgeKind::fixed);
    kinds[spoke.index()] = EdgeKind::volume;
    const Proposal<2> proposal{mesh->linear.points, std::move(nodes), std::move(kinds),
                               Buffer<EdgeChange>(n, EdgeChange::optimised)};

    const double bound = 0.1;  // lower bound for det J / |det of the straight element|
    const auto judged = validate(*mesh, proposal, bound, execution);
    if (!judged) return fail(judged.error());
    const Validation<2>& before = judged->validation();
    std::printf("before: %zu of 4 elements invalid, smallest scaled Jacobian %.3f in element %zu\n", before.invalid,
                before.smallest, before.worst.index() + 1);

    const auto refused = commit(*judged);
    if (refused) return false;
    std::printf("commit: %s\n", describe(refused.error()).c_str());

    // A fifth of the displacement keeps all elements valid, so the positions are committed.
    Proposal<2> nearer = proposal;
    Buffer<LagrangeNode<2>> halfway(mesh->mid_nodes.begin(), mesh->mid_nodes.end());
    halfway[spoke.index()].point += Vec<2>{{0.1, -0.08}};
    nearer.mid_nodes = std::move(halfway);
    const auto again = validate(*mesh, std::move(nearer), bound, execution);
    if (!again) return fail(again.error());
    const auto committed = commit(*again);
    return before.invalid > 0 && committed && committed->mesh.mid_nodes[spoke] != mesh->mid_nodes[spoke];
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
