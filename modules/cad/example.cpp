// camber.cad: projects the boundary of a straight mesh (an octahedron) onto the CAD model of the unit ball.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

import camber.core;
import camber.bezier;
import camber.surface;
import camber.cad;

using namespace camber;

/// A BREP file of the unit ball, written by OpenCASCADE.
static constexpr const char* ball = R"(
DBRep_DrawableShape

CASCADE Topology V3, (c) Open Cascade
Locations 0
Curve2ds 4
1 0 1.5707963267948966 1 0 
1 6.2831853071795862 -6.2831853071795862 0 1 
1 0 -6.2831853071795862 0 1 
1 0 -1.5707963267948966 1 0 
Curves 1
2 0 0 0 -2.4492935982947064e-16 -1 0 1 -2.4492935982947064e-16 0 0 0 1 1
Polygon3D 0
PolygonOnTriangulations 0
Surfaces 1
4 0 0 0 0 0 1 1 0 -0 -0 1 0 1
Triangulations 0

TShapes 9
Ve
1e-07
6.12323399573677e-17 -1.49975978266186e-32 1
0 0

0101101
*
Ed
 1e-07 1 1 1
2  1 1 0 0 6.28318530717959
0

0101000
+9 0 -9 0 *
Ve
1e-07
6.12323399573677e-17 -1.49975978266186e-32 -1
0 0

0101101
*
Ed
 1e-07 1 1 0
1  1 0 4.71238898038469 7.85398163397448
3  2 3CN 1 0 4.71238898038469 7.85398163397448
0

0101000
-9 0 +7 0 *
Ed
 1e-07 1 1 1
2  4 1 0 0 6.28318530717959
0

0101000
+7 0 -7 0 *
Wi

0101100
-8 0 +6 0 +5 0 -6 0 *
Fa
0  1e-07 1 0

0111000
+4 0 *
Sh

0101100
+3 0 *
So

1100000
+2 0 *

+1 0 
)";

/// Eight tetrahedra around vertex 0, which is the origin.
static LinearMesh<3> octahedron() {
    const auto v = [](std::size_t i) { return VertexId(i); };
    Buffer<SimplexVertices<3>> elements;
    Buffer<SimplexVertices<2>> facets;
    const std::array<std::size_t, 4> around{1, 3, 2, 4};  // vertices at +x, +y, -x, -y
    for (std::size_t i = 0; i < 4; ++i) {
        const VertexId a = v(around[i]), b = v(around[(i + 1) % 4]);
        facets.push_back({a, b, v(5)});
        facets.push_back({b, a, v(6)});
    }
    for (const auto& [a, b, c] : facets) elements.push_back({v(0), a, b, c});
    LinearMesh<3> mesh;
    mesh.point_references = Buffer<Reference>(7, 0);
    mesh.points = Buffer<Vec<3>>{{}, {{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}};
    mesh.elements = {std::move(elements), Buffer<Reference>(8, 1), {}};
    mesh.facets = {std::move(facets), Buffer<Reference>(8, 1), {}};
    return mesh;
}

static Outcome<bool> example(const CadModel& model, const Execution& execution) {
    const auto mesh = elevate(octahedron(), execution);
    if (!mesh) return fail(mesh.error());
    auto association = associate(mesh->linear, mesh->edges, model, execution);
    if (!association) return fail(association.error());
    const Geometry<3> geometry(CadGeometry{model, std::move(*association), mesh->linear});
    const FeatureOptions<3> smooth{.ridge_angle_degrees = 90};
    const auto features = find_features(mesh->linear, mesh->edges, smooth, execution);
    if (!features) return fail(features.error());
    const auto nodes = boundary_nodes(*mesh, *features, geometry, execution);
    if (!nodes) return fail(nodes.error());
    double farthest = 0;
    for (const auto& edges : mesh->edges.of_facets)
        for (const EdgeId e : edges) farthest = std::fmax(farthest, std::abs(1 - norm((*nodes)[e.index()].point)));
    std::printf("%zu face, %zu edge; nodes of the boundary are off the sphere by %.1e\n", model.faces(), model.edges(),
                farthest);
    return farthest < 1e-14;
}

int main() {
    const auto path = std::filesystem::temp_directory_path() / "camber-example-cad.brep";
    std::ofstream(path) << ball;
    const auto model = read_cad(path.string(), CadOptions{});
    std::filesystem::remove(path);
    // If OpenCASCADE is not available, the message contains a remedy.
    if (!model) std::printf("%s\n", describe(model.error()).c_str());
    if (!model) return !has_cad_support() && model.error().kind == ErrorKind::unsupported ? 0 : 1;
    const auto right = example(*model, Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
