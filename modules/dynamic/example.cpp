// camber.dynamic: a wheel of ten triangles, and a point put into the middle of one of its spokes: the two triangles
// beside the spoke are taken out, and what is left open is joined to the point.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

import camber.core;
import camber.dynamic;

using namespace camber;

static LinearMesh<2> wheel(std::size_t n) {
    Buffer<Vec<2>> points(n + 1, Vec<2>{});
    Buffer<SimplexVertices<2>> triangles(n);
    Buffer<SimplexVertices<1>> rim(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        points[i] = {{std::cos(angle), std::sin(angle)}};
        rim[i] = {VertexId(i), VertexId((i + 1) % n)};
        triangles[i] = {VertexId(n), rim[i][0], rim[i][1]};
    }
    LinearMesh<2> mesh;
    mesh.points = std::move(points);
    mesh.elements = {std::move(triangles), Buffer<Reference>(n, 1), {}};
    mesh.facets = {std::move(rim), Buffer<Reference>(n, 1), {}};
    return mesh;
}

int main() {
    const Execution all;
    const LinearMesh<2> mesh = wheel(10);
    DynamicMesh<2> dynamic = make_dynamic(mesh, unique_edges(mesh, all).value(), {}, all).value();

    // The cavity of a split: the elements around an edge.
    TopologyPatch<2> patch{dynamic.stamp, {}, {}, {}};
    shell(dynamic, ElementId(0), 0, patch.removed.elements);
    patch.point.place = midpoint(mesh.points[0], mesh.points[10]);
    StarWorkspace<2> workspace;
    if (star(dynamic, patch.removed, patch.point.vertex, workspace, patch.star) != StarFailure::none) return 1;
    auto [changed, changes] = commit<2>(std::move(dynamic), {&patch, 1}).value();

    std::printf("%zu triangles, %zu vertices; %zu triangles and %zu edges are new\n", changed.element_count(),
                changed.vertex_count(), changes.elements.created.size(), changes.edges.created.size());
    return check_consistency(changed, all) && changed.element_count() == 12 ? 0 : 1;
}
