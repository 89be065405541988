// Example of camber.drawing: finds the visible faces of a mesh, without and with a cutting plane.
#include <array>
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.drawing;

using namespace camber;

/// Two tetrahedra with a common face, one above and one below this face.
static Outcome<Mesh<3>> two_tetrahedra() {
    LinearMesh<3> mesh;
    mesh.points = Buffer<Vec<3>>{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}};
    const auto v = [](std::size_t i) { return VertexId(i); };
    mesh.elements.vertices = Buffer<SimplexVertices<3>>{{v(0), v(1), v(2), v(3)}, {v(0), v(2), v(1), v(4)}};
    mesh.elements.references = Buffer<Reference>{1, 2};
    return elevate(as_mesh(std::move(mesh)), 2, Execution{});
}

int main() {
    const auto mesh = two_tetrahedra();
    if (!mesh) return 1;
    const auto selected =
        elements_inside_cut(Cut<3>{{{0, 0, 1}}, 0}, *mesh, Execution{});  // removes the upper tetrahedron
    if (!selected) return 1;
    const auto whole = faces_to_draw(*mesh, {}, Execution{}), cut = faces_to_draw(*mesh, selected->view(), Execution{});
    if (!whole || !cut) return 1;
    const auto edges = edges_to_draw(*mesh, cut->view());
    std::printf("whole: %zu faces; cut: %zu faces, %zu edges\n", whole->size(), cut->size(), edges.size());
    return whole->size() == 6 && cut->size() == 4 && edges.size() == 6 ? 0 : 1;
}
