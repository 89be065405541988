// Example of camber.recipes: a ring of straight triangles is curved, remeshed for its own metric, and checked.
#include <cstddef>
#include <cstdio>
#include <utility>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.recipes;

using namespace camber;

/// Ring between two circles about the origin: `n` quadrangles around, each split into two triangles.
static Mesh<2> ring(std::size_t n) {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> elements;
    const double step = 2 * 3.14159265358979323846 / static_cast<double>(n);
    for (const double radius : {1.0, 1.5})
        for (std::size_t i = 0; i < n; ++i) {
            const double angle = step * static_cast<double>(i);
            points.push_back({{radius * camber::cos(angle), radius * camber::sin(angle)}});
        }
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t next = (i + 1) % n;
        elements.push_back({VertexId(i), VertexId(n + i), VertexId(n + next)});
        elements.push_back({VertexId(i), VertexId(n + next), VertexId(next)});
    }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(elements.size(), 1);
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(elements);
    return as_mesh(std::move(mesh));
}

static Outcome<bool> example(const Execution& execution) {
    const StepWrapper around = without_wrapper(execution);
    const auto remeshed = remesh_mesh(ring(24), MeshGoal<2>{}, {}, around);
    if (!remeshed) return fail(remeshed.error());
    MeshGoal<2> goal{.metric = metric_at_vertices<2>(remeshed->remeshed->log_metrics),
                     .geometry = remeshed->remeshed->geometry};
    goal.boundary.features = listed_breaks<2>;
    const auto curved = curve_mesh(remeshed->mesh, goal, {}, around);
    if (!curved) return fail(curved.error());
    const auto check = check_mesh(curved->mesh, {}, around);
    if (!check) return fail(check.error());
    std::printf("%zu triangles, %s, the smallest scaled Jacobian %.3f\n", count_elements(curved->mesh),
                check->all_good() ? "sound and valid" : "not good", check->validation.smallest);
    return check->all_good();
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
