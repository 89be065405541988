// Measures and simplices of a mesh, independent of its numbering.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "meshes.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

template <int D>
double volume_of(const DynamicMesh<D>& mesh, const SimplexVertices<D>& v) {
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = mesh.points[v[i]];
    return orientation(p);
}

/// Sums over simplices of a dimension, by reference.
using Sizes = std::map<std::pair<int, Reference>, double>;

/// Area of facets and length of lines by reference, volume by material: invariants of a flat domain.
template <int D>
Sizes measures(const DynamicMesh<D>& mesh) {
    Sizes sums;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)))
            sums[{D, mesh.elements.references[e]}] += volume_of(mesh, mesh.elements.vertices[e]);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.is_free(FacetId(f))) continue;
        const auto& v = mesh.facets.vertices[f];
        const Vec<D> side = mesh.points[v[1]] - mesh.points[v[0]];
        if constexpr (D == 2)
            sums[{1, mesh.facets.references[f]}] += norm(side);
        else
            sums[{2, mesh.facets.references[f]}] += norm(cross(side, mesh.points[v[2]] - mesh.points[v[0]]));
    }
    for (std::size_t l = 0; l < mesh.lines.size(); ++l)
        if (!mesh.is_free(LineId(l))) {
            const auto& [a, b] = mesh.edges[mesh.lines[l]];
            sums[{0, mesh.line_references[l]}] += distance(mesh.points[a], mesh.points[b]);
        }
    return sums;
}

/// The simplices as coordinates of their vertices, independent of the numbering.
template <int D>
auto by_places(const DynamicMesh<D>& mesh) {
    std::vector<std::vector<std::array<double, D>>> all;
    const auto add = [&](const auto& vertices, Reference reference) {
        std::vector<std::array<double, D>> simplex;
        simplex.reserve(vertices.size() + 1);
        for (const VertexId v : vertices) simplex.push_back(mesh.points[v].c);
        std::sort(simplex.begin(), simplex.end());
        simplex.push_back({static_cast<double>(reference)});
        all.push_back(std::move(simplex));
    };
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e))) add(mesh.elements.vertices[e], mesh.elements.references[e]);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!mesh.is_free(FacetId(f))) add(mesh.facets.vertices[f], mesh.facets.references[f]);
    for (std::size_t l = 0; l < mesh.lines.size(); ++l)
        if (!mesh.is_free(LineId(l))) add(mesh.edges[mesh.lines[l]], mesh.line_references[l]);
    std::sort(all.begin(), all.end());
    return all;
}

}  // namespace camber::testing
