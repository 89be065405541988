// Example of camber.recovery: recovers derivatives of a bump from its values on a lattice of quadratic triangles, and
// compares them with the exact derivatives.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.recovery;

using namespace camber;

static LinearMesh<2> square(std::size_t n) {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(j * (n + 1) + i); };
    for (std::size_t j = 0; j <= n; ++j)
        for (std::size_t i = 0; i <= n; ++i) {
            points.push_back(
                {{static_cast<double>(i) / static_cast<double>(n), static_cast<double>(j) / static_cast<double>(n)}});
            if (i == n || j == n) continue;
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(triangles.size(), 1);
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(triangles);
    return mesh;
}

static double bump(const Vec<2>& x) { return camber::exp(-2 * norm_squared(x)); }
static double bump_xxx(const Vec<2>& x) { return (48 * x[0] - 64 * x[0] * x[0] * x[0]) * bump(x); }

static Outcome<double> largest_error(const Execution& execution) {
    QuadraticMesh<2> mesh{square(24), {}, {}};
    auto edges = unique_edges(mesh.linear, execution);
    if (!edges) return fail(edges.error());
    mesh.edges = std::move(*edges);
    Buffer<double> values;
    for (const Vec<2>& x : mesh.linear.points) values.push_back(bump(x));
    Buffer<LagrangeNode<2>> nodes;
    for (const auto& [a, b] : mesh.edges.vertices) {
        nodes.push_back({0.5 * (mesh.linear.points[a] + mesh.linear.points[b])});
        values.push_back(bump(nodes.back().point));
    }
    mesh.mid_nodes = std::move(nodes);
    const std::array fields{Column<double>(std::move(values))};
    const auto recovered = recover_derivatives<2>(mesh, fields, {}, execution);
    if (!recovered) return fail(recovered.error());
    double largest = 0;
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v) {
        const std::size_t row = recovered->rows.first(VertexId(v));
        const double error = recovered->fields[0].thirds[row](0, 0, 0) - bump_xxx(mesh.linear.points[v]);
        largest = std::max(largest, std::abs(error));
    }
    std::printf("%zu rows, %zu of them from inner ones; u_xxx is off by at most %.3g\n", recovered->rows.size(),
                recovered->from_inner_fits, largest);
    return largest;
}

int main() {
    const auto error = largest_error(Execution{});
    if (!error) std::fprintf(stderr, "%s\n", describe(error.error()).c_str());
    return error && *error < 0.5 ? 0 : 1;
}
