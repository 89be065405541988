// Example of camber.cavity: inserts a point into a spoke of a wheel of ten triangles. Removes the two triangles at the
// spoke and joins their open edges to the point.
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <utility>

import camber.core;
import camber.cavity;

using namespace camber;

int main() {
    Buffer<Vec<2>> points(11, Vec<2>{});  // the last point is the hub
    Buffer<SimplexVertices<2>> triangles(10);
    Buffer<SimplexVertices<1>> rim(10);
    for (std::size_t i = 0; i < 10; ++i) {
        const double angle = static_cast<double>(i) * std::numbers::pi / 5;
        points[i] = {{camber::cos(angle), camber::sin(angle)}};
        rim[i] = {VertexId(i), VertexId((i + 1) % 10)};
        triangles[i] = {VertexId(10), rim[i][0], rim[i][1]};
    }
    LinearMesh<2> wheel;
    wheel.points = std::move(points);
    wheel.elements = {std::move(triangles), Buffer<Reference>(10, 1), {}};
    wheel.facets = {std::move(rim), Buffer<Reference>(10, 1), {}};
    DynamicMesh<2> mesh = make_dynamic(wheel, unique_edges(wheel, {}).value(), {}, {}).value();

    // The point is the middle of a spoke, which belongs to two triangles.
    Cavity<2> cavity;
    cavity_of_edge(mesh, ElementId(0), edge_between<2>[0][1], cavity);
    Patch<2> patch{mesh.stamp, {.vertex = {}, .place = Vec<2>{{0.5, 0}}}, cavity, {}};
    StarWorkspace<2> workspace;
    if (star(mesh, cavity, {}, workspace, patch.star) != StarFailure::none) return 1;
    auto [changed, changes] = replace_cavities<2>(std::move(mesh), {&patch, 1}).value();
    std::printf("%zu triangles are %zu, %zu of them new\n", wheel.elements.size(), changed.element_count(),
                changes.elements.created.size());
    return check_consistency(changed, {}) && changed.element_count() == 12 ? 0 : 1;
}
