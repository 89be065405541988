// Example of camber.ordering: improves the order of a triangle grid in random order, then restores the original order.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <random>
#include <utility>

import camber.core;
import camber.ordering;

using namespace camber;

/// A grid of n by n squares, each cut into two triangles.
static LinearMesh<2> grid(std::size_t n) {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(i * (n + 1) + j); };
    for (std::size_t i = 0; i <= n; ++i)
        for (std::size_t j = 0; j <= n; ++j) {
            points.push_back({{static_cast<double>(i), static_cast<double>(j)}});
            if (i == n || j == n) continue;
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(triangles.size(), 0);
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(triangles);
    return mesh;
}

template <class EntityId>
static Column<EntityId> any_order(std::size_t count) {
    Buffer<EntityId> ids(count);
    for (std::size_t i = 0; i < count; ++i) ids[i] = EntityId(i);
    std::shuffle(ids.begin(), ids.end(), std::mt19937(1));
    return ids;
}

static Outcome<bool> example(const Execution& execution) {
    const LinearMesh<2> mesh = grid(100);
    auto vertices = permutation(any_order<VertexId>(mesh.points.size()), execution);
    auto elements = permutation(any_order<ElementId>(mesh.elements.size()), execution);
    if (!vertices || !elements) return fail((vertices ? elements.error() : vertices.error()));
    const auto input = renumbered(mesh, {std::move(*vertices), std::move(*elements)}, execution);
    if (!input) return fail(input.error());

    // The default minimum would skip this small mesh.
    const auto better = better_order(*input, {.min_elements = 1000}, execution);
    if (!better) return fail(better.error());
    if (!*better) return false;
    const Renumbering& order = (*better)->renumbering;
    const auto ordered = renumbered(*input, order, execution);
    if (!ordered) return fail(ordered.error());
    const auto after = scatter(*ordered, execution);
    if (!after) return fail(after.error());
    std::printf("scatter: %.4f as given, %.4f along the curve\n", (*better)->scatter, *after);

    // A program computes on the ordered mesh, then restores the original numbers in the result.
    const auto back = renumbered(*ordered, inverse(order), execution);
    if (!back) return fail(back.error());
    return *back == *input && *after < 0.1 * (*better)->scatter;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
