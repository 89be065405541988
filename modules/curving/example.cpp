// Example of camber.curving: a ring with layers thinner than the sagitta of its boundary edges. With straight inner
// edges elements would be inverted. Extending the boundary's displacement into the volume prevents this.
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <utility>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.curving;

using namespace camber;

/// Returns a ring of radii 1 to 2: 8 layers of 16 cells of two triangles.
static LinearMesh<2> ring() {
    Buffer<Vec<2>> points(16 * 9);
    Buffer<SimplexVertices<2>> triangles;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::size_t layer = k / 16, next = k % 16 == 15 ? k - 15 : k + 1;
        const double angle = std::numbers::pi / 8 * static_cast<double>(k % 16);
        points[k] = (1 + static_cast<double>(layer * layer) / 64) * Vec<2>{{camber::cos(angle), camber::sin(angle)}};
        if (layer == 8) continue;
        triangles.push_back({VertexId(k), VertexId(k + 16), VertexId(next + 16)});
        triangles.push_back({VertexId(k), VertexId(next + 16), VertexId(next)});
    }
    LinearMesh<2> mesh;
    mesh.points = std::move(points);
    mesh.point_references = Buffer<Reference>(16 * 9, 0);
    mesh.elements = {std::move(triangles), Buffer<Reference>(2 * 16 * 8, 1), {}};
    return mesh;
}

/// Exits on an error.
template <class T>
static T must(Outcome<T> outcome) {
    if (outcome) return std::move(*outcome);
    std::fprintf(stderr, "%s\n", describe(outcome.error()).c_str());
    std::exit(1);
}

int main() {
    const Execution all;
    const auto mesh = must(elevate(ring(), all));
    // Boundary edges, with one element, connect points of a circle; their nodes are moved to the circle.
    // (camber.surface handles any boundary.)
    const auto shell = must(shells(mesh.edges, all));
    Buffer<EdgeKind> kinds(mesh.edges.size(), EdgeKind::volume);
    Buffer<LagrangeNode<2>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        if (shell[e].size() != 1) continue;
        kinds[e] = EdgeKind::surface;
        nodes[e].point = norm(mesh.linear.points[mesh.edges.vertices[e][0]]) * normalised(nodes[e].point);
    }
    const Column<EdgeKind> kind(std::move(kinds));
    const Column<LagrangeNode<2>> boundary(std::move(nodes));
    const auto straight = must(curve_boundary<2>(mesh, kind, boundary, all));
    const auto extended = must(shape<2>(mesh, kind, boundary, shell, ShapeOptions{}, all));
    const auto before = must(validate(mesh, straight.proposal, 0, all)).validation();
    const auto after = must(validate(mesh, extended.proposal, 0, all)).validation();
    std::printf(
        "inner edges straight: %zu invalid elements; extended and evened out: %zu, smallest scaled Jacobian %.3f\n",
        before.invalid, after.invalid, after.smallest);
    return before.invalid > 0 && after.all_valid() ? 0 : 1;
}
