// camber.cavity: a ring whose layers are thinner than its boundary edges bulge. Cavity by cavity, boundary edges go
// onto their circles, and inner ones where the mesh's own metric asks for them; no element ever becomes invalid.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <utility>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.cavity;

using namespace camber;

/// The ring of radii 1 to 2: 8 layers, thin inside, of 16 cells of two triangles.
static LinearMesh<2> ring() {
    Buffer<Vec<2>> points(16 * 9);
    Buffer<SimplexVertices<2>> triangles;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::size_t layer = k / 16, next = k % 16 == 15 ? k - 15 : k + 1;
        const double angle = std::numbers::pi / 8 * static_cast<double>(k % 16);
        points[k] = (1 + static_cast<double>(layer * layer) / 64) * Vec<2>{{std::cos(angle), std::sin(angle)}};
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

/// The value of an outcome; a program may end where a library would hand the error on.
template <class T>
static T must(Outcome<T> outcome) {
    if (outcome) return std::move(*outcome);
    std::fprintf(stderr, "%s\n", describe(outcome.error()).c_str());
    std::exit(1);
}

int main() {
    const Execution all;
    const auto mesh = must(elevate(ring(), all));
    // The field that the edges follow: the mesh's natural metric, in which its elements are unit.
    const auto ball = must(balls(mesh.linear, all));
    const auto back =
        must(make_back_mesh<2>(mesh.linear, ball, must(natural_log_metrics(mesh.linear, ball, all)), all));
    // An edge of one element is on a circle, and so must be its node. (camber.surface knows that of any boundary.)
    const auto shell = must(shells(mesh.edges, all));
    Buffer<EdgeKind> kinds(mesh.edges.size(), EdgeKind::volume);
    Buffer<LagrangeNode<2>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        if (shell[e].size() != 1) continue;
        kinds[e] = EdgeKind::surface;
        nodes[e].point = norm(mesh.linear.points[mesh.edges.vertices[e][0]]) * normalised(nodes[e].point);
    }
    const auto curved = must(reinsert_all<2>(mesh, std::move(kinds), std::move(nodes), back, {}, all));
    const auto wished = must(validate(mesh, curved.wanted.proposal, 0, all)).validation();
    const auto result = must(validate(curved.mesh, 0, all));
    std::printf("all edges curved at once: %zu invalid elements; cavity by cavity, in %zu patches: %zu\n",
                wished.invalid, curved.statistics.patches, result.invalid);
    return wished.invalid > 0 && result.all_valid() ? 0 : 1;
}
