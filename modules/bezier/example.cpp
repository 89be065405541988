// camber.bezier: elevates a straight mesh to degree 2 and moves its boundary nodes onto a circle. The nodes of a mesh
// (LagrangeNode) lie on the curve; the control points of the Bernstein form (ControlPoint) do not. Therefore they are
// two types.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

import camber.core;
import camber.bezier;

using namespace camber;

/// Total area; the edge-midpoint rule is exact for det J of degree 2.
static double area(const QuadraticMesh<2>& mesh) {
    double sum = 0;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        for (const auto& xi : {Barycentric<2>{0.5, 0.5, 0}, Barycentric<2>{0, 0.5, 0.5}, Barycentric<2>{0.5, 0, 0.5}}) {
            const auto columns = element_of(mesh, ElementId(e)).derivatives(xi);
            sum += det(columns[0], columns[1]) / 6;
        }
    return sum;
}

static LinearMesh<2> hexagon() {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points(7, Vec<2>{});
    Buffer<SimplexVertices<2>> triangles(6);
    for (std::size_t i = 0; i < 6; ++i) {
        const double angle = std::numbers::pi / 3 * static_cast<double>(i);
        points[i + 1] = {{camber::cos(angle), camber::sin(angle)}};
        triangles[i] = {VertexId(std::size_t{0}), VertexId(i + 1), VertexId((i + 1) % 6 + 1)};
    }
    mesh.points = std::move(points);
    mesh.point_references = Buffer<Reference>(7, 0);
    mesh.elements.vertices = std::move(triangles);
    mesh.elements.references = Buffer<Reference>(6, 1);
    return mesh;
}

int main() {
    auto mesh = elevate(hexagon(), Execution{});
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    const double straight = area(*mesh);
    auto nodes = take(mesh->mid_nodes);  // the column's buffer, now mutable
    for (std::size_t e = 0; e < nodes.size(); ++e)
        if (mesh->edges.vertices[e][0].index() != 0)
            nodes[e].point = normalised(nodes[e].point);  // edges at vertex 0 stay
                                                          // straight
    mesh->mid_nodes = std::move(nodes);
    const double curved = area(*mesh);
    std::printf("area of the hexagon: %.4f, of six P2 triangles: %.4f, of the disc: %.4f\n", straight, curved,
                std::numbers::pi);
    return std::abs(straight - 1.5 * std::sqrt(3.0)) < 1e-14 && std::abs(curved - std::numbers::pi) < 2e-2 ? 0 : 1;
}
