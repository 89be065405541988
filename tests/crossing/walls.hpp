// Surface meshes and their crossings for the tests.
#pragma once

#include <doctest/doctest.h>

#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.crossing;

namespace camber::testing {

/// A surface of triangles (a curve of edges) whose mid nodes are the mapped middles of chords.
template <int D, class Place>
QuadraticMesh<D> wall_of(std::vector<Vec<D>> points, std::vector<SimplexVertices<D - 1>> facets, Place&& place) {
    LinearMesh<D> mesh;
    mesh.points = Buffer<Vec<D>>(points.begin(), points.end());
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.facets.references = Buffer<Reference>(facets.size(), 1);
    mesh.facets.vertices = Buffer<SimplexVertices<D - 1>>(facets.begin(), facets.end());
    auto curved = elevate(std::move(mesh), Execution{});
    REQUIRE(curved.has_value());
    Buffer<LagrangeNode<D>> nodes = take(std::move(curved->mid_nodes));
    for (LagrangeNode<D>& node : nodes) node.point = place(node.point);
    curved->mid_nodes = std::move(nodes);
    return std::move(*curved);
}

inline Crossings crossings_of(const auto& mesh, int threads = 1) {
    auto found = find_crossings(mesh, Execution{.threads = threads});
    REQUIRE(found.has_value());
    return *found;
}

}  // namespace camber::testing
