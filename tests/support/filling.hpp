// Tests if a patch fills its cavity.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "dynamic_measures.hpp"
#include "meshes.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

/// Volume, area or length of a simplex, up to a factor that depends on the dimension.
inline double size_of(const std::array<Vec<2>, 2>& p) { return distance(p[0], p[1]); }
inline double size_of(const std::array<Vec<3>, 3>& p) { return norm(cross(p[1] - p[0], p[2] - p[0])); }
inline double size_of(const std::array<Vec<3>, 2>& p) { return distance(p[0], p[1]); }

/// True if no element of the star is inverted and the star fills the cavity, reference by reference.
template <int D>
bool fills(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    const VertexId p = patch.point.vertex;
    const Vec<D> place = patch.point.place ? *patch.point.place : mesh.points[p];
    Sizes sums;
    const auto add = [&](const auto& vertices, Reference reference, VertexId replaced, double sign) {
        constexpr std::size_t n = std::tuple_size_v<std::remove_cvref_t<decltype(vertices)>>;
        std::array<Vec<D>, n> q;
        for (std::size_t i = 0; i < n; ++i) {
            const bool at_point = vertices[i] == replaced || (sign > 0 && vertices[i] == p);
            q[i] = at_point ? place : mesh.points[vertices[i]];
        }
        double size = 0;
        if constexpr (n == D + 1)
            size = orientation(q);
        else
            size = size_of(q);
        sums[{static_cast<int>(n), reference}] += sign * size;
        return size;
    };
    for (const ElementId e : patch.removed.elements)
        add(mesh.elements.vertices[e], mesh.elements.references[e], VertexId(max_entities), -1);
    for (const ElementFace& open : patch.star.joined) {
        const auto& v = mesh.elements.vertices[open.element];
        if (!(add(v, mesh.elements.references[open.element], v[open.opposite], 1) > 1e-7)) return false;
    }
    for (const FacetId f : patch.removed.facets)
        add(mesh.facets.vertices[f], mesh.facets.references[f], VertexId(max_entities), -1);
    for (const auto& [f, opposite] : patch.star.facets)
        add(mesh.facets.vertices[f], mesh.facets.references[f], mesh.facets.vertices[f][opposite], 1);
    if constexpr (D == 3) {
        for (const LineId l : patch.removed.lines)
            add(mesh.edges[mesh.lines[l]], mesh.line_references[l], VertexId(max_entities), -1);
        for (const auto& [l, opposite] : patch.star.lines)
            add(mesh.edges[mesh.lines[l]], mesh.line_references[l], mesh.edges[mesh.lines[l]][opposite], 1);
    }
    return std::ranges::all_of(sums, [](const auto& sum) { return std::abs(sum.second) < 1e-10; });
}

}  // namespace camber::testing
