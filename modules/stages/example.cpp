// Example of camber.stages: finds the boundary of a square and proposes edge nodes with the mesh's own metric.
#include <cstddef>
#include <cstdio>
#include <optional>
#include <utility>

import camber.core;
import camber.bezier;
import camber.surface;
import camber.stages;

using namespace camber;

static Outcome<bool> example(const Execution& execution) {
    LinearMesh<2> square;
    square.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
    square.point_references = Buffer<Reference>(4, 0);
    square.elements.vertices =
        Buffer<SimplexVertices<2>>{{VertexId(0), VertexId(1), VertexId(2)}, {VertexId(0), VertexId(2), VertexId(3)}};
    square.elements.references = Buffer<Reference>(2, 1);
    square.facets.vertices = Buffer<SimplexVertices<1>>{
        {VertexId(0), VertexId(1)}, {VertexId(1), VertexId(2)}, {VertexId(2), VertexId(3)}, {VertexId(3), VertexId(0)}};
    square.facets.references = Buffer<Reference>(4, 1);
    const auto mesh = elevate(std::move(square), execution);
    if (!mesh) return fail(mesh.error());
    const auto boundary = find_boundary<2>(mesh->linear, mesh->edges, std::nullopt, {}, execution);
    if (!boundary) return fail(boundary.error());
    const auto proposed = propose_curves<2>({*mesh, NodesOf::elevation, *boundary}, natural_metric<2>(), {}, {},
                                            without_wrapper(execution));
    if (!proposed) return fail(proposed.error());
    std::printf("%zu corners, %zu edges with nodes\n", boundary->features.corners,
                proposed->curved.proposal.mid_nodes.size());
    return boundary->features.corners == 4 && proposed->curved.proposal.mid_nodes.size() == mesh->edges.size();
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
