// Example of camber.shapes: generates test domains from a few numbers. Equal options and `seed` give equal meshes.
#include <cmath>
#include <cstdio>
#include <numbers>

import camber.core;
import camber.shapes;

using namespace camber;

static double volume(const LinearMesh<3>& mesh) {
    double sum = 0;
    for (const auto& vertices : mesh.elements.vertices) sum += determinant(mesh.points, vertices) / 6;
    return sum;
}

static double worst_distance(const LinearMesh<3>& mesh, const ShellOptions<3>& options) {
    double worst = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const bool inner = mesh.facets.references[f] == options.inner_reference;
        const double radius = inner ? options.inner_radius : options.outer_radius;
        for (const VertexId v : mesh.facets.vertices[f])
            worst = std::fmax(worst, std::abs(distance(mesh.points[v], options.centre) - radius));
    }
    return worst;
}

int main() {
    // The volume between two spheres, with three thin layers on the inner sphere.
    const ShellOptions<3> options{.inner_radius = 1,
                                  .outer_radius = 2,
                                  .inner_size = 0.4,
                                  .outer_size = 0.5,
                                  .inner_layer = {.count = 3, .first_height = 0.02, .growth = 1.5}};
    const auto mesh = generate(options);
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    const double spheres = 4 * std::numbers::pi / 3 * (8 - 1);
    const double share = volume(*mesh) / spheres;
    const double off = worst_distance(*mesh, options);
    std::printf("%zu vertices, %zu tetrahedra, %zu boundary triangles\n", mesh->points.size(), mesh->elements.size(),
                mesh->facets.size());
    std::printf("%.1f %% of the volume between the spheres: straight facets cut the outer one\n", 100 * share);
    std::printf("boundary vertices are on their spheres to %.0e\n", off);

    // Incompatible sizes are an error.
    const auto refused = generate(ShellOptions<3>{.inner_radius = 2, .outer_radius = 1});
    if (!refused) std::printf("refused: %s\n", describe(refused.error()).c_str());
    return share > 0.9 && share < 1 && off < 1e-12 && !refused ? 0 : 1;
}
